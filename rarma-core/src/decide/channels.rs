//! Which of two channels can be believed: what is wrong with a channel is named, and
//! the channel left out until it has been well for a while.
//!
//! Rate: decision rate. Bad samples are found by the health room, sample by sample.
//! Two faults only show beside another channel: one that stays silent while the other
//! comes alive, and one that reads another damping of the same loud mode.

use super::agreement::{partner, unexplained};
use super::config::AlarmConfig;
use super::mode::Mode;
use crate::condition::Fault;
use crate::real::Real;

/// What is wrong with a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ChannelFault {
    /// Its samples cannot be trusted.
    Samples(Fault),
    /// Its level is below [`SILENT_RATIO`] of the other's and stays where it is while
    /// the other moves by [`MOVED_RATIO`].
    Silent,
    /// It reads another damping of the same loud mode, and is the less sure of the two.
    Contradicts,
}

/// A channel that is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Dropped {
    /// Which, 0 or 1.
    pub channel: u8,
    /// Why.
    pub fault: ChannelFault,
}

/// What one channel says at a decision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hearing<'a, T> {
    /// What is wrong with its samples.
    pub fault: Option<Fault>,
    /// It judges: neither starting nor invalid.
    pub judging: bool,
    /// It says that something is being cut.
    pub cutting: bool,
    /// Root mean square of its band, input units.
    pub level: T,
    /// Its modes.
    pub modes: &'a [Option<Mode<T>>],
}

/// A dead channel's level relative to the other's (−80 dB).
pub const SILENT_RATIO: f64 = 1e-4;
/// The other has come alive: its level has changed by this factor (12 dB).
pub const MOVED_RATIO: f64 = 4.0;
/// A channel that has changed by less than this factor (3 dB) has not moved.
const STILL_RATIO: f64 = 1.41;
/// Two readings contradict each other for this long, s, before one is dropped.
const CONTRADICTION_S: f64 = 0.5;
/// Readings of ζ contradict each other when they differ by this many joint standard
/// deviations and by twice the threshold.
const CONTRADICTION_SDS: f64 = 3.0;
/// A channel must have been well for this long, s, before it is heard again. The
/// estimator's memory is a tenth of it.
const TAKEN_BACK_S: f64 = 1.0;
/// Smoothing of the level, s.
const LEVEL_TAU_S: f64 = 0.1;
/// Memory of the highest and the lowest level, s.
const RANGE_TAU_S: f64 = 10.0;

/// The level of a channel and where it has been lately.
#[derive(Debug, Clone, Copy)]
struct Range<T> {
    level: Option<T>,
    low: T,
    high: T,
}

impl<T: Real> Range<T> {
    const NEW: Self = Self {
        level: None,
        low: T::ZERO,
        high: T::ZERO,
    };

    fn update(&mut self, level: T, period_s: T) {
        let gain = |tau: f64| (period_s / T::from_f64(tau)).min(T::ONE);
        let Some(before) = self.level else {
            *self = Self {
                level: Some(level),
                low: level,
                high: level,
            };
            return;
        };
        let now = before + gain(LEVEL_TAU_S) * (level - before);
        self.level = Some(now);
        let forget = gain(RANGE_TAU_S);
        self.low = (self.low + forget * (now - self.low)).min(now);
        self.high = (self.high + forget * (now - self.high)).max(now);
    }

    fn moved(&self, ratio: f64) -> bool {
        self.high > self.low * T::from_f64(ratio)
    }
}

/// One channel's standing.
#[derive(Debug, Clone, Copy)]
struct Watch<T> {
    fault: Option<ChannelFault>,
    well_s: T,
    range: Range<T>,
}

/// Watches two channels of one machine.
#[derive(Debug, Clone)]
pub(crate) struct ChannelWatch<T> {
    watches: [Watch<T>; 2],
    contradiction_s: T,
}

impl<T: Real> Default for ChannelWatch<T> {
    fn default() -> Self {
        let watch = Watch {
            fault: None,
            well_s: T::ZERO,
            range: Range::NEW,
        };
        Self {
            watches: [watch; 2],
            contradiction_s: T::ZERO,
        }
    }
}

/// How two channels' readings of the same loud mode compare.
enum Comparison {
    /// They have none in common.
    Nothing,
    Agree,
    /// The channel that is less sure.
    Contradict(usize),
}

impl<T: Real> ChannelWatch<T> {
    /// One decision; `period_s` is the time since the last one.
    pub fn update(&mut self, heard: [Hearing<'_, T>; 2], config: &AlarmConfig<T>, period_s: T) {
        for (watch, hearing) in self.watches.iter_mut().zip(&heard) {
            if hearing.fault.is_none() && hearing.judging && hearing.level.is_finite() {
                watch.range.update(hearing.level, period_s);
            }
        }
        let silent = [self.is_silent(0), self.is_silent(1)];
        let comparison = compare(&heard, config);
        self.contradiction_s = match comparison {
            Comparison::Contradict(_) => self.contradiction_s + period_s,
            _ => (self.contradiction_s - period_s).max(T::ZERO),
        }
        .min(T::from_f64(CONTRADICTION_S));
        let contradict = self.contradiction_s >= T::from_f64(CONTRADICTION_S);
        for i in 0..2 {
            let other_sick = heard[1 - i].fault.is_some();
            let other_dropped = self.watches[1 - i].fault.is_some();
            let watch = &mut self.watches[i];
            if let Some(fault) = heard[i].fault {
                watch.fault = Some(ChannelFault::Samples(fault));
                watch.well_s = T::ZERO;
                continue;
            }
            let Some(fault) = watch.fault else {
                // The last channel is not dropped for what another says of it.
                if silent[i] && !other_dropped {
                    watch.fault = Some(ChannelFault::Silent);
                    watch.well_s = T::ZERO;
                } else if let Comparison::Contradict(less_sure) = comparison
                    && less_sure == i
                    && contradict
                    && !other_dropped
                {
                    watch.fault = Some(ChannelFault::Contradicts);
                    watch.well_s = T::ZERO;
                }
                continue;
            };
            watch.well_s = match (fault, &comparison) {
                (ChannelFault::Silent, _) if silent[i] => T::ZERO,
                (ChannelFault::Contradicts, Comparison::Contradict(_)) => T::ZERO,
                // Nothing in common proves nothing.
                (ChannelFault::Contradicts, Comparison::Nothing) => watch.well_s,
                _ => watch.well_s + period_s,
            };
            // Better than none at all.
            let needed = fault == ChannelFault::Contradicts && other_sick;
            if watch.well_s >= T::from_f64(TAKEN_BACK_S) || needed {
                watch.fault = None;
            }
        }
    }

    /// Why channel `i` is left out, if it is.
    pub fn dropped(&self, i: usize) -> Option<Dropped> {
        let fault = self.watches.get(i)?.fault?;
        Some(Dropped {
            channel: i as u8,
            fault,
        })
    }

    /// Silent now. A channel that has been dropped for it stays so as long as its
    /// level is that low, whether the other moves on or not.
    fn is_silent(&self, i: usize) -> bool {
        let (own, other) = (&self.watches[i], &self.watches[1 - i]);
        let (Some(level), Some(beside)) = (own.range.level, other.range.level) else {
            return false;
        };
        let low = level < beside * T::from_f64(SILENT_RATIO);
        let known = own.fault == Some(ChannelFault::Silent);
        low && (known || other.range.moved(MOVED_RATIO) && !own.range.moved(STILL_RATIO))
    }
}

/// Compares the loudest mode that both hear and nothing explains.
fn compare<T: Real>(heard: &[Hearing<'_, T>; 2], config: &AlarmConfig<T>) -> Comparison {
    if heard
        .iter()
        .any(|h| h.fault.is_some() || !h.judging || !h.cutting)
    {
        return Comparison::Nothing;
    }
    let mut loudest: Option<(Mode<T>, Mode<T>)> = None;
    for mode in heard[0].modes.iter().flatten() {
        let Some(other) = partner(mode, heard[1].modes) else {
            continue;
        };
        let loud = |m: &Mode<T>| config.loud(m.share, m.share_of_all);
        let loud = loud(mode) && loud(&other);
        if loud
            && unexplained(mode)
            && unexplained(&other)
            && loudest.is_none_or(|(m, _)| mode.share > m.share)
        {
            loudest = Some((*mode, other));
        }
    }
    let Some((a, b)) = loudest else {
        return Comparison::Nothing;
    };
    let off = (a.damping - b.damping).abs();
    let sd = (a.damping_sd * a.damping_sd + b.damping_sd * b.damping_sd).sqrt();
    let differ =
        off > sd * T::from_f64(CONTRADICTION_SDS) && off > config.threshold + config.threshold;
    match differ {
        false => Comparison::Agree,
        true => Comparison::Contradict(usize::from(b.damping_sd >= a.damping_sd)),
    }
}

#[cfg(test)]
#[path = "channels_tests.rs"]
mod tests;
