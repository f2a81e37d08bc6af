//! Is a frequency a multiple of the spindle speed?
//!
//! Labelling is the fallback that always works: a pole that sits on a multiple of
//! the rotation frequency is forced whatever its damping, because a forced line
//! has no damping of its own (it reads ζ ≈ 0.0003).

use crate::condition::is_home_of_flip;
use crate::real::Real;

/// Spindle frequency, where it is known. Multiples of the tooth frequency are among
/// its multiples, whatever the number of teeth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rotation<T> {
    /// Rotations per second, Hz.
    pub spindle_hz: Option<T>,
    /// Teeth on the cutter, where they are known.
    pub teeth: Option<u32>,
    /// How well the speed is known, as a part of it: [`SPEED_ACCURACY`] for one that
    /// was told.
    pub accuracy: T,
    /// How far it may be off just now, as a part of it.
    pub doubt: T,
    /// How far the first multiples may be off, as a part of it, while nobody has heard it.
    pub doubt_of_first: T,
}

/// Half-width of the label around a multiple, Hz, at the least.
const LEAST_WIDTH_HZ: f64 = 2.0;
/// Half-width in standard deviations of the mode's frequency, for a speed that is heard or
/// measured, so that its lines are removed or at least known, and for one that was told.
pub const HEARD_SD: f64 = 1.0;
/// See `HEARD_SD`.
pub const TOLD_SD: f64 = 2.0;
/// Half-width as a fraction of the frequency: how well a speed is known.
pub(crate) const SPEED_ACCURACY: f64 = 0.002;
/// Up to this multiple a doubt about the speed counts: of an end mill in steel 33 were heard.
const DOUBTED_MULTIPLES: f64 = 33.0;
/// The first multiples: a doubt of 2 % hides less than a third of what lies between them.
const FIRST_MULTIPLES: f64 = 8.0;
/// Half-width at most, as a fraction of the spacing of the multiples. The labels
/// hide twice this fraction of all frequencies where every multiple of the
/// spindle is looked at.
const WIDEST_FRACTION: f64 = 0.15;

impl<T: Real> Rotation<T> {
    /// The multiple of the spindle frequency that `f` (standard deviation `f_sd`,
    /// Hz) sits on, if it does.
    ///
    /// Half-width: the largest of `HEARD_SD` or `TOLD_SD` standard deviations,
    /// [`LEAST_WIDTH_HZ`] and accuracy·f, but at most [`WIDEST_FRACTION`] of the spacing; or the
    /// doubt about the speed, up to half the spacing.
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
            let heard = self.accuracy < T::from_f64(SPEED_ACCURACY);
            f_sd * T::from_f64(if heard { HEARD_SD } else { TOLD_SD })
        } else {
            T::ZERO
        };
        // Far up every frequency is near some multiple of a speed in doubt, and forced
        // lines are faint.
        let doubt = if nearest > T::from_f64(DOUBTED_MULTIPLES) {
            T::ZERO
        } else if nearest > T::from_f64(FIRST_MULTIPLES) {
            self.doubt
        } else {
            self.doubt.max(self.doubt_of_first)
        };
        let width = spread
            .max(T::from_f64(LEAST_WIDTH_HZ))
            .max(f * self.accuracy)
            .min(spindle * T::from_f64(WIDEST_FRACTION))
            .max((f * doubt).min(spindle * T::from_f64(0.5)));
        ((ratio - nearest).abs() * spindle <= width).then(|| nearest.to_f32() as u32)
    }

    /// The same speed, taken for certain.
    pub fn without_doubt(self) -> Self {
        Self {
            doubt: T::ZERO,
            doubt_of_first: T::ZERO,
            ..self
        }
    }

    /// Multiple `n` of the spindle is home to flip chatter, see [`is_home_of_flip`].
    pub fn may_flip(&self, n: u32) -> bool {
        is_home_of_flip(self.teeth, n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_are_found_and_others_are_not() {
        let r = Rotation {
            spindle_hz: Some(27.6f32),
            accuracy: SPEED_ACCURACY as f32,
            ..Rotation::default()
        };
        assert_eq!(r.harmonic(165.6, 0.1), Some(6));
        assert_eq!(r.harmonic(167.0, 0.1), Some(6));
        // 898.6 Hz is 32.56 turns: chatter, not a harmonic; nor with a wild sd.
        assert_eq!(r.harmonic(898.6, 0.5), None);
        assert_eq!(r.harmonic(898.6, 500.0), None);
        assert_eq!(r.harmonic(f32::NAN, 0.1), None);
        assert_eq!(Rotation::<f32>::default().harmonic(165.6, 0.1), None);
        // The speed in doubt by 1.3 %: the label reaches half way, no further.
        let doubted = Rotation { doubt: 0.013, ..r };
        assert_eq!(doubted.harmonic(890.0, 0.5), Some(32));
        assert_eq!(doubted.harmonic(895.0, 0.5), None);
        // Nobody has heard it: the first multiples only.
        let unheard = Rotation {
            doubt_of_first: 0.02,
            ..r
        };
        assert_eq!(unheard.harmonic(168.0, 0.1), Some(6));
        assert_eq!(unheard.harmonic(250.7, 0.1), None);
        assert_eq!(unheard.without_doubt().harmonic(168.0, 0.1), None);
    }
}
