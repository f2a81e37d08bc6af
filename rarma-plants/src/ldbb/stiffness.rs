//! A quantity all round: mean and harmonics.

use crate::PlantError;
use nalgebra::{DMatrix, DVector};

/// Orders of a quantity all round.
const ORDERS: usize = 3;

/// f(θ) = mean + Σ a_n·cos nθ + b_n·sin nθ, n = 1 to 3.
///
/// A linear structure has an elliptic compliance: orders 0 and 2 only. The machine of the
/// thesis' figure 16 has its extremes 86.8° apart and one of each: axes that hang over on
/// one side, and contacts that open, bring the odd orders in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Around {
    /// Mean.
    pub mean: f64,
    /// a_n, b_n.
    pub waves: [(f64, f64); ORDERS],
}

impl Around {
    /// The same in every direction.
    pub const fn constant(mean: f64) -> Self {
        Self {
            mean,
            waves: [(0.0, 0.0); ORDERS],
        }
    }

    /// The smoothest course with this mean and these extremes, given as value and angle
    /// (rad): of all courses that pass there with level slope, the one with the least
    /// Σ n⁴(a_n² + b_n²).
    ///
    /// # Errors
    /// Where that course has another, greater extreme: the figures do not belong together.
    pub fn through(mean: f64, most: (f64, f64), least: (f64, f64)) -> Result<Self, PlantError> {
        // Columns in units of 1/n², so that the least norm is the least curvature.
        let mut a = DMatrix::<f64>::zeros(4, 2 * ORDERS);
        for n in 1..=ORDERS {
            let (k, w) = (n as f64, 1.0 / (n * n) as f64);
            for (row, angle) in [(0, most.1), (2, least.1)] {
                let (s, c) = (k * angle).sin_cos();
                a[(row, 2 * n - 2)] = w * c;
                a[(row, 2 * n - 1)] = w * s;
                a[(row + 1, 2 * n - 2)] = -w * k * s;
                a[(row + 1, 2 * n - 1)] = w * k * c;
            }
        }
        let b = DVector::from_vec(vec![most.0 - mean, 0.0, least.0 - mean, 0.0]);
        let x = a
            .svd(true, true)
            .solve(&b, 1e-12)
            .map_err(|_| PlantError::OutOfRange { name: "extremes" })?;
        let waves = std::array::from_fn(|i| {
            let w = 1.0 / ((i + 1) * (i + 1)) as f64;
            (w * x[2 * i], w * x[2 * i + 1])
        });
        let this = Self { mean, waves };
        let room = 1e-6 * (most.0 - least.0).abs();
        let inside = (0..720).all(|k| {
            let v = this.at(0.5 * f64::from(k).to_radians());
            v <= most.0 + room && v >= least.0 - room
        });
        if inside {
            Ok(this)
        } else {
            Err(PlantError::OutOfRange { name: "extremes" })
        }
    }

    /// Value at θ, rad.
    pub fn at(&self, theta: f64) -> f64 {
        let mut sum = self.mean;
        for (k, (a, b)) in self.waves.iter().enumerate() {
            let (s, c) = ((k + 1) as f64 * theta).sin_cos();
            sum += a * c + b * s;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_of_figure_16() {
        let deg = f64::to_radians;
        let k = Around::through(11.8e6, (13.4e6, deg(120.2)), (10.3e6, deg(207.0)))
            .expect("one of each");
        let all: Vec<(f64, f64)> = (0..3600)
            .map(|i| (0.1 * f64::from(i), k.at(deg(0.1 * f64::from(i)))))
            .collect();
        let most = all
            .iter()
            .fold(all[0], |m, p| if p.1 > m.1 { *p } else { m });
        let least = all
            .iter()
            .fold(all[0], |m, p| if p.1 < m.1 { *p } else { m });
        let mean = all.iter().map(|p| p.1).sum::<f64>() / 3600.0;
        assert!(
            (most.0 - 120.2).abs() < 0.11 && (most.1 - 13.4e6).abs() < 1e2,
            "{most:?}"
        );
        assert!((least.0 - 207.0).abs() < 0.11 && (least.1 - 10.3e6).abs() < 1e2);
        assert!((mean - 11.8e6).abs() < 1.0);
    }

    #[test]
    fn extremes_that_do_not_belong_together() {
        // Level at the mean between two maxima.
        assert!(Around::through(10.0, (10.1, 0.0), (0.0, 0.3)).is_err());
    }
}
