//! What is true of a cut that was played in a loop, by its delay equation; and which cuts are
//! played.

use crate::act_loop::{FS_HZ, Played};
use crate::advice::{Case, Within, plays};
use crate::statistics::rms;
use core::f64::consts::TAU;
use core::ops::Range;
use rarma_cli::controller::{ActRecord, What};
use rarma_plants::population::{Cut, SAFE_PART};
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
            less_db: less(&|played| vibration_m(&played.last).0),
            chatter_less_db: less(&|played| vibration_m(&played.last).1),
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
}

/// Of turns of the spindle and places of the tool, m: the vibration, m rms, and what is left of it without what comes
/// again with each turn, the chatter.
#[must_use]
pub fn vibration_m(samples: &[(f64, [f64; 2])]) -> (f64, f64) {
    let [x, y] = [0, 1].map(|k| {
        let along = samples.iter().map(|(turns, xy)| (*turns, xy[k]));
        parts(&along.collect::<Vec<_>>())
    });
    (x.0.hypot(y.0), x.1.hypot(y.1))
}

/// Root mean square about the mean of what comes at these turns of the spindle, and without what comes again
/// with each of them: by the angle, for a spindle that still settles has no frequency to take away.
fn parts(samples: &[(f64, f64)]) -> (f64, f64) {
    let turns_at = |sample: Option<&(f64, f64)>| sample.map_or(0.0, |s| s.0);
    let (from, to) = (turns_at(samples.first()), turns_at(samples.last()));
    // Whole turns: the multiples are then orthogonal.
    let from = to - (to - from).floor();
    let begin = samples.partition_point(|(turns, _)| *turns <= from);
    let samples = &samples[begin..];
    let count = samples.len() as f64;
    let mean = samples.iter().map(|(_, x)| x).sum::<f64>() / count;
    let mut left: Vec<f64> = samples.iter().map(|(_, x)| x - mean).collect();
    let all = rms(&left);
    let turns_per_s = (to - from) / count * FS_HZ;
    for k in 1..=(MULTIPLES_HZ / turns_per_s) as u32 {
        let wave: Vec<(f64, f64)> = samples
            .iter()
            .map(|(turns, _)| (TAU * f64::from(k) * turns).sin_cos())
            .collect();
        let along = |of: fn(&(f64, f64)) -> f64| {
            let sum: f64 = left.iter().zip(&wave).map(|(x, w)| x * of(w)).sum();
            2.0 * sum / count
        };
        let (sin, cos) = (along(|w| w.0), along(|w| w.1));
        for (x, w) in left.iter_mut().zip(&wave) {
            *x -= sin * w.0 + cos * w.1;
        }
    }
    (all, rms(&left).max(1e-4 * all))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The seventh and thirtieth multiple of the rotation, and 1000 Hz.
    fn judged(turns: impl Fn(f64) -> f64) -> (f64, f64) {
        let samples: Vec<(f64, f64)> = (0..24_000)
            .map(|n| {
                let t_s = f64::from(n) / FS_HZ;
                let wave = |cycles: f64| (TAU * cycles + 0.3).sin();
                let turns = turns(t_s);
                let x = wave(7.0 * turns) + wave(30.0 * turns) + 0.1 * wave(1000.0 * t_s);
                (turns, 5.0 + x)
            })
            .collect();
        parts(&samples)
    }

    #[test]
    fn multiples_of_the_rotation_are_told_from_the_rest() {
        // 93.7 turns a second; and a spindle that settles there from 0.3 % above.
        let even = judged(|t_s| 93.7 * t_s);
        let settling = judged(|t_s| 93.7 * (t_s - 0.003 * 0.1 * (-t_s / 0.1).exp()));
        for (all, rest) in [even, settling] {
            assert!((all - 1.005_f64.sqrt()).abs() < 0.005, "{all}");
            assert!((rest - 0.1 / 2.0_f64.sqrt()).abs() < 0.01, "{rest}");
        }
    }
}
