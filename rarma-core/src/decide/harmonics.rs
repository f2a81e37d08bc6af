//! Is a frequency a multiple of the spindle speed?
//!
//! Labelling is the fallback that always works: a pole that sits on a multiple of
//! the rotation frequency is forced whatever its damping, because a forced line
//! has no damping of its own (it reads ζ ≈ 0.0003).

use crate::real::Real;

/// Spindle frequency, where it is known. Multiples of the tooth frequency are among
/// its multiples, whatever the number of teeth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rotation<T> {
    /// Rotations per second, Hz.
    pub spindle_hz: Option<T>,
}

/// Half-width of the label around a multiple, Hz, at the least.
pub const LEAST_WIDTH_HZ: f64 = 2.0;
/// Half-width as a fraction of the frequency: how well a speed is known.
pub const SPEED_ACCURACY: f64 = 0.002;
/// Half-width at most, as a fraction of the spacing of the multiples. The labels
/// hide twice this fraction of all frequencies where every multiple of the
/// spindle is looked at.
pub const WIDEST_FRACTION: f64 = 0.15;

impl<T: Real> Rotation<T> {
    /// The multiple of the spindle frequency that `f` (standard deviation `f_sd`,
    /// Hz) sits on, if it does.
    ///
    /// Half-width: the largest of two standard deviations, [`LEAST_WIDTH_HZ`] and
    /// [`SPEED_ACCURACY`]·f, but at most [`WIDEST_FRACTION`] of the spacing.
    pub fn harmonic(&self, f: T, f_sd: T) -> Option<u32> {
        let spindle = self.spindle_hz?;
        if !(spindle > T::ZERO) || !(f > T::ZERO) || !f.is_finite() {
            return None;
        }
        let ratio = f / spindle;
        let nearest = ratio.round();
        if nearest < T::ONE || nearest > T::from_f64(1e6) {
            return None;
        }
        let spread = if f_sd.is_finite() {
            f_sd * T::from_f64(2.0)
        } else {
            T::ZERO
        };
        let width = spread
            .max(T::from_f64(LEAST_WIDTH_HZ))
            .max(f * T::from_f64(SPEED_ACCURACY))
            .min(spindle * T::from_f64(WIDEST_FRACTION));
        ((ratio - nearest).abs() * spindle <= width).then(|| nearest.to_f32() as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_are_found_and_others_are_not() {
        let r = Rotation {
            spindle_hz: Some(27.6f32),
        };
        assert_eq!(r.harmonic(165.6, 0.1), Some(6));
        assert_eq!(r.harmonic(167.0, 0.1), Some(6));
        // 898.6 Hz is 32.56 turns: chatter, not a harmonic; nor with a wild sd.
        assert_eq!(r.harmonic(898.6, 0.5), None);
        assert_eq!(r.harmonic(898.6, 500.0), None);
        assert_eq!(r.harmonic(f32::NAN, 0.1), None);
        assert_eq!(Rotation::<f32>::default().harmonic(165.6, 0.1), None);
    }
}
