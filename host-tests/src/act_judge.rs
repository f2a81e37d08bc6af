//! What is true of a cut that was played in a loop, by its delay equation; and which cuts are
//! played.

use crate::act_loop::{FS_HZ, Played};
use crate::advice::{Case, Within, plays};
use crate::statistics::rms;
use core::f64::consts::TAU;
use core::ops::Range;
use hal_sim::population::{Cut, SAFE_PART};
use rarma_cli::controller::{ActRecord, What};
use std::collections::BTreeMap;

/// Seeds that no number of the advice was set on.
pub const SEEDS: u64 = 300_000;
/// Two speeds this near have one root, as a part.
const GRID: f64 = 0.002;
/// Multiples of the rotation are looked for up to here, Hz: beyond what modes of these machines
/// let through.
const MULTIPLES_HZ: f64 = 6000.0;

/// Which cuts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// They chatter, and a stretch of speeds within reach is stable.
    Pocket,
    /// They chatter, and at every speed within reach.
    None,
    /// They are stable.
    Stable,
}

/// The cut of this seed, if it is one of this kind with such a speed, 1/min.
///
/// # Panics
/// The population has a defect.
#[must_use]
pub fn drawn(seed: u64, kind: Kind, rpm: &Range<f64>) -> Option<Case> {
    let cut = Cut::draw(seed).unwrap_or_else(|why| panic!("seed {seed}: {why:?}"));
    if !rpm.contains(&(60.0 * cut.spindle_hz())) || !plays(&cut) {
        return None;
    }
    let wanted = match kind {
        Kind::Pocket => Within::Pocket,
        Kind::None => Within::None,
        Kind::Stable => {
            let stable = cut.limit_part() < SAFE_PART && cut.operational().1 > 0.0;
            return stable.then(|| Case::of(cut));
        }
    };
    Case::draw(seed).filter(|case| case.within == wanted)
}

/// What is true of a played cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Of the cut.
    pub seed: u64,
    /// Chatter was called at, s.
    pub called_s: Option<f64>,
    /// At this frequency, over that of the dominant root.
    pub heard_ratio: Option<f64>,
    /// So many orders were given.
    pub orders: usize,
    /// It was said that there is no speed.
    pub none_said: bool,
    /// At the end: the speed over the programmed one, and whether the cut is stable there.
    pub end_ratio: f64,
    /// See `end_ratio`.
    pub end_stable: bool,
    /// From the first call until the speed is stable for good, s.
    pub stable_after_s: Option<f64>,
    /// From then until the last alarm is released, s.
    pub released_after_s: Option<f64>,
    /// Vibration of the tool in the last half second, less than that of the same cut without
    /// orders by so much, dB.
    pub less_db: Option<f64>,
    /// Of it the part that does not come again with each turn of the spindle: the chatter's.
    pub chatter_less_db: Option<f64>,
    /// Alarms called where the cut had been stable for 0.6 s.
    pub false_calls: usize,
}

impl Played {
    /// Judges it, beside the same cut without orders where that was played.
    #[must_use]
    pub fn judge(&self, case: &Case, unturned: Option<&Self>) -> Judged {
        let mut roots: BTreeMap<i64, bool> = BTreeMap::new();
        let hz = case.cut.spindle_hz();
        let mut stable_at = |speed_hz: f64| {
            let key = (speed_hz / hz / GRID).round() as i64;
            let stable = || case.root(key as f64 * GRID).is_none();
            *roots.entry(key).or_insert_with(stable)
        };
        let states: Vec<(f64, bool)> = self
            .speeds
            .iter()
            .map(|(t_s, speed_hz)| (*t_s, stable_at(*speed_hz)))
            .collect();
        let end_stable = states.last().is_some_and(|(_, stable)| *stable);
        let unstable_until = states.iter().rev().find(|(_, stable)| !stable);
        let unstable_until = unstable_until.map(|(t_s, _)| *t_s);
        let called_s = self.alarms.first().map(|(on, _)| *on);
        let after = |from: Option<f64>, to: Option<f64>| Some(to? - from?);
        let begun = |r: &&ActRecord| matches!(r.what, What::Ordered { .. });
        let released = self.alarms.last().and_then(|(_, off)| *off);
        let stable_since = |t_s: f64| {
            let mut before = states
                .iter()
                .filter(|(at, _)| *at <= t_s && *at > t_s - 0.6);
            before.all(|(_, stable)| *stable)
        };
        let less = |of: &dyn Fn(&Self) -> f64| {
            let before = of(unturned?);
            Some(20.0 * (before / of(self)).log10())
        };
        Judged {
            seed: case.cut.seed,
            called_s,
            heard_ratio: self.heard_hz.zip(case.root(1.0)).map(|(f, root)| f / root),
            orders: self.records.iter().filter(begun).count(),
            none_said: self.records.iter().any(|r| r.what == What::NoSpeed),
            end_ratio: self.end_hz().unwrap_or(hz) / hz,
            end_stable,
            stable_after_s: after(called_s, unstable_until).filter(|_| end_stable),
            released_after_s: after(unstable_until, released)
                .filter(|_| end_stable)
                .map(|s| s.max(0.0)),
            less_db: less(&|played| played.vibration_m().0),
            chatter_less_db: less(&|played| played.vibration_m().1),
            false_calls: self
                .alarms
                .iter()
                .filter(|(on, _)| stable_since(*on))
                .count(),
        }
    }

    fn end_hz(&self) -> Option<f64> {
        self.speeds.last().map(|(_, hz)| *hz)
    }

    /// Of the last half second, m rms: all of it, and what is left without the multiples of the
    /// rotation.
    fn vibration_m(&self) -> (f64, f64) {
        let [x, y] = [0, 1].map(|k| {
            let along: Vec<f64> = self.last_m.iter().map(|xy| xy[k]).collect();
            parts(&along, self.end_hz().unwrap_or(0.0) / FS_HZ)
        });
        (x.0.hypot(y.0), x.1.hypot(y.1))
    }
}

/// Root mean square about the mean, and without the multiples of so many turns a sample.
fn parts(samples: &[f64], turns: f64) -> (f64, f64) {
    // Whole turns: the multiples are then orthogonal.
    let whole = (samples.len() as f64 * turns).floor();
    let count = ((whole / turns).round() as usize).min(samples.len());
    let samples = &samples[samples.len() - count..];
    let mean = samples.iter().sum::<f64>() / count as f64;
    let about: Vec<f64> = samples.iter().map(|x| x - mean).collect();
    let all = rms(&about);
    let mut forced = 0.0;
    for k in 1..=(MULTIPLES_HZ / FS_HZ / turns) as u32 {
        let step = TAU * f64::from(k) * turns;
        let (mut re, mut im) = (0.0, 0.0);
        for (n, x) in about.iter().enumerate() {
            let (sin, cos) = (step * n as f64).sin_cos();
            re += x * cos;
            im += x * sin;
        }
        forced += 2.0 * (re * re + im * im) / (count as f64).powi(2);
    }
    (all, (all * all - forced).max(1e-8 * all * all).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_the_rotation_are_told_from_the_rest() {
        // 93.7 turns a second: their seventh and thirtieth multiple, and 1000 Hz.
        let wave = |f_hz: f64, n: u32| (TAU * f_hz * f64::from(n) / FS_HZ + 0.3).sin();
        let samples: Vec<f64> = (0..24_000)
            .map(|n| 5.0 + wave(7.0 * 93.7, n) + wave(30.0 * 93.7, n) + 0.1 * wave(1000.0, n))
            .collect();
        let (all, rest) = parts(&samples, 93.7 / FS_HZ);
        assert!((all - 1.005_f64.sqrt()).abs() < 0.005, "{all}");
        assert!((rest - 0.1 / 2.0_f64.sqrt()).abs() < 0.01, "{rest}");
    }
}
