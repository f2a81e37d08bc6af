//! Eigenvalues of small matrices: symmetric by rotations, and the characteristic
//! polynomial of any.
//!
//! Short own code instead of a library: the sizes are run-time values below a
//! capacity, nothing may allocate, and only these two are needed.

use rarma_core::real::Real;

/// Sweeps over all pairs; seven do for 48 columns in `f64`.
const SWEEPS: u32 = 40;

/// Jacobi's rotations on the symmetric n×n matrix `s`: leaves the eigenvalues on its
/// diagonal and puts the eigenvectors into the columns of `vectors`, unsorted.
/// False if it does not settle, which only input that is not finite causes.
pub(super) fn jacobi<T: Real, const N: usize>(
    s: &mut [[T; N]; N],
    vectors: &mut [[T; N]; N],
    n: usize,
) -> bool {
    for (i, row) in vectors[..n].iter_mut().enumerate() {
        row[..n].fill(T::ZERO);
        row[i] = T::ONE;
    }
    let total: T = s[..n].iter().flat_map(|r| &r[..n]).map(|x| *x * *x).sum();
    if !total.is_finite() {
        return false;
    }
    let small = T::EPSILON * T::EPSILON * total;
    for _ in 0..SWEEPS {
        let mut off = T::ZERO;
        for i in 0..n {
            for j in i + 1..n {
                off += s[i][j] * s[i][j];
            }
        }
        if off <= small {
            return true;
        }
        for i in 0..n {
            for j in i + 1..n {
                rotate(s, vectors, n, i, j);
            }
        }
    }
    false
}

/// Makes s(i, j) zero.
fn rotate<T: Real, const N: usize>(
    s: &mut [[T; N]; N],
    vectors: &mut [[T; N]; N],
    n: usize,
    i: usize,
    j: usize,
) {
    let off = s[i][j];
    if off == T::ZERO {
        return;
    }
    // tan of the smaller angle with cot 2φ = (s_jj − s_ii)/2s_ij.
    let cot = (s[j][j] - s[i][i]) / (off + off);
    let size = T::ONE / (cot.abs() + (cot * cot + T::ONE).sqrt());
    let tan = if cot < T::ZERO { -size } else { size };
    let cos = T::ONE / (tan * tan + T::ONE).sqrt();
    let sin = tan * cos;
    for row in s[..n].iter_mut() {
        (row[i], row[j]) = (cos * row[i] - sin * row[j], sin * row[i] + cos * row[j]);
    }
    for k in 0..n {
        let (x, y) = (s[i][k], s[j][k]);
        (s[i][k], s[j][k]) = (cos * x - sin * y, sin * x + cos * y);
    }
    (s[i][j], s[j][i]) = (T::ZERO, T::ZERO);
    for row in vectors[..n].iter_mut() {
        (row[i], row[j]) = (cos * row[i] - sin * row[j], sin * row[i] + cos * row[j]);
    }
}

/// Coefficients a₁…a_n of det(zI − M) = zⁿ + a₁zⁿ⁻¹ + …; `m` is used up.
///
/// Similarity to Hessenberg form by elimination with pivots, then the recurrence of
/// its leading minors, backward stable enough for n ≤ 30 with roots near the circle.
pub(super) fn characteristic<T: Real, const N: usize>(m: &mut [[T; N]; N], n: usize) -> [T; N] {
    for k in 0..n.saturating_sub(2) {
        let pivot = (k + 1..n).fold(k + 1, |best, i| {
            if m[i][k].abs() > m[best][k].abs() {
                i
            } else {
                best
            }
        });
        if m[pivot][k] == T::ZERO {
            continue;
        }
        m.swap(pivot, k + 1);
        for row in m[..n].iter_mut() {
            row.swap(pivot, k + 1);
        }
        for i in k + 2..n {
            let factor = m[i][k] / m[k + 1][k];
            for j in 0..n {
                let x = m[k + 1][j];
                m[i][j] -= factor * x;
            }
            for row in m[..n].iter_mut() {
                let x = row[i];
                row[k + 1] += factor * x;
            }
        }
    }
    // minors[k]: coefficients of the characteristic polynomial of the leading k×k
    // block after the leading 1.
    let mut minors = [[T::ZERO; N]; N];
    for k in 1..=n {
        let mut next = [T::ZERO; N];
        let before = |minors: &[[T; N]; N], k: usize, i: usize| match (k, i) {
            (_, 0) => T::ONE,
            (0, _) => T::ZERO,
            _ => minors[k - 1][i - 1],
        };
        // z·p_{k−1} − h_kk·p_{k−1}
        for i in 1..=k {
            if i < k {
                next[i - 1] += before(&minors, k - 1, i);
            }
            next[i - 1] -= m[k - 1][k - 1] * before(&minors, k - 1, i - 1);
        }
        let mut chain = T::ONE;
        for j in (1..k).rev() {
            chain *= m[j][j - 1];
            let weight = chain * m[j - 1][k - 1];
            // p_{j−1} has degree j − 1: its leading term is that of z^(j−1).
            for i in 0..j {
                next[k - j + i] -= weight * before(&minors, j - 1, i);
            }
        }
        minors[k - 1] = next;
    }
    if n == 0 { [T::ZERO; N] } else { minors[n - 1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(i: usize, j: usize) -> f64 {
        libm::sin((3 + 7 * i + 5 * j + i * j) as f64)
    }

    #[test]
    fn symmetric_matrix_is_taken_apart_and_put_together() {
        const N: usize = 12;
        let full: [[f64; N]; N] =
            core::array::from_fn(|i| core::array::from_fn(|j| sample(i, j) + sample(j, i)));
        let (mut s, mut v) = (full, [[0.0; N]; N]);
        assert!(jacobi(&mut s, &mut v, N));
        for i in 0..N {
            for j in 0..N {
                let back: f64 = (0..N).map(|k| v[i][k] * s[k][k] * v[j][k]).sum();
                assert!((back - full[i][j]).abs() < 1e-12);
                let unit: f64 = (0..N).map(|k| v[k][i] * v[k][j]).sum();
                assert!((unit - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
        let mut lost = [[f64::NAN; 3]; 3];
        assert!(!jacobi(&mut lost, &mut [[0.0; 3]; 3], 3));
    }

    #[test]
    fn characteristic_polynomial_is_the_determinant() {
        const N: usize = 6;
        let full: [[f64; N]; N] = core::array::from_fn(|i| core::array::from_fn(|j| sample(i, j)));
        let a = characteristic(&mut full.clone(), N);
        for z in [-2.0, -0.3, 0.0, 1.0, 2.5] {
            let mut value = 1.0;
            for x in a {
                value = value * z + x;
            }
            // det by elimination
            let mut m = full;
            for (i, row) in m.iter_mut().enumerate() {
                for (j, x) in row.iter_mut().enumerate() {
                    *x = f64::from(u8::from(i == j)) * z - *x;
                }
            }
            let mut det = 1.0;
            for k in 0..N {
                det *= m[k][k];
                for i in k + 1..N {
                    let f = m[i][k] / m[k][k];
                    for j in k..N {
                        m[i][j] -= f * m[k][j];
                    }
                }
            }
            assert!((value - det).abs() < 1e-9 * det.abs().max(1.0), "{z}");
        }
        // A companion matrix gives its polynomial back.
        let mut companion = [[0.0; 4]; 4];
        companion[0] = [1.1, -0.95, 0.805, -0.76];
        for i in 1..4 {
            companion[i][i - 1] = 1.0;
        }
        let a = characteristic(&mut companion, 4);
        for (x, y) in a.iter().zip([-1.1, 0.95, -0.805, 0.76]) {
            assert!((x - y).abs() < 1e-14);
        }
    }
}
