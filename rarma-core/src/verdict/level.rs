//! A power in two bytes, for spectra that are kept from window to window.
//!
//! Rate: per bin of a window.

use crate::real::Real;
use crate::visit::{State, StateVisitor};

/// A power, 0 and above: exponent and first 8 bits of the fraction of an `f32`, rounded, so that
/// it is off by 0.2 % (0.008 dB) at the most. In order as the powers are. A step up is 0.2 to 0.4 %,
/// in the mean of a doubling ln 2/256 = 0.27 %.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Level(u16);

/// Bits of an `f32` that are left away.
const LESS: u32 = 15;

impl Level {
    pub(super) const ZERO: Self = Self(0);
    /// The largest that is finite, 3.4e38.
    const MOST: Self = Self(0xFEFF);

    /// Of a power; one that no `f32` holds, or that is no number, is the largest.
    #[inline(always)]
    pub(super) fn of<T: Real>(power: T) -> Self {
        let bits = power.to_f32().to_bits() & (u32::MAX >> 1);
        Self(((bits + (1 << (LESS - 1))) >> LESS) as u16).min(Self::MOST)
    }

    #[inline(always)]
    pub(super) fn power<T: Real>(self) -> T {
        T::from_f32(f32::from_bits(u32::from(self.0) << LESS))
    }

    /// So many steps more.
    #[inline(always)]
    pub(super) fn risen(self, steps: u16) -> Self {
        Self(self.0.saturating_add(steps)).min(Self::MOST)
    }
}

/// Shown as the power it is.
impl<T: Real> State<T> for Level {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let mut power = self.power();
        visitor.number(&mut power);
        *self = Self::of(power);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_off_by_so_much_and_keeps_the_order() {
        let (mut worst, mut before) = (0.0f64, Level::ZERO);
        for k in -4000..4000 {
            let power = (f64::from(k) * 0.02).exp();
            let level = Level::of(power);
            worst = worst.max((level.power::<f64>() / power - 1.0).abs());
            assert!(level > before);
            before = level;
            // What is kept is what was shown.
            assert_eq!(Level::of(level.power::<f32>()), level);
        }
        assert!((0.0015..0.002).contains(&worst), "{worst}");
        assert_eq!(Level::of(0.0f32), Level::ZERO);
        assert_eq!(Level::of(f64::NAN), Level::MOST);
        assert_eq!(Level::of(1e300f64), Level::MOST);
        assert!(Level::MOST.power::<f32>().is_finite());
    }

    #[test]
    fn a_step_is_a_part_of_it() {
        let from = Level::of(1e-7f32);
        let up = from.risen(256).power::<f64>() / from.power::<f64>();
        assert!((up - 2.0).abs() < 1e-6, "{up}");
        assert_eq!(Level::MOST.risen(9), Level::MOST);
    }
}
