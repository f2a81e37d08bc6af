//! Pressure to force along the bar.

use super::error::LdbbError;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Least force that holds the bar between the balls while the machine moves, N (the
/// thesis, 3.3).
pub const HOLDING_N: f64 = 36.0;
/// Pressures are fitted in units of this, Pa: 1 bar.
const UNIT_PA: f64 = 1e5;

/// F = gain·p + offset.
///
/// `standard` is 126 N/bar and −14 N: it gives all eight forces of the thesis (36, 112,
/// 238 to 868 N at 0.4, 1, 2 to 7 bar) within 0.5 N. A piston of 40 mm has 125.66 N/bar; the
/// offset is seal friction and preload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceLaw<T> {
    /// N/Pa.
    pub gain_n_per_pa: T,
    /// N; negative where the seal holds something back.
    pub offset_n: T,
}

impl<T: Real> ForceLaw<T> {
    /// 126 N/bar, −14 N.
    pub fn standard() -> Self {
        Self {
            gain_n_per_pa: T::from_f64(126.0 / UNIT_PA),
            offset_n: T::from_f64(-14.0),
        }
    }

    /// Force along the bar at a pressure, N.
    pub fn force_n(&self, pressure_pa: T) -> T {
        self.gain_n_per_pa * pressure_pa + self.offset_n
    }

    /// Pressure that gives a force, Pa.
    pub fn pressure_pa(&self, force_n: T) -> T {
        (force_n - self.offset_n) / self.gain_n_per_pa
    }

    /// Diameter of the piston that the gain says, m.
    pub fn piston_m(&self) -> T {
        (T::from_f64(4.0) * self.gain_n_per_pa / T::PI).sqrt()
    }
}

/// A force law found from measured pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceCalibration<T> {
    /// The law.
    pub law: ForceLaw<T>,
    /// Standard deviations of gain (N/Pa) and offset (N), and their correlation.
    pub gain_sd_n_per_pa: T,
    /// See [`Self::gain_sd_n_per_pa`].
    pub offset_sd_n: T,
    /// See [`Self::gain_sd_n_per_pa`].
    pub correlation: T,
    /// Scatter of the forces about the line, N.
    pub scatter_n: T,
    /// Pairs used.
    pub pairs: usize,
}

impl<T: Real> ForceCalibration<T> {
    /// Line through pairs of pressure (Pa) and force from a load cell (N), least squares in
    /// the force. Pairs taken upwards and downwards average out the seal's friction.
    ///
    /// # Errors
    /// `TooFew` below three pairs, `NotFinite`, `Singular` where the pressures are all
    /// equal, `OutOfRange` where force falls with pressure.
    pub fn from_pairs(pairs: &[(T, T)]) -> Result<Self, LdbbError> {
        if pairs.len() < 3 {
            return Err(LdbbError::TooFew { needed: 3 });
        }
        let unit = T::from_f64(UNIT_PA);
        let mut triangle = Triangle::<T, 2>::new(2);
        let mut squares = T::ZERO;
        for (index, &(p, force)) in pairs.iter().enumerate() {
            if !(p.is_finite() && force.is_finite()) {
                return Err(LdbbError::NotFinite { index });
            }
            let rest = triangle.add(&mut [T::ONE, p / unit], force);
            squares += rest * rest;
        }
        let found = triangle.solve().ok_or(LdbbError::Singular)?;
        let covariance = triangle.inverse_normal().ok_or(LdbbError::Singular)?;
        if !(found[1] > T::ZERO) {
            return Err(LdbbError::OutOfRange { name: "gain" });
        }
        let variance = squares / T::from_u32(pairs.len() as u32 - 2);
        let sd = |i: usize| (variance * covariance[i][i]).sqrt();
        Ok(Self {
            law: ForceLaw {
                gain_n_per_pa: found[1] / unit,
                offset_n: found[0],
            },
            gain_sd_n_per_pa: sd(1) / unit,
            offset_sd_n: sd(0),
            correlation: covariance[0][1] / (covariance[0][0] * covariance[1][1]).sqrt(),
            scatter_n: variance.sqrt(),
            pairs: pairs.len(),
        })
    }

    /// Part by which every stiffness may be off with the gain: u(gain)/gain. The offset
    /// cancels in a stiffness.
    pub fn scale_sd(&self) -> T {
        self.gain_sd_n_per_pa / self.law.gain_n_per_pa
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eight_points_and_back() {
        let law = ForceLaw::<f32>::standard();
        let table = [36.0, 112.0, 238.0, 364.0, 490.0, 616.0, 742.0, 868.0];
        for (k, want) in table.into_iter().enumerate() {
            let bar = if k == 0 { 0.4 } else { k as f32 };
            let n = law.force_n(bar * 1e5);
            assert!((n - want).abs() < 0.5, "{bar} bar: {n} N");
            assert!((law.pressure_pa(n) - bar * 1e5).abs() < 0.1);
        }
        assert!((law.piston_m() - 0.04).abs() < 1e-4);
    }

    #[test]
    fn refusals() {
        let of = |pairs: &[(f64, f64)]| ForceCalibration::from_pairs(pairs).err();
        assert_eq!(
            of(&[(1.0, 2.0), (2.0, 3.0)]),
            Some(LdbbError::TooFew { needed: 3 })
        );
        assert_eq!(of(&[(1e5, 112.0); 4]), Some(LdbbError::Singular));
        let falling = [(1e5, 3.0), (2e5, 2.0), (3e5, 1.0)];
        assert_eq!(of(&falling), Some(LdbbError::OutOfRange { name: "gain" }));
        let bad = [(1e5, 3.0), (2e5, f64::NAN), (3e5, 1.0)];
        assert_eq!(of(&bad), Some(LdbbError::NotFinite { index: 1 }));
    }
}
