//! The few dominant eigenvalues of a large map that is only known by what it does.

use nalgebra::linalg::Schur;
use nalgebra::{Complex, DMatrix, DVector};

/// Steps between two looks at the eigenvalues.
const BLOCK: usize = 12;
/// Longest basis. Slow turning with a root every few hertz needs the most.
const MOST: usize = 240;
/// Numbers in a basis at most: 64 MB.
const MOST_NUMBERS: usize = 8_000_000;
/// Steps of the QR iteration for each eigenvalue at most; ten are many.
const QR_STEPS: usize = 40;
/// Other forms of a matrix that are tried where the iteration runs in a circle.
const MIRRORS: u64 = 4;
/// Relative change of the wanted eigenvalues that ends the iteration.
const TOLERANCE: f64 = 1e-9;

/// Dominant eigenvalues and their vectors.
pub(super) struct Dominant {
    /// By falling modulus; of a pair only the one with positive imaginary part.
    pub values: Vec<Complex<f64>>,
    /// The map leaves the range of numbers: there are no values.
    pub overflows: bool,
    /// There are none because the map takes everything to 0.
    pub at_rest: bool,
    /// Multiplications it took beside those of the map, about, and uses of the map.
    pub work: f64,
    pub maps: usize,
    basis: Vec<Vec<f64>>,
    small: DMatrix<f64>,
}

/// Arnoldi iteration with full orthogonalisation (twice), from a fixed start.
pub(super) fn dominant(
    n: usize,
    wanted: usize,
    mut map: impl FnMut(&[f64]) -> Vec<f64>,
) -> Dominant {
    let most = MOST.min(n).min(MOST_NUMBERS / n.max(1)).max(1);
    let mut work = 0.0;
    let mut h = DMatrix::<f64>::zeros(most + 1, most);
    let mut basis = vec![start(n)];
    let mut before: Vec<Complex<f64>> = Vec::new();
    for k in 0..most {
        let mut w = map(&basis[k]);
        let size = norm(&w);
        if !size.is_finite() {
            return Dominant::none(true, work, k + 1);
        }
        work += 4.0 * (n * (k + 1)) as f64;
        for _ in 0..2 {
            for (j, v) in basis.iter().enumerate() {
                let d = dot(v, &w);
                h[(j, k)] += d;
                for (x, y) in w.iter_mut().zip(v) {
                    *x -= d * y;
                }
            }
        }
        let rest = norm(&w);
        h[(k + 1, k)] = rest;
        let exhausted = !(rest > 1e-13 * size) || k + 1 == most;
        if exhausted || (k + 1) % BLOCK == 0 {
            let small = h.view((0, 0), (k + 1, k + 1)).into_owned();
            work += 25.0 * ((k + 1) as f64).powi(3);
            // Where the small problem does not settle, a larger one may.
            let Some(values) = largest(&small, wanted) else {
                if exhausted {
                    break;
                }
                basis.push(w.iter().map(|x| x / rest).collect());
                continue;
            };
            let settled = values.len() == before.len()
                && values
                    .iter()
                    .zip(&before)
                    .all(|(x, y)| (x - y).norm() <= TOLERANCE * (1.0 + x.norm()));
            if exhausted || settled {
                return Dominant {
                    values,
                    overflows: false,
                    at_rest: small.amax() == 0.0,
                    work,
                    maps: k + 1,
                    basis,
                    small,
                };
            }
            before = values;
        }
        basis.push(w.iter().map(|x| x / rest).collect());
    }
    Dominant::none(false, work, most)
}

impl Dominant {
    fn none(overflows: bool, work: f64, maps: usize) -> Self {
        Self {
            values: Vec::new(),
            overflows,
            at_rest: false,
            work,
            maps,
            basis: Vec::new(),
            small: DMatrix::zeros(0, 0),
        }
    }

    /// Real and imaginary part of the eigenvector of `values[i]`, by one inverse
    /// iteration on the small matrix.
    pub(super) fn vector(&self, i: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let k = self.small.nrows();
        let value = *self.values.get(i)?;
        // A shift next to the eigenvalue: the matrix stays regular.
        let shift = value + Complex::new(1e-9, 1e-9) * (1.0 + value.norm());
        let matrix = self.small.map(|x| Complex::new(x, 0.0))
            - DMatrix::<Complex<f64>>::identity(k, k) * shift;
        let lu = matrix.lu();
        let mut y = DVector::from_element(k, Complex::new(1.0, 0.0));
        for _ in 0..3 {
            y = lu.solve(&y)?;
            let size = y.norm();
            y /= Complex::new(size, 0.0);
        }
        let n = self.basis.first()?.len();
        let (mut re, mut im) = (vec![0.0; n], vec![0.0; n]);
        for (v, c) in self.basis.iter().zip(y.iter()) {
            for (j, x) in v.iter().enumerate() {
                re[j] += c.re * x;
                im[j] += c.im * x;
            }
        }
        Some((re, im))
    }
}

/// None where the iteration does not settle.
fn largest(small: &DMatrix<f64>, wanted: usize) -> Option<Vec<Complex<f64>>> {
    let scale = small.amax();
    if !(scale > 0.0) || !scale.is_finite() {
        return Some(Vec::new());
    }
    let mut all = eigenvalues(small)?;
    all.retain(|z| z.im >= 0.0);
    all.sort_by(|x, y| y.norm().total_cmp(&x.norm()));
    all.truncate(wanted);
    Some(all)
}

/// All eigenvalues, in a bounded number of steps.
///
/// The shifts of nalgebra's QR iteration can run in a circle for ever, and it has no
/// other ones for that case. They depend on the form of the matrix, its eigenvalues do
/// not: seen in a mirror, the same matrix leads out of the circle.
fn eigenvalues(small: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let n = small.nrows();
    (0..MIRRORS).find_map(|turn| {
        let seen = match turn {
            0 => small.clone(),
            turn => mirrored(small, &direction(n, turn)),
        };
        let schur = Schur::try_new(seen, f64::EPSILON, QR_STEPS * n)?;
        let values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
        values
            .iter()
            .all(|z| z.re.is_finite() && z.im.is_finite())
            .then_some(values)
    })
}

/// H·A·H with H = 1 - 2·v·vᵀ, which is its own inverse.
fn mirrored(a: &DMatrix<f64>, v: &[f64]) -> DMatrix<f64> {
    let v = DVector::from_column_slice(v);
    let left = a - 2.0 * &v * (v.transpose() * a);
    let across = &left * &v;
    left - 2.0 * across * v.transpose()
}

/// A fixed vector without symmetry.
fn start(n: usize) -> Vec<f64> {
    direction(n, 0)
}

/// One of several fixed vectors of length 1 without symmetry.
fn direction(n: usize, which: u64) -> Vec<f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64 ^ which;
    let v: Vec<f64> = (0..n)
        .map(|_| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
        .collect();
    let size = norm(&v);
    v.iter().map(|x| x / size).collect()
}

/// In four lanes, or each product would wait for the sum before it.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (chunks, others) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = chunks.remainder().iter().zip(others.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in chunks.zip(others) {
        for ((lane, x), y) in lanes.iter_mut().zip(x).zip(y) {
            *lane += x * y;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shift of all places by one: the QR iteration leaves it as it is.
    #[test]
    fn a_circle_of_the_iteration_is_left() {
        for n in [3, 4, 5, 24, 60] {
            let ring = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
            let values = eigenvalues(&ring).expect("settles");
            assert_eq!(values.len(), n);
            for k in 0..n {
                let root = Complex::from_polar(1.0, core::f64::consts::TAU * k as f64 / n as f64);
                let nearest = values.iter().map(|z| (z - root).norm()).fold(9.0, f64::min);
                assert!(nearest < 1e-9, "{n}: {root} is {nearest} away");
            }
        }
    }

    #[test]
    fn what_has_no_values_ends() {
        let broken = DMatrix::from_element(4, 4, f64::NAN);
        assert_eq!(eigenvalues(&broken), None);
    }
}
