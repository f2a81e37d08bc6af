//! A bare threshold on the damping ratio: what the monitor's decision logic has to
//! be better than.
//!
//! The same filter, estimator and roots as the monitor's; the verdict is ζ < 1 % and
//! nothing else: no standard deviation, no loudness, no persistence. It is told
//! where the mode is, which the monitor is not.

use rarma_core::condition::{Band, BandFilter};
use rarma_core::estimate::{RarmaConfig, RecursiveArma, Status};
use rarma_core::spectrum::{FactorTracker, Tracking, modal};

/// Damping ratio below which the verdict is chatter.
pub const THRESHOLD: f64 = 0.01;
/// Decisions as often as the monitor's, s.
const PERIOD_S: f64 = 0.002;
/// Two crossings closer than this are one alarm, s.
const MERGE_S: f64 = 0.1;

/// When the verdict stood: pairs of from and to, s.
#[derive(Debug, Clone, Default)]
pub struct Crossings(Vec<(f64, f64)>);

/// Runs ARMA(4,3) with this memory over samples of rate `fs_hz` and notes when the
/// pole pair nearest to `mode_hz` has less than [`THRESHOLD`].
///
/// # Panics
/// The rate is too low for the usual band.
pub fn bare(
    memory_s: f64,
    fs_hz: f64,
    mode_hz: f64,
    samples: impl Iterator<Item = f64>,
) -> Crossings {
    let mut filter = BandFilter::<f32>::new(Band::usual(fs_hz), fs_hz).expect("a band");
    let fs = fs_hz / filter.factor() as f64;
    let gain = 1.0 / (memory_s * fs);
    let mut model = RecursiveArma::<f32, 4, 3, 7>::new(RarmaConfig {
        forgetting: 1.0 - gain as f32,
        variance_gain: gain as f32,
        ..RarmaConfig::default()
    });
    let mut roots = FactorTracker::<f32, 4>::new();
    let every = ((PERIOD_S * fs) as u64).max(1);
    let mut out = Crossings::default();
    for (n, y) in samples.filter_map(|x| filter.process(x as f32)).enumerate() {
        let status = model.update(y).status;
        if status == Status::Starting {
            roots.search();
        } else if status != Status::Rejected && roots.track(model.a()) != Tracking::Searching {
            let t = n as f64 / fs;
            let nearest = roots
                .factors(4)
                .iter()
                .filter_map(|factor| modal(factor, fs as f32))
                .min_by(|a, b| {
                    let off = |f: f32| (f64::from(f) - mode_hz).abs();
                    off(a.frequency).total_cmp(&off(b.frequency))
                });
            let low = nearest.is_some_and(|mode| f64::from(mode.damping) < THRESHOLD);
            if low && (n as u64).is_multiple_of(every) {
                out.add(t);
            }
        }
    }
    out
}

impl Crossings {
    fn add(&mut self, t: f64) {
        match self.0.last_mut() {
            Some((_, to)) if t - *to < MERGE_S => *to = t,
            _ => self.0.push((t, t)),
        }
    }

    /// Alarms that began in `from..to`, s.
    #[must_use]
    pub fn begun(&self, from_s: f64, to_s: f64) -> usize {
        let inside = |(t, _): &&(f64, f64)| (from_s..to_s).contains(t);
        self.0.iter().filter(inside).count()
    }

    /// First instant of `from..to` at which the verdict stood, s.
    #[must_use]
    pub fn first(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let inside = |(a, b): &&(f64, f64)| *b >= from_s && *a < to_s;
        self.0.iter().find(inside).map(|(a, _)| a.max(from_s))
    }

    /// When the verdict that stood at `t` ended, s.
    #[must_use]
    pub fn end_of(&self, t: f64) -> Option<f64> {
        let over = |(a, b): &&(f64, f64)| *a <= t && *b >= t - MERGE_S;
        self.0.iter().find(over).map(|(_, b)| b.max(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::{modes, tone};

    #[test]
    fn a_tone_stands_and_a_damped_mode_does_not() {
        let noisy = tone(980.0, 5000.0).zip(modes(&[(450.0, 0.05)], 5000.0, 1));
        let tone = bare(
            0.1,
            5000.0,
            980.0,
            noisy.map(|(a, b)| a + 0.1 * b).take(15_000),
        );
        assert!(tone.first(0.0, 1.0).is_some());
        assert_eq!(tone.end_of(2.0).map(|t| t > 2.9), Some(true), "{tone:?}");
        let damped = bare(
            0.4,
            5000.0,
            980.0,
            modes(&[(980.0, 0.05), (450.0, 0.05)], 5000.0, 2).take(15_000),
        );
        assert_eq!(damped.begun(1.0, 3.0), 0, "{damped:?}");
    }
}
