//! Can the samples be trusted? NaN, Inf, clipped, stuck, missing.
//!
//! Rate: once an input sample. What is wrong is named; a bad value is never
//! passed on, its place is taken by the last good one.

use crate::real::Real;
use crate::visit::state;

/// What is wrong with the signal, if anything; the gravest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Fault {
    /// A sample was NaN, infinite or beyond [`LARGEST`] within the last [`HOLD_S`].
    NotFinite,
    /// Samples were reported missing within the last [`HOLD_S`].
    Missing,
    /// The same value for [`STUCK_S`] and more.
    Stuck,
    /// More than [`CLIPPED_FRACTION`] of the recent samples at full scale.
    Clipped,
}

/// No sensor gives a larger number, whatever its unit; its square would leave the
/// range of single precision before long.
pub const LARGEST: f64 = 1e9;
/// A fault is held for this long after its last sign, s.
pub const HOLD_S: f64 = 0.1;
/// A value that stays the same for this long is no vibration, s.
pub const STUCK_S: f64 = 0.05;
/// Least run of equal samples called stuck, whatever the rate.
const STUCK_SAMPLES: u32 = 32;
/// Fraction of samples at full scale, over the last 50 ms, that makes
/// a signal untrustworthy.
pub const CLIPPED_FRACTION: f64 = 0.02;
/// Memory of the clipped fraction, s.
const CLIP_MEMORY_S: f64 = 0.05;

/// Counts since the start, for the report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HealthCounts {
    /// NaN, infinite or impossibly large samples.
    pub not_finite: u32,
    /// Samples at or above 0.999 of full scale.
    pub clipped: u32,
    /// Samples inside stuck runs.
    pub stuck: u32,
    /// Samples reported missing.
    pub missing: u32,
}

state! { HealthCounts { not_finite, clipped, stuck, missing } }

/// Watches one channel.
#[derive(Debug, Clone)]
pub struct Health<T> {
    /// Infinite where full scale is not known.
    clip_level: T,
    clip_gain: T,
    clipped: T,
    stuck_run: u32,
    hold: u32,
    last: T,
    run: u32,
    /// Samples for which a fault is still held.
    bad_for: u32,
    missing_for: u32,
    counts: HealthCounts,
}

state! { Health<T> {
    clipped, last, run, bad_for, missing_for, counts;
    settings clip_level, clip_gain, stuck_run, hold
} }

impl<T: Real> Health<T> {
    /// Watches a channel of rate `fs` Hz; `full_scale` in input units where the
    /// converter's range is known.
    pub fn new(fs: f64, full_scale: Option<f64>) -> Self {
        let samples = |seconds: f64| (seconds * fs).clamp(1.0, 1e9) as u32;
        Self {
            clip_level: T::from_f64(full_scale.map_or(f64::INFINITY, |f| 0.999 * f)),
            clip_gain: T::from_f64(1.0 / (CLIP_MEMORY_S * fs).max(20.0)),
            clipped: T::ZERO,
            stuck_run: samples(STUCK_S).max(STUCK_SAMPLES),
            hold: samples(HOLD_S),
            last: T::ZERO,
            run: 0,
            bad_for: 0,
            missing_for: 0,
            counts: HealthCounts::default(),
        }
    }

    /// Takes one sample and gives it back, or the last good one in its place.
    #[inline(always)]
    pub fn admit(&mut self, x: T) -> T {
        for held in [&mut self.bad_for, &mut self.missing_for] {
            if *held > 0 {
                *held -= 1;
            }
        }
        if !(x.abs() <= T::from_f64(LARGEST)) {
            self.bad_for = self.hold;
            self.counts.not_finite = self.counts.not_finite.saturating_add(1);
            return self.last;
        }
        if x == self.last {
            self.run = self.run.saturating_add(1);
            if self.run >= self.stuck_run {
                self.counts.stuck = self.counts.stuck.saturating_add(1);
            }
        } else {
            self.run = 0;
        }
        self.clipped -= self.clip_gain * self.clipped;
        if x.abs() >= self.clip_level {
            self.counts.clipped = self.counts.clipped.saturating_add(1);
            self.clipped += self.clip_gain;
        }
        self.last = x;
        x
    }

    /// Takes samples in a row that are good as they are, with nothing to count of them. False where they are not all
    /// so: none is taken then, and each is to be given to [`Self::admit`].
    #[inline(always)]
    pub fn admit_row(&mut self, samples: &[T]) -> bool {
        let Some(&newest) = samples.last() else {
            return true;
        };
        let quiet = self.clip_level.min(T::from_f64(LARGEST));
        let count = samples.len() as u32;
        let is_quiet = |x: &T| x.abs() < quiet;
        let (fours, rest) = samples.as_chunks::<4>();
        let nothing_to_count = self.run.saturating_add(count) < self.stuck_run
            && fours
                .iter()
                .all(|[a, b, c, d]| is_quiet(a) && is_quiet(b) && is_quiet(c) && is_quiet(d))
            && rest.iter().all(is_quiet);
        if !nothing_to_count {
            return false;
        }
        let mut run = 0;
        for (before, x) in samples.iter().zip(samples.iter().skip(1)).rev() {
            if x != before {
                break;
            }
            run += 1;
        }
        let all_are_one = run + 1 == count && samples.first() == Some(&self.last);
        self.run = if all_are_one { self.run + count } else { run };
        self.last = newest;
        if self.clipped > T::ZERO {
            for _ in samples {
                self.clipped -= self.clip_gain * self.clipped;
            }
        }
        self.bad_for = self.bad_for.saturating_sub(count);
        self.missing_for = self.missing_for.saturating_sub(count);
        true
    }

    /// The source lost `samples` samples just now (overrun, dropped frame).
    pub fn missing(&mut self, samples: u32) {
        self.missing_for = self.hold;
        self.counts.missing = self.counts.missing.saturating_add(samples);
    }

    /// What is wrong now.
    pub fn fault(&self) -> Option<Fault> {
        if self.bad_for > 0 {
            Some(Fault::NotFinite)
        } else if self.missing_for > 0 {
            Some(Fault::Missing)
        } else if self.run >= self.stuck_run {
            Some(Fault::Stuck)
        } else if self.clipped > T::from_f64(CLIPPED_FRACTION) {
            Some(Fault::Clipped)
        } else {
            None
        }
    }

    /// Counts since the start.
    pub fn counts(&self) -> HealthCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn feed(health: &mut Health<f32>, n: usize, f: impl Fn(usize) -> f32) {
        for i in 0..n {
            assert!(health.admit(f(i)).is_finite());
        }
    }

    #[test]
    fn a_row_is_its_samples_one_by_one() {
        let mut seed = 1u32;
        let mut random = |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) % below
        };
        let mut rows = Health::<f32>::new(1000.0, Some(1.0));
        let mut singly = rows.clone();
        let (mut kept, mut sticks, mut faults) = (Vec::new(), false, [0; 5]);
        for _ in 0..40_000 {
            if random(if sticks { 30 } else { 200 }) == 0 {
                sticks = !sticks;
            }
            if random(3000) == 0 {
                rows.missing(3);
                singly.missing(3);
            }
            let row: Vec<f32> = (0..1 + random(8))
                .map(|_| match random(400) {
                    _ if sticks => 0.25,
                    0 => f32::NAN,
                    1 => -1e20,
                    2..15 => 1.0,
                    x => x as f32 / 500.0,
                })
                .collect();
            kept.clear();
            if rows.admit_row(&row) {
                kept.extend_from_slice(&row);
            } else {
                kept.extend(row.iter().map(|x| rows.admit(*x)));
            }
            let wanted: Vec<f32> = row.iter().map(|x| singly.admit(*x)).collect();
            assert_eq!(kept, wanted);
            assert_eq!(rows.fault(), singly.fault());
            assert_eq!(rows.counts(), singly.counts());
            faults[rows.fault().map_or(4, |fault| fault as usize)] += 1;
        }
        assert!(faults.iter().all(|times| *times > 100), "{faults:?}");
    }

    #[test]
    fn a_channel_that_is_stuck_for_days_stays_so() {
        let mut health = Health::<f32>::new(1000.0, None);
        // As after so many samples, 25 hours of them at 48 kHz.
        health.run = u32::MAX - 2;
        for _ in 0..5 {
            assert!(!health.admit_row(&[0.0; 4]));
            assert!([0.0; 4].iter().all(|x| health.admit(*x) == 0.0));
            assert_eq!(health.fault(), Some(Fault::Stuck));
        }
    }

    #[test]
    fn names_each_fault_and_lets_it_go() {
        let tone = |i: usize| 0.5 * (i as f32 * 0.3).sin();
        let mut h = Health::<f32>::new(8000.0, Some(1.0));
        feed(&mut h, 1000, tone);
        assert_eq!(h.fault(), None);
        feed(&mut h, 1, |_| f32::NAN);
        feed(&mut h, 1, |_| 1e12);
        assert_eq!(h.fault(), Some(Fault::NotFinite));
        feed(&mut h, 790, tone);
        assert_eq!(h.fault(), Some(Fault::NotFinite));
        feed(&mut h, 20, tone);
        assert_eq!(h.fault(), None);
        feed(&mut h, 500, |_| 0.25);
        assert_eq!(h.fault(), Some(Fault::Stuck));
        feed(&mut h, 2, tone);
        assert_eq!(h.fault(), None);
        feed(&mut h, 400, |i| {
            (2.0 * (i as f32 * 0.3).sin()).clamp(-1.0, 1.0)
        });
        assert_eq!(h.fault(), Some(Fault::Clipped));
        feed(&mut h, 4000, tone);
        assert_eq!(h.fault(), None);
        h.missing(7);
        assert_eq!(h.fault(), Some(Fault::Missing));
        let counts = h.counts();
        assert_eq!((counts.not_finite, counts.missing), (2, 7));
        assert!(counts.clipped > 200 && counts.stuck > 50);
    }
}
