//! Codes of converters: what boards give and take, the same for every resolution.

/// A code of an analogue-to-digital converter, left-aligned: 0 is the lower end of its
/// range and 65535 the upper, whatever the converter's bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct AdcCode(pub u16);

/// A code of a digital-to-analogue converter, left-aligned like [`AdcCode`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct DacCode(pub u16);

impl AdcCode {
    /// The upper end of the range.
    pub const FULL: Self = Self(u16::MAX);

    /// Part of the range, 0..=1.
    #[inline]
    pub fn fraction(self) -> f32 {
        f32::from(self.0) * (1.0 / 65535.0)
    }
}

impl DacCode {
    /// The code of a part of the range; outside 0..=1 its nearer end, NaN is 0.
    #[inline]
    pub fn from_fraction(fraction: f32) -> Self {
        // A float cast saturates, and takes NaN for 0.
        Self((fraction * 65535.0 + 0.5) as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_nonsense() {
        assert_eq!(AdcCode::FULL.fraction(), 1.0);
        assert_eq!(AdcCode(0).fraction(), 0.0);
        assert_eq!(DacCode::from_fraction(0.5), DacCode(32768));
        assert_eq!(DacCode::from_fraction(1.0), DacCode(65535));
        assert_eq!(DacCode::from_fraction(7.0), DacCode(65535));
        assert_eq!(DacCode::from_fraction(-1.0), DacCode(0));
        assert_eq!(DacCode::from_fraction(f32::NAN), DacCode(0));
    }
}
