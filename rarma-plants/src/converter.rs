//! The analog-to-digital converter behind a sensor: full scale, bits, dither,
//! clipping.

use super::error::{PlantError, positive, require};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Configuration of [`Converter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConverterConfig {
    /// Input that gives full scale, input units, > 0 (bipolar: ± this value).
    pub full_scale: f64,
    /// Resolution, bits, 8 to 32.
    pub bits: u32,
    /// Triangular dither of ±1 code, which makes the rounding error independent
    /// of the signal at the price of 4.8 dB more noise.
    pub dither: bool,
}

impl ConverterConfig {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        positive(self.full_scale, "full_scale")?;
        require((8..=32).contains(&self.bits), "bits")
    }
}

/// One converted sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Signed code, -2^(bits-1) to 2^(bits-1) - 1.
    pub code: i32,
    /// Code as a fraction of full scale, -1 to just below 1.
    pub value: f32,
    /// The input was beyond the range and the code is its end.
    pub clipped: bool,
}

/// Rounds to codes: code = round(x/full_scale·2^(bits-1) + dither), clamped.
///
/// An input that is not a number reads as code 0 and counts as clipped.
#[derive(Clone, Debug)]
pub struct Converter {
    config: ConverterConfig,
    scale: f64,
    top: f64,
    rng: ChaCha8Rng,
}

impl Converter {
    /// Builds the converter; the seed is that of its dither.
    ///
    /// # Errors
    /// As [`ConverterConfig::validate`].
    pub fn new(config: ConverterConfig, seed: u64) -> Result<Self, PlantError> {
        config.validate()?;
        let top = 2f64.powi(config.bits as i32 - 1);
        Ok(Self {
            config,
            scale: top / config.full_scale,
            top,
            rng: ChaCha8Rng::seed_from_u64(seed),
        })
    }

    /// Converts one input.
    pub fn convert(&mut self, input: f64) -> Reading {
        let dither = if self.config.dither {
            self.rng.random::<f64>() - self.rng.random::<f64>()
        } else {
            0.0
        };
        let raw = (input * self.scale + dither).round();
        let bounded = if raw.is_nan() {
            0.0
        } else {
            raw.clamp(-self.top, self.top - 1.0)
        };
        Reading {
            code: bounded as i32,
            value: (bounded / self.top) as f32,
            // NaN compares unequal to its substitute as well.
            clipped: raw != bounded,
        }
    }

    /// The same code left-aligned or truncated to 16 bits.
    #[must_use]
    pub fn to_i16(&self, code: i32) -> i16 {
        let wide = i64::from(code) << (32 - self.config.bits);
        (wide >> 16) as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converter(bits: u32, dither: bool) -> Converter {
        Converter::new(
            ConverterConfig {
                full_scale: 2.0,
                bits,
                dither,
            },
            3,
        )
        .expect("valid")
    }

    #[test]
    fn codes_at_the_ends_and_in_between() {
        let mut c = converter(16, false);
        assert_eq!(
            c.convert(1.0),
            Reading {
                code: 16_384,
                value: 0.5,
                clipped: false
            }
        );
        assert_eq!(
            c.convert(-2.0),
            Reading {
                code: -32_768,
                value: -1.0,
                clipped: false
            }
        );
        assert_eq!(c.convert(2.0).code, 32_767);
        assert!(c.convert(2.0).clipped && c.convert(-2.1).clipped);
        assert!(c.convert(f64::NAN).clipped);
        assert_eq!(converter(24, false).convert(1.0).code, 1 << 22);
        assert_eq!(converter(32, false).convert(-2.0).code, i32::MIN);
        assert_eq!(converter(32, false).convert(3.0).code, i32::MAX);
        assert_eq!(converter(12, false).to_i16(-2048), i16::MIN);
        assert_eq!(converter(24, false).to_i16(1 << 22), 16_384);
    }

    #[test]
    fn dither_makes_the_mean_exact_and_costs_what_it_should() {
        let mut c = converter(8, true);
        let lsb = 2.0 / 128.0;
        let n = 200_000;
        let (mut mean, mut power) = (0.0, 0.0);
        for _ in 0..n {
            let e = f64::from(c.convert(0.3 * lsb).code) - 0.3;
            mean += e / f64::from(n);
            power += e * e / f64::from(n);
        }
        assert!(mean.abs() < 0.005, "{mean}");
        assert!((power - 0.25).abs() < 0.005, "{power}");
    }

    #[test]
    fn bad_settings_are_named() {
        let bad = ConverterConfig {
            full_scale: 1.0,
            bits: 7,
            dither: false,
        };
        assert_eq!(bad.validate(), Err(PlantError::OutOfRange { name: "bits" }));
    }
}
