//! Linear equations weighted by instruments, by rotations.

use super::triangle::Triangle;
use rarma_core::real::Real;

/// Σ ζ(t)·[y(t) − φ(t)ᵀθ] = 0 for n ≤ N unknowns.
///
/// The rotations that bring Z into triangular form R = QᵀZ are applied to Φ and y too:
/// (QᵀΦ)·θ = Qᵀy is the same as ZᵀΦ·θ = Zᵀy without the squared condition number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruments<T, const N: usize> {
    r: [[T; N]; N],
    phi: [[T; N]; N],
    y: [T; N],
    n: usize,
}

impl<T: Real, const N: usize> Instruments<T, N> {
    /// No equation yet; n ≤ N is the caller's to keep.
    pub fn new(n: usize) -> Self {
        Self {
            r: [[T::ZERO; N]; N],
            phi: [[T::ZERO; N]; N],
            y: [T::ZERO; N],
            n: n.min(N),
        }
    }

    /// Takes one sample; the rows are used up.
    pub fn add(&mut self, zeta: &mut [T; N], phi: &mut [T; N], mut y: T) {
        let n = self.n;
        for i in 0..n {
            let (d, z) = (self.r[i][i], zeta[i]);
            let length = (d * d + z * z).sqrt();
            if z == T::ZERO || !(length > T::ZERO) {
                continue;
            }
            let inverse = T::ONE / length;
            let (cos, sin) = (d * inverse, z * inverse);
            self.r[i][i] = length;
            let turn = |kept: &mut T, new: &mut T| {
                (*kept, *new) = (cos * *kept + sin * *new, cos * *new - sin * *kept);
            };
            for (kept, new) in self.r[i][i + 1..n].iter_mut().zip(&mut zeta[i + 1..n]) {
                turn(kept, new);
            }
            for (kept, new) in self.phi[i][..n].iter_mut().zip(&mut phi[..n]) {
                turn(kept, new);
            }
            turn(&mut self.y[i], &mut y);
        }
    }

    /// θ, by elimination with pivots; none if the instruments do not determine it.
    pub fn solve(&self) -> Option<[T; N]> {
        let n = self.n;
        let (mut m, mut y) = (self.phi, self.y);
        let size = m[..n]
            .iter()
            .flat_map(|row| &row[..n])
            .fold(T::ZERO, |most, x| most.max(x.abs()));
        for k in 0..n {
            let pivot = (k + 1..n).fold(k, |best, i| {
                if m[i][k].abs() > m[best][k].abs() {
                    i
                } else {
                    best
                }
            });
            if !(m[pivot][k].abs() > size * T::EPSILON) {
                return None;
            }
            m.swap(pivot, k);
            y.swap(pivot, k);
            for i in k + 1..n {
                let factor = m[i][k] / m[k][k];
                for j in k..n {
                    let x = m[k][j];
                    m[i][j] -= factor * x;
                }
                let x = y[k];
                y[i] -= factor * x;
            }
        }
        let mut out = [T::ZERO; N];
        for i in (0..n).rev() {
            let mut sum = y[i];
            for j in i + 1..n {
                sum -= m[i][j] * out[j];
            }
            out[i] = sum / m[i][i];
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }

    /// (ZᵀZ)⁻¹; none if the instruments depend on each other.
    pub fn inverse_normal(&self) -> Option<[[T; N]; N]> {
        let mut triangle = Triangle::<T, N>::new(self.n);
        for row in self.r[..self.n].iter() {
            let _ = triangle.add(&mut row.clone(), T::ZERO);
        }
        triangle.inverse_normal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_instrumental_equations() {
        let mut rotated = Instruments::<f64, 3>::new(3);
        let (mut zz, mut zp, mut zy) = ([[0.0; 3]; 3], [[0.0; 3]; 3], [0.0; 3]);
        for t in 0..40 {
            let zeta: [f64; 3] = core::array::from_fn(|i| libm::sin((t * (i + 2)) as f64));
            let noise: [f64; 3] = core::array::from_fn(|i| libm::cos((t * t + 3 * i) as f64));
            let phi: [f64; 3] = core::array::from_fn(|i| zeta[i] + 0.5 * noise[i]);
            let y = phi[0] - 2.0 * phi[1] + 0.5 * phi[2] + noise[1];
            for i in 0..3 {
                for j in 0..3 {
                    zz[i][j] += zeta[i] * zeta[j];
                    zp[i][j] += zeta[i] * phi[j];
                }
                zy[i] += zeta[i] * y;
            }
            rotated.add(&mut zeta.clone(), &mut phi.clone(), y);
        }
        let theta = rotated.solve().expect("regular");
        let inverse = rotated.inverse_normal().expect("regular");
        for i in 0..3 {
            let sum: f64 = (0..3).map(|j| zp[i][j] * theta[j]).sum();
            assert!((sum - zy[i]).abs() < 1e-10);
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| zz[i][k] * inverse[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-10);
            }
        }
        assert!(Instruments::<f64, 2>::new(2).solve().is_none());
    }
}
