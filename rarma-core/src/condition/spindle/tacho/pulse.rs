//! Pulses of a tacho that comes as a voltage: when does it rise?
//!
//! Rate: [`PulseDetector::process`] once a sample of the tacho's channel.

use crate::real::Real;

/// Memory of the highest and the lowest level, s.
pub const LEVEL_MEMORY_S: f64 = 2.0;
/// A pulse begins above this part of the span between the levels, and ends below the
/// other one.
const RISE: f64 = 0.6;
const FALL: f64 = 0.4;

/// Tells the rising edges of a pulse train of unknown levels.
///
/// Levels: highest and lowest sample, each drawn towards the other with a memory of
/// [`LEVEL_MEMORY_S`]. A pulse begins where the signal crosses 0.6 of the span upwards
/// and ends where it has been below 0.4 of it; between the two nothing counts. A span
/// below the least one is noise. Time of the crossing by a straight line between the
/// samples. For pulses that point down, negate the samples.
///
/// ```
/// use rarma_core::condition::PulseDetector;
/// let mut detector = PulseDetector::new(1000.0, 0.5);
/// let edges = (0..1000u32)
///     .filter(|n| detector.process(if n % 100 < 10 { 3.0f32 } else { 0.1 }).is_some())
///     .count();
/// assert_eq!(edges, 9); // not the one it began in
/// ```
#[derive(Debug, Clone, Copy)]
pub struct PulseDetector<T> {
    high: T,
    low: T,
    keep: T,
    least_span: T,
    last: Option<T>,
    /// The signal has been low since the last pulse.
    armed: bool,
}

impl<T: Real> PulseDetector<T> {
    /// A detector for samples of rate `fs_hz`; pulses are at least `least_span` high,
    /// input units.
    pub fn new(fs_hz: f64, least_span: f64) -> Self {
        let samples = (LEVEL_MEMORY_S * fs_hz).max(1.0);
        Self {
            high: T::ZERO,
            low: T::ZERO,
            keep: T::from_f64(1.0 / samples),
            least_span: T::from_f64(least_span),
            last: None,
            armed: false,
        }
    }

    /// Takes a sample; where a pulse has begun since the last one, how long before
    /// this sample, in samples (0 to below 1). A sample that is no number is passed
    /// over.
    #[inline]
    pub fn process(&mut self, x: T) -> Option<T> {
        if !x.is_finite() {
            self.last = None;
            return None;
        }
        let Some(last) = self.last.replace(x) else {
            if !self.armed && self.high == self.low {
                (self.high, self.low) = (x, x);
            }
            return None;
        };
        let drawn = (self.high - self.low) * self.keep;
        self.high = (self.high - drawn).max(x);
        self.low = (self.low + drawn).min(x);
        let span = self.high - self.low;
        if !(span >= self.least_span) {
            self.armed = false;
            return None;
        }
        if x < self.low + span * T::from_f64(FALL) {
            self.armed = true;
            return None;
        }
        let level = self.low + span * T::from_f64(RISE);
        if !self.armed || x < level {
            return None;
        }
        self.armed = false;
        let step = x - last;
        if !(step > T::ZERO) {
            return Some(T::ZERO);
        }
        Some(((x - level) / step).clamp(T::ZERO, T::from_f64(0.999)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Times of the edges of a sine of `f` Hz at `fs`, in periods.
    fn edges(f: f64, fs: f64, offset: f64, gain: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut detector = PulseDetector::<f64>::new(fs, 0.2);
        let mut seed = 1u32;
        let mut edges = vec![];
        for n in 0..(4.0 * fs) as u32 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
            let t = f64::from(n) / fs;
            let x = offset + gain(t) * (TAU * f * t).sin() + 0.02 * noise;
            if let Some(before) = detector.process(x) {
                edges.push((f64::from(n) - before) / fs * f);
            }
        }
        edges
    }

    #[test]
    fn one_edge_a_period_between_the_samples() {
        for offset in [0.0, 100.0] {
            let edges = edges(41.3, 2000.0, offset, |_| 1.0);
            assert!((163..=166).contains(&edges.len()), "{}", edges.len());
            let mean: f64 = edges.iter().map(|e| e.fract()).sum::<f64>() / edges.len() as f64;
            let rms = edges
                .iter()
                .map(|e| (e.fract() - mean).powi(2))
                .sum::<f64>();
            let rms = (rms / edges.len() as f64).sqrt();
            // A sample is 0.02 of a period; noise 0.0115/2π; and the curve of the sine.
            assert!((5e-4..4e-3).contains(&rms), "{rms}");
        }
    }

    #[test]
    fn levels_that_fall_are_followed_and_noise_is_no_pulse() {
        // A tenth of the height after one second: found again within the memory.
        let found = edges(50.0, 2000.0, 1.0, |t| if t < 1.0 { 3.0 } else { 0.6 });
        let late = found.iter().filter(|e| **e > 50.0 * 3.5).count();
        assert!((24..=26).contains(&late), "{late}");
        assert!(edges(50.0, 2000.0, 1.0, |_| 0.0).is_empty());
    }

    #[test]
    fn samples_that_are_no_numbers_do_no_harm() {
        let mut detector = PulseDetector::<f32>::new(1000.0, 0.5);
        let mut count = 0;
        for n in 0..1000 {
            let x = match n % 100 {
                50 => f32::NAN,
                51 => f32::INFINITY,
                0..10 => 1.0,
                _ => 0.0,
            };
            count += u32::from(detector.process(x).is_some());
        }
        assert_eq!(count, 9);
    }
}
