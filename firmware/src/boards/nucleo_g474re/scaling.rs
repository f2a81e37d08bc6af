//! Codes of converters to units and back: pure arithmetic, tested on the host.

use super::timing::OVERSAMPLING;
use crate::board::{AdcCode, DacCode};

/// Codes of one conversion.
const FULL_CODE: f32 = 4095.0;
/// Where the comparators trip, as a part of a current sensor's range; its middle is no
/// current, so this is 80 % of the way to the end.
pub const TRIP_SHARE: f32 = 0.9;

/// The code of a silent microphone: half the reference, added up.
pub const MICROPHONE_ZERO: f32 = FULL_CODE * OVERSAMPLING as f32 / 2.0;

/// A microphone's sample from the sum of [`OVERSAMPLING`] conversions: −1 at 0 V, 0 at half
/// the reference, 1 at the reference. One step is 6.1e-5.
#[inline]
#[must_use]
pub fn microphone(sum: u16) -> f32 {
    (f32::from(sum) - MICROPHONE_ZERO) * (1.0 / MICROPHONE_ZERO)
}

/// A code of 12 bits, left-aligned: the upper bits again fill the lower, so that 4095
/// becomes 65535.
#[inline]
#[must_use]
pub fn left_aligned(code: u32) -> AdcCode {
    let code = (code & 0xFFF) as u16;
    AdcCode(code << 4 | code >> 8)
}

/// The 12 bits of a left-aligned code for a DAC, cut.
#[inline]
#[must_use]
pub fn dac_12_bits(code: DacCode) -> u16 {
    code.0 >> 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twelve_bits_span_the_whole_range() {
        assert_eq!(left_aligned(0), AdcCode(0));
        assert_eq!(left_aligned(4095), AdcCode::FULL);
        let middle = left_aligned(2048).fraction();
        assert!((middle - 2048.0 / 4095.0).abs() < 2e-5, "{middle}");
        for code in 0..4096u32 {
            let there = DacCode(left_aligned(code).0);
            assert_eq!(u32::from(dac_12_bits(there)), code);
        }
        let trip = dac_12_bits(DacCode::from_fraction(TRIP_SHARE));
        assert_eq!(trip, 3686);
    }

    #[test]
    fn a_microphone_spans_one_to_both_sides() {
        assert_eq!(microphone(0), -1.0);
        assert!((microphone(4095 * 8) - 1.0).abs() < 1e-6);
        assert_eq!(microphone(16_380), 0.0);
        let step = microphone(101) - microphone(100);
        assert!((step - 6.105e-5).abs() < 1e-7, "{step}");
    }
}
