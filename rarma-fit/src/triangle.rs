//! Least squares one equation at a time, by rotations.
//!
//! Keeps the triangular factor R of the equations seen so far (Givens rotations).
//! RᵀR is the normal matrix, but it is never formed: the condition number is that
//! of the equations and not its square, which in `f32` is the difference between an
//! answer and none.

use rarma_core::real::Real;

/// Equations x·θ ≈ b for n ≤ N unknowns, in triangular form.
#[derive(Debug, Clone, Copy)]
pub struct Triangle<T, const N: usize> {
    /// Row i holds R(i, i..).
    pub(super) r: [[T; N]; N],
    /// Right-hand side after the rotations.
    pub(super) z: [T; N],
    pub(super) n: usize,
}

impl<T: Real, const N: usize> Triangle<T, N> {
    /// No equation, and no unknown.
    pub const BLANK: Self = Self {
        r: [[T::ZERO; N]; N],
        z: [T::ZERO; N],
        n: 0,
    };

    /// No equation yet, n unknowns; n ≤ N is the caller's to keep.
    pub fn new(n: usize) -> Self {
        Self {
            n: n.min(N),
            ..Self::BLANK
        }
    }

    /// Takes one equation x·θ = b; `x` is used up. Returns what is left of b: the
    /// sum of the squares of these is the sum of squared residuals.
    #[inline(always)]
    pub fn add(&mut self, x: &mut [T; N], mut b: T) -> T {
        // The compiler sees no further than this function: n ≤ N spares it the checks.
        let n = self.n.min(N);
        for i in 0..n {
            if x[i] == T::ZERO {
                continue;
            }
            let row = &mut self.r[i];
            let (d, y) = (row[i], x[i]);
            let length = (d * d + y * y).sqrt();
            if !(length > T::ZERO) {
                continue;
            }
            let inverse = T::ONE / length;
            let (cos, sin) = (d * inverse, y * inverse);
            row[i] = length;
            for (r, x) in row[i + 1..n].iter_mut().zip(&mut x[i + 1..n]) {
                let before = *r;
                *r = cos * before + sin * *x;
                *x = cos * *x - sin * before;
            }
            let before = self.z[i];
            self.z[i] = cos * before + sin * b;
            b = cos * b - sin * before;
        }
        b
    }

    /// Euclidean length of column i of the equations.
    pub fn column(&self, i: usize) -> T {
        let mut sum = T::ZERO;
        for row in self.r.iter().take(i.saturating_add(1)) {
            if let Some(x) = row.get(i) {
                sum += *x * *x;
            }
        }
        sum.sqrt()
    }

    /// Σz²: by how much the sum of squares falls from θ = 0 to the solution.
    pub fn explained(&self) -> T {
        self.z.iter().take(self.n).map(|z| *z * *z).sum()
    }

    /// The unknowns; none if a column depends on those before it.
    pub fn solve(&self) -> Option<[T; N]> {
        let mut out = [T::ZERO; N];
        if !self.is_regular() {
            return None;
        }
        let n = self.n.min(N);
        for i in (0..n).rev() {
            let mut sum = self.z[i];
            for (r, x) in self.r[i].iter().zip(&out).take(n).skip(i + 1) {
                sum -= *r * *x;
            }
            out[i] = sum / self.r[i][i];
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }

    /// The same equations in the first n unknowns only; what the others explained is
    /// residual then.
    pub fn leading(&self, n: usize) -> Self {
        Self {
            n: n.min(self.n),
            ..*self
        }
    }

    /// By how much unknown i, added to those before it, lowers the sum of squares.
    pub fn explained_by(&self, i: usize) -> T {
        self.z.get(i).map_or(T::ZERO, |z| *z * *z)
    }

    /// R⁻¹·u.
    pub fn back_substitute(&self, u: &[T; N]) -> Option<[T; N]> {
        Self { z: *u, ..*self }.solve()
    }

    /// Every diagonal element stands out from rounding.
    fn is_regular(&self) -> bool {
        let tolerance = T::EPSILON * T::from_f64(8.0);
        let diagonal = self.r.iter().enumerate().take(self.n);
        diagonal
            .filter_map(|(i, row)| Some((i, row.get(i)?)))
            .all(|(i, d)| d.abs() > tolerance * self.column(i))
    }

    /// Adds `weight` times the length of each column to its diagonal (Marquardt).
    pub fn damped(&self, weight: T) -> Self {
        let mut out = *self;
        for i in 0..self.n {
            let mut row = [T::ZERO; N];
            row[i] = weight * self.column(i);
            let _ = out.add(&mut row, T::ZERO);
        }
        out
    }

    /// (RᵀR)⁻¹, the inverse of the normal matrix; none if it is singular.
    pub fn inverse_normal(&self) -> Option<[[T; N]; N]> {
        if !self.is_regular() {
            return None;
        }
        let n = self.n.min(N);
        // Columns of R⁻¹ one by one; row i of the result of R⁻¹R⁻ᵀ.
        let mut inverse = [[T::ZERO; N]; N];
        for j in 0..n {
            inverse[j][j] = T::ONE / self.r[j][j];
            for i in (0..j).rev() {
                let mut sum = T::ZERO;
                for k in i + 1..j + 1 {
                    sum += self.r[i][k] * inverse[k][j];
                }
                inverse[i][j] = -sum / self.r[i][i];
            }
        }
        let mut out = [[T::ZERO; N]; N];
        for i in 0..n {
            for j in i..n {
                let mut sum = T::ZERO;
                for k in j..n {
                    sum += inverse[i][k] * inverse[j][k];
                }
                out[i][j] = sum;
                out[j][i] = sum;
            }
        }
        let finite = out.iter().flatten().all(|x| x.is_finite());
        finite.then_some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equation(k: usize) -> ([f64; 3], f64) {
        let x: [f64; 3] = core::array::from_fn(|i| libm::sin((3 * k + 5 * i + i * k) as f64));
        let b = 2.0 * x[0] - 0.5 * x[1] + 0.25 * x[2] + 0.1 * libm::cos(17.0 * k as f64);
        (x, b)
    }

    #[test]
    fn solves_as_the_normal_equations_do() {
        let mut triangle = Triangle::<f64, 3>::new(3);
        let (mut normal, mut right, mut bb, mut left) = ([[0.0; 3]; 3], [0.0; 3], 0.0, 0.0);
        for k in 0..50 {
            let (x, b) = equation(k);
            for i in 0..3 {
                for j in 0..3 {
                    normal[i][j] += x[i] * x[j];
                }
                right[i] += x[i] * b;
            }
            bb += b * b;
            let rest = triangle.add(&mut x.clone(), b);
            left += rest * rest;
        }
        let theta = triangle.solve().expect("regular");
        for i in 0..3 {
            let sum: f64 = (0..3).map(|j| normal[i][j] * theta[j]).sum();
            assert!((sum - right[i]).abs() < 1e-10);
        }
        assert!((bb - left - triangle.explained()).abs() < 1e-10);
        let inverse = triangle.inverse_normal().expect("regular");
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| normal[i][k] * inverse[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-10);
            }
            assert!((triangle.column(i).powi(2) - normal[i][i]).abs() < 1e-10);
        }
        let damped = triangle.damped(1e3).solve().expect("regular");
        assert!(damped.iter().all(|x| x.abs() < 1e-4));
    }

    #[test]
    fn dependent_columns_are_noticed() {
        let mut triangle = Triangle::<f32, 2>::new(2);
        for k in 0..20 {
            let x = libm::sinf(k as f32);
            let _ = triangle.add(&mut [x, 2.0 * x], 1.0);
        }
        assert!(triangle.solve().is_none() && triangle.inverse_normal().is_none());
        assert!(Triangle::<f32, 2>::new(2).solve().is_none());
    }
}
