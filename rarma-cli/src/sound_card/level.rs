//! The level of an input before anything is concluded from it.

use std::fmt;

/// Below this rms an input is taken for muted, in dB below full scale: the last bit of a
/// converter of 16 bits is at -90, and any open microphone is above it.
const SILENT_DBFS: f64 = -90.0;
/// A constant part of more than this share of full scale is odd.
const ODD_DC: f64 = 0.1;
/// More bits than a converter has: these are numbers that have been multiplied.
pub const FLOAT_BITS: u32 = 33;

/// The level of one channel. Full scale is 1, and 0 dBFS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Samples measured.
    pub samples: u64,
    /// Mean.
    pub dc: f64,
    /// Root mean square without the mean; a sine that fills the range has -3 dBFS.
    pub rms: f64,
    /// Largest magnitude.
    pub peak: f64,
    /// Samples at either end of the range.
    pub clipped: u64,
    /// Bits that the samples need: those of the converter behind whatever format they came in.
    pub bits: u32,
}

impl Level {
    /// Of so many samples.
    pub fn of(samples: &[f32]) -> Self {
        let n = (samples.len() as f64).max(1.0);
        let dc = samples.iter().map(|x| f64::from(*x)).sum::<f64>() / n;
        let square = |x: &f32| (f64::from(*x) - dc).powi(2);
        let bits = samples.iter().map(|x| bits(*x)).max().unwrap_or(1);
        let end = 1.0 - step(bits);
        let clipped = samples.iter().filter(|x| f64::from(x.abs()) >= end);
        Self {
            samples: samples.len() as u64,
            dc,
            rms: (samples.iter().map(square).sum::<f64>() / n).sqrt(),
            peak: samples.iter().fold(0.0, |m, x| f64::from(x.abs()).max(m)),
            clipped: clipped.count() as u64,
            bits,
        }
    }

    /// Nothing but silence: muted, or not connected.
    pub fn is_silent(&self) -> bool {
        !(dbfs(self.rms) > SILENT_DBFS)
    }

    /// What is wrong with it, and what to do; nothing of a silent one.
    pub fn warnings(&self) -> Vec<String> {
        let mut out = Vec::new();
        if self.clipped > 0 {
            out.push(format!(
                "it is clipped: {} of {} samples are at full scale (lower the gain: clipped sound grows harmonics that are not there)",
                self.clipped, self.samples
            ));
        }
        if self.dc.abs() > ODD_DC {
            out.push(format!(
                "its mean is {:.0} % of full scale, which takes room from the signal (an input for another kind of microphone?)",
                100.0 * self.dc
            ));
        }
        out
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clipped = match self.clipped {
            0 => "no sample".to_owned(),
            1 => "1 sample".to_owned(),
            n => format!("{n} samples"),
        };
        write!(
            f,
            "rms {:.1} dBFS, peak {:.1} dBFS, DC {:.2} % of full scale, {clipped} clipped",
            dbfs(self.rms),
            dbfs(self.peak),
            100.0 * self.dc
        )
    }
}

/// Decibels over full scale; -200 of nothing at all.
pub fn dbfs(x: f64) -> f64 {
    20.0 * x.max(1e-10).log10()
}

/// Smallest step of a converter of so many bits, full scale being 1.
pub fn step(bits: u32) -> f64 {
    // Numbers beyond those of a converter: single precision has 24 bits.
    let bits = if bits >= FLOAT_BITS { 24 } else { bits.max(2) };
    2_f64.powi(1 - bits as i32)
}

/// Bits that a converter needs for this value, full scale being 1.
fn bits(x: f32) -> u32 {
    let places = x.to_bits();
    let exponent = (places >> 23) & 0xff;
    let mantissa = places & 0x7f_ffff;
    if exponent == 0 || exponent == 0xff {
        // Zero takes none; what is below the smallest number, or is none, no converter gives.
        return if mantissa == 0 && exponent == 0 {
            1
        } else {
            FLOAT_BITS
        };
    }
    // The last place that is not 0 stands for 2 to the power of this.
    let zeros = (mantissa | 1 << 23).trailing_zeros();
    let last = exponent as i32 - 127 - 23 + zeros as i32;
    (1 - last).clamp(1, FLOAT_BITS as i32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    fn sine(amplitude: f32, dc: f32) -> Vec<f32> {
        (0..48_000)
            .map(|n| dc + amplitude * (TAU * 100.0 * n as f32 / 48_000.0).sin())
            .collect()
    }

    /// As a converter of so many bits gives it.
    fn converted(x: &[f32], bits: i32) -> Vec<f32> {
        let full = 2_f32.powi(bits - 1);
        let one = |x: &f32| (x * full).round().clamp(-full, full - 1.0) / full;
        x.iter().map(one).collect()
    }

    #[test]
    fn a_sine_has_the_level_of_the_book() {
        let level = Level::of(&converted(&sine(0.5, 0.0), 16));
        assert!((dbfs(level.rms) + 9.03).abs() < 0.01, "{level}");
        assert!((dbfs(level.peak) + 6.02).abs() < 0.01, "{level}");
        assert!(level.dc.abs() < 1e-5 && level.clipped == 0, "{level}");
        assert!(level.warnings().is_empty() && !level.is_silent());
    }

    #[test]
    fn the_bits_are_those_of_the_converter() {
        for bits in [8, 16, 24] {
            let level = Level::of(&converted(&sine(0.3, 0.01), bits));
            assert_eq!(level.bits, bits as u32);
        }
        // What has gone through a volume control is no converter's any more.
        let scaled: Vec<f32> = converted(&sine(0.003, 0.0), 16)
            .iter()
            .map(|x| x * 0.7)
            .collect();
        assert_eq!(Level::of(&scaled).bits, FLOAT_BITS);
    }

    #[test]
    fn clipping_is_found_at_both_ends_of_every_width() {
        for bits in [16, 24] {
            let level = Level::of(&converted(&sine(1.2, 0.0), bits));
            // |sin| > 1/1.2 holds for 37 % of a turn.
            let share = level.clipped as f64 / level.samples as f64;
            assert!((share - 0.373).abs() < 0.01, "{bits} bits: {share}");
            assert!(level.warnings()[0].contains("clipped"));
        }
        let level = Level::of(&converted(&sine(0.99, 0.0), 16));
        assert_eq!(level.clipped, 0);
    }

    #[test]
    fn a_muted_input_is_silent_and_a_quiet_one_is_not() {
        assert!(Level::of(&[0.0; 1000]).is_silent());
        assert!(Level::of(&[0.25; 1000]).is_silent(), "a constant");
        // The last bit of 16 now and then.
        let flicker: Vec<f32> = (0..1000)
            .map(|n| f32::from(u8::from(n % 7 == 0)) / 32_768.0)
            .collect();
        assert!(Level::of(&flicker).is_silent());
        assert!(!Level::of(&converted(&sine(2e-4, 0.0), 16)).is_silent());
        assert!(Level::of(&[f32::NAN; 10]).is_silent(), "no numbers");
    }

    #[test]
    fn a_constant_part_is_told() {
        let level = Level::of(&converted(&sine(0.1, 0.3), 16));
        assert!((level.dc - 0.3).abs() < 1e-4);
        assert!((dbfs(level.rms) + 23.0).abs() < 0.1, "{level}");
        assert!(level.warnings()[0].contains("30 %"), "{level}");
    }
}
