//! A quantity of the angle as a short Fourier series: what takes the noise off a
//! stiffness diagram.

use super::error::LdbbError;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Highest order.
pub const MAX_ORDER: usize = 6;
const TERMS: usize = 2 * MAX_ORDER + 1;

/// f(θ) = a0 + Σ a_n·cos nθ + b_n·sin nθ, n up to 6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonics<T> {
    /// a0, a1, b1, a2, b2, …
    coefficients: [T; TERMS],
    inverse: [[T; TERMS]; TERMS],
    order: usize,
    scatter: T,
}

impl<T: Real> Harmonics<T> {
    /// Least squares through pairs of angle (rad) and value. A course with higher harmonics
    /// than `order` shows as a scatter above the noise of the values.
    ///
    /// # Errors
    /// `OutOfRange` above the sixth order, `TooFew` with fewer than twice as many pairs as
    /// unknowns, `Singular` where the angles leave a gap.
    pub fn fit(pairs: impl Iterator<Item = (T, T)>, order: usize) -> Result<Self, LdbbError> {
        if order > MAX_ORDER {
            return Err(LdbbError::OutOfRange { name: "order" });
        }
        let n = 2 * order + 1;
        let mut triangle = Triangle::<T, TERMS>::new(n);
        let (mut count, mut squares) = (0u32, T::ZERO);
        for (theta, value) in pairs {
            let rest = triangle.add(&mut row(theta), value);
            squares += rest * rest;
            count += 1;
        }
        if (count as usize) < 2 * n {
            return Err(LdbbError::TooFew { needed: 2 * n });
        }
        Ok(Self {
            coefficients: triangle.solve().ok_or(LdbbError::Singular)?,
            inverse: triangle.inverse_normal().ok_or(LdbbError::Singular)?,
            order,
            scatter: (squares / T::from_u32(count - n as u32)).sqrt(),
        })
    }

    /// Value at θ.
    pub fn at(&self, theta: T) -> T {
        let row = row(theta);
        row.iter()
            .zip(&self.coefficients)
            .map(|(a, b)| *a * *b)
            .sum()
    }

    /// Standard deviation at θ where each value has `sd`, independent of the others.
    pub fn sd_at(&self, theta: T, sd: T) -> T {
        let row = row(theta);
        let n = 2 * self.order + 1;
        let mut sum = T::ZERO;
        for (i, a) in row.iter().enumerate().take(n) {
            for (j, b) in row.iter().enumerate().take(n) {
                sum += *a * *b * self.inverse[i][j];
            }
        }
        sd * sum.max(T::ZERO).sqrt()
    }

    /// Mean over the circle.
    pub fn mean(&self) -> T {
        self.coefficients[0]
    }

    /// Scatter of the values about the series.
    pub fn scatter(&self) -> T {
        self.scatter
    }
}

fn row<T: Real>(theta: T) -> [T; TERMS] {
    let mut out = [T::ZERO; TERMS];
    let (s, c) = theta.sin_cos();
    let (mut sn, mut cn) = (T::ZERO, T::ONE);
    out[0] = T::ONE;
    for pair in out[1..].chunks_exact_mut(2) {
        (sn, cn) = (sn * c + cn * s, cn * c - sn * s);
        pair[0] = cn;
        pair[1] = sn;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_comes_back_and_its_noise_shrinks() {
        let of = |t: f64| 3.0 + 0.5 * t.cos() - 0.2 * (2.0 * t).sin() + 0.1 * (6.0 * t).cos();
        let angles = (0..180).map(|k| 0.035 * f64::from(k));
        let h = Harmonics::fit(angles.map(|t| (t, of(t))), 6).expect("angles");
        assert!((h.at(1.234) - of(1.234)).abs() < 1e-10 && (h.mean() - 3.0).abs() < 1e-10);
        assert!(h.scatter() < 1e-10);
        // 13 unknowns over 180 values of equal weight.
        let sd = h.sd_at(0.7, 1.0);
        assert!((sd - (13.0f64 / 180.0).sqrt()).abs() < 0.02, "{sd}");
    }

    #[test]
    fn refusals() {
        let few = (0..10).map(|k| (f64::from(k), 1.0));
        assert_eq!(
            Harmonics::fit(few, 3),
            Err(LdbbError::TooFew { needed: 14 })
        );
        assert!(Harmonics::<f32>::fit(core::iter::empty(), 7).is_err());
    }
}
