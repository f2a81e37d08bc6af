//! The verdict: threshold on ζ with hysteresis, and the alarm it raises.
//!
//! Rate: decision rate. The rule of the first verdict, in words: a mode is
//! *undamped* where ζ lies below the threshold, the more so the more standard
//! deviations it lies below, and *loud* where it holds a good part of the band's
//! power. Undamped, loud, not explained by the rotation, and that for a while:
//! chatter. It is over when the damping is back for certain, or the vibration has
//! gone. In between nothing changes: a limit cycle that the spindle modulates reads
//! several percent at times, and is chatter all the same.

use super::config::AlarmConfig;
use super::mode::{Label, Mode};
use super::origin::Origin;
use crate::condition::Fault;
use crate::real::Real;
use crate::visit::state;

/// What the monitor believes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum State {
    /// Not enough signal yet.
    Starting,
    /// Nothing is being cut.
    Idle,
    /// Cutting; every mode is damped.
    Stable,
    /// A mode is losing its damping, or is undamped for too short a time to be called.
    Warning,
    /// Chatter: a self-excited mode has been called.
    Chatter,
    /// The samples cannot be trusted; nothing is concluded from them.
    Invalid,
}

/// Why the monitor believes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reason {
    /// No reason to give.
    None,
    /// The estimator is in its start-up.
    EstimatorStarting,
    /// The roots are being searched for anew.
    RootsLost,
    /// The level is that of idle.
    LevelAtIdle,
    /// A mode is undamped and loud, for too short a time to be called.
    Undamped,
    /// At its present rate a mode reaches the threshold soon.
    LosingDamping,
    /// A mode is undamped but something else explains it, see [`Origin`](super::Origin).
    ForcedOnly,
    /// A mode is undamped, and whether it is forced or self-excited cannot be told: give
    /// the spindle speed.
    OriginUnknown,
    /// The cut has just begun: the speed dips and every mode is rung.
    Entering,
    /// The samples are bad, see the fault.
    Samples(Fault),
    /// A line at a multiple of the speed has risen by itself: a chatter there cannot be
    /// told from it.
    BlindAtMultiple,
    /// The box itself shakes the structure: modes are told, no verdict.
    Excited,
}

/// The standing alarm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct AlarmInForce<T> {
    /// Place of the mode among the tracked ones.
    pub slot: usize,
    /// Power-weighted mean frequency since the call, Hz; of the majority of the lines once one
    /// holds the alarm.
    pub frequency: T,
    /// Lowest damping ratio since the call.
    pub lowest_damping: T,
    mean_amplitude: T,
    weight: T,
    over_s: T,
    explained_s: T,
    undamped_s: T,
    back_s: T,
    /// How much longer lines have stood at the frequency than elsewhere, s; none while only a
    /// mode has called.
    line_s: Option<T>,
}

state! { AlarmInForce<T> {
    slot, frequency, lowest_damping, mean_amplitude, weight, over_s, explained_s,
    undamped_s, back_s, line_s
} }

/// Undamped for this long in all, an alarm is established, s: it then holds through
/// damping that is smeared by modulation.
const ESTABLISHED_S: f64 = 0.5;

impl<T: Real> AlarmInForce<T> {
    /// The mode has been undamped for [`ESTABLISHED_S`] in all.
    pub fn is_established(&self) -> bool {
        self.undamped_s >= T::from_f64(ESTABLISHED_S)
    }

    /// A line takes the alarm over from a mode. Chatter has sidebands, and the strongest line
    /// is now one and now the other: the frequency is that of the majority.
    fn hear_line(&mut self, line_hz: T, period_s: T) {
        let here = (line_hz - self.frequency).abs() < self.frequency * T::from_f64(SAME_MODE);
        let stood_s = self.line_s.unwrap_or(T::ZERO);
        self.line_s = Some(if here {
            let stood_s = stood_s + period_s;
            self.frequency += (period_s / stood_s) * (line_hz - self.frequency);
            stood_s
        } else if stood_s > T::ZERO {
            stood_s - period_s
        } else {
            self.frequency = line_hz;
            period_s
        });
    }
}

/// What happened to the alarm in one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AlarmEvent<T> {
    /// Nothing.
    None,
    /// Called: mode frequency (Hz) and damping ratio.
    On {
        /// Frequency of the mode, Hz.
        frequency: T,
        /// Its damping ratio.
        damping: T,
    },
    /// Released: mean frequency (Hz) and lowest damping ratio while it stood.
    Off {
        /// Power-weighted mean frequency, Hz.
        frequency: T,
        /// Lowest damping ratio.
        lowest_damping: T,
    },
}

/// Who may call at one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Callers<'a, T> {
    /// Whether each mode may.
    pub modes: &'a [bool],
    /// The verdict on lines calls the one at this frequency, Hz.
    pub line_hz: Option<T>,
}

/// Raises and releases the alarm.
#[derive(Debug, Clone)]
pub(crate) struct Alarm<T> {
    config: AlarmConfig<T>,
    standing: Option<AlarmInForce<T>>,
    /// The alarm before, and for how long it is still remembered, s.
    before: Option<(AlarmInForce<T>, T)>,
}

state! { Alarm<T> {
    standing, before;
    settings config
} }

/// Memory of the mean amplitude while an alarm stands, s.
const AMPLITUDE_TAU_S: f64 = 1.0;
/// On a multiple of the speed for this long, the alarm was a forced line, s; half
/// of it for an alarm that is not established.
const EXPLAINED_S: f64 = 1.0;
/// The alarm's mode may jump this far (relative) to another place and is still it.
const SAME_MODE: f64 = 0.03;

/// A mode this suspicious is worth a warning.
const WARN_AT: f64 = 0.5;
/// Damping that is back for certain, at less than this part of the mean amplitude, for
/// this long, s, ends an alarm.
const WELL_BELOW: f64 = 0.5;
const BACK_S: f64 = 0.03;

/// After a release, the same mode is called again only if it is louder than what
/// rings on, for this long, s.
const AFTERGLOW_S: f64 = 1.0;

/// The mode is where the alarm is.
fn is_near<T: Real>(alarm: &AlarmInForce<T>, mode: &Mode<T>) -> bool {
    (mode.frequency - alarm.frequency).abs() < alarm.frequency * T::from_f64(SAME_MODE)
}

impl<T: Real> Alarm<T> {
    /// No alarm.
    pub fn new(config: AlarmConfig<T>) -> Self {
        Self {
            config,
            standing: None,
            before: None,
        }
    }

    /// The settings of the verdict.
    pub fn config(&self) -> &AlarmConfig<T> {
        &self.config
    }

    /// The alarm that stands, if one does.
    pub fn standing(&self) -> Option<&AlarmInForce<T>> {
        self.standing.as_ref()
    }

    /// One decision over the modes and the lines. What the lines have called, or joined, ends
    /// when they end it.
    pub fn update(
        &mut self,
        modes: &[Option<Mode<T>>],
        callers: &Callers<'_, T>,
        period_s: T,
    ) -> AlarmEvent<T> {
        self.before = self
            .before
            .map(|(alarm, left_s)| (alarm, left_s - period_s))
            .filter(|(_, left_s)| *left_s > T::ZERO);
        match self.standing {
            Some(standing) => self.follow(standing, modes, callers.line_hz, period_s),
            None => match callers.line_hz {
                Some(line_hz) => self.call_line(line_hz, modes),
                None => self.call(modes, callers.modes),
            },
        }
    }

    /// The line, and the mode that is nearest to it.
    fn call_line(&mut self, line_hz: T, modes: &[Option<Mode<T>>]) -> AlarmEvent<T> {
        let apart = |mode: &Mode<T>| (mode.frequency - line_hz).abs();
        let mut nearest: Option<(usize, &Mode<T>)> = None;
        for (slot, mode) in modes.iter().enumerate() {
            if let Some(mode) = mode
                && nearest.is_none_or(|(_, m)| apart(mode) < apart(m))
            {
                nearest = Some((slot, mode));
            }
        }
        let damping = nearest.map_or(T::ZERO, |(_, mode)| mode.damping);
        let amplitude = nearest.map_or(T::ZERO, |(_, mode)| mode.amplitude);
        self.standing = Some(AlarmInForce {
            slot: nearest.map_or(0, |(slot, _)| slot),
            frequency: line_hz,
            lowest_damping: damping,
            mean_amplitude: amplitude,
            weight: amplitude * amplitude,
            over_s: T::ZERO,
            explained_s: T::ZERO,
            undamped_s: T::ZERO,
            back_s: T::ZERO,
            line_s: Some(T::ZERO),
        });
        AlarmEvent::On {
            frequency: line_hz,
            damping,
        }
    }

    /// Loudest mode that has been suspect for long enough.
    fn call(&mut self, modes: &[Option<Mode<T>>], may_call: &[bool]) -> AlarmEvent<T> {
        let mut loudest: Option<(usize, &Mode<T>)> = None;
        for ((slot, mode), may_call) in modes.iter().enumerate().zip(may_call) {
            if let Some(mode) = mode
                && *may_call
                && mode.label == Label::SelfExcited
                && mode.suspicion >= T::ONE
                && !self.is_afterglow(mode)
                && loudest.is_none_or(|(_, m)| mode.amplitude > m.amplitude)
            {
                loudest = Some((slot, mode));
            }
        }
        let Some((slot, mode)) = loudest else {
            return AlarmEvent::None;
        };
        self.standing = Some(AlarmInForce {
            slot,
            frequency: mode.frequency,
            lowest_damping: mode.damping,
            mean_amplitude: mode.amplitude,
            weight: mode.amplitude * mode.amplitude,
            over_s: T::ZERO,
            explained_s: T::ZERO,
            undamped_s: self.config.confirm_s,
            back_s: T::ZERO,
            line_s: None,
        });
        AlarmEvent::On {
            frequency: mode.frequency,
            damping: mode.damping,
        }
    }

    /// What is left of a vibration that has just been released: the same mode, and
    /// no louder than when it was called gone.
    fn is_afterglow(&self, mode: &Mode<T>) -> bool {
        self.before.is_some_and(|(alarm, _)| {
            is_near(&alarm, mode)
                && mode.amplitude < alarm.mean_amplitude * self.config.gone_ratio * T::from_f64(2.0)
        })
    }

    fn follow(
        &mut self,
        mut s: AlarmInForce<T>,
        modes: &[Option<Mode<T>>],
        line_hz: Option<T>,
        period_s: T,
    ) -> AlarmEvent<T> {
        s.slot = self.locate(&s, modes);
        let mode = modes.get(s.slot).copied().flatten();
        let over = match mode {
            None => true,
            Some(mode) => {
                let damping = (mode.damping, mode.damping_sd);
                if self.config.undamped(damping) {
                    s.undamped_s += period_s;
                }
                let damped = self.config.damped(damping, s.is_established());
                let gone = mode.amplitude < s.mean_amplitude * self.config.gone_ratio;
                if !damped && !gone {
                    let gain = (period_s / T::from_f64(AMPLITUDE_TAU_S)).min(T::ONE);
                    s.mean_amplitude += gain * (mode.amplitude - s.mean_amplitude);
                    let w = mode.amplitude * mode.amplitude;
                    s.weight += w;
                    if s.weight > T::ZERO && s.line_s.is_none() {
                        s.frequency += (mode.frequency - s.frequency) * (w / s.weight);
                    }
                    if self.config.undamped(damping) {
                        s.lowest_damping = s.lowest_damping.min(mode.damping);
                    }
                }
                // Damped for certain by the test, and the vibration on its way down.
                let less = s.mean_amplitude * T::from_f64(WELL_BELOW);
                s.back_s = if mode.evidence.is_back(gone) && mode.amplitude < less {
                    s.back_s + period_s
                } else {
                    T::ZERO
                };
                damped || gone
            }
        };
        // A chatter frequency may drift through a multiple of the speed; one that
        // stays on it was a forced line all along.
        s.explained_s = match mode {
            Some(mode) if mode.origin == Origin::Rotation && mode.harmonic.is_some() => {
                s.explained_s + period_s
            }
            _ => T::ZERO,
        };
        let patience = if s.is_established() {
            T::from_f64(EXPLAINED_S)
        } else {
            T::from_f64(0.5 * EXPLAINED_S)
        };
        let explained = s.explained_s > patience;
        s.over_s = if over { s.over_s + period_s } else { T::ZERO };
        let back = s.back_s >= T::from_f64(BACK_S);
        if let Some(line_hz) = line_hz {
            s.hear_line(line_hz, period_s);
            (s.over_s, s.explained_s, s.back_s) = (T::ZERO, T::ZERO, T::ZERO);
            self.standing = Some(s);
            return AlarmEvent::None;
        }
        if s.line_s.is_none() && s.over_s < self.config.release_s && !explained && !back {
            self.standing = Some(s);
            return AlarmEvent::None;
        }
        self.standing = None;
        self.before = Some((s, T::from_f64(AFTERGLOW_S)));
        AlarmEvent::Off {
            frequency: s.frequency,
            lowest_damping: s.lowest_damping,
        }
    }

    /// Ends a standing alarm: nothing can be heard any more.
    pub fn release(&mut self) -> AlarmEvent<T> {
        match self.standing.take() {
            Some(s) => AlarmEvent::Off {
                frequency: s.frequency,
                lowest_damping: s.lowest_damping,
            },
            None => AlarmEvent::None,
        }
    }

    /// The alarm's mode keeps its place; if that place has gone elsewhere, the
    /// loudest mode close to the alarm's frequency takes over.
    fn locate(&self, s: &AlarmInForce<T>, modes: &[Option<Mode<T>>]) -> usize {
        let near = |mode: &Mode<T>| is_near(s, mode);
        let mut best = s.slot;
        let mut loudness = match modes.get(s.slot) {
            Some(Some(mode)) if near(mode) => mode.amplitude,
            _ => T::ZERO,
        };
        for (slot, mode) in modes.iter().enumerate() {
            if let Some(mode) = mode
                && near(mode)
                && mode.amplitude > loudness * T::from_f64(1.5)
            {
                best = slot;
                loudness = mode.amplitude;
            }
        }
        best
    }

    /// Puts the verdict into a word: the state and why. A mode that would be called if it
    /// might is of unknown origin.
    pub fn judge(
        &self,
        modes: &[Option<Mode<T>>],
        may_call: &[bool],
        cutting: bool,
    ) -> (State, Reason) {
        if self.standing.is_some() {
            return (State::Chatter, Reason::None);
        }
        if !cutting {
            return (State::Idle, Reason::LevelAtIdle);
        }
        let (mut forced, mut losing, mut unknown) = (false, false, false);
        for (mode, may_call) in modes.iter().zip(may_call) {
            let Some(mode) = mode else { continue };
            let c = &self.config;
            if mode.suspicion >= T::from_f64(WARN_AT) {
                if mode.label == Label::SelfExcited {
                    let is_barred = mode.suspicion >= T::ONE && !may_call;
                    let why = if is_barred {
                        Reason::OriginUnknown
                    } else {
                        Reason::Undamped
                    };
                    return (State::Warning, why);
                }
                unknown |= mode.origin == Origin::Unknown;
            }
            let undamped = c.undamped((mode.damping, mode.damping_sd));
            forced |= mode.label == Label::Forced && undamped;
            losing |= mode.label != Label::Forced
                && c.loud(mode.share, mode.share_of_all)
                && mode.damping < c.threshold * c.release_ratio
                && mode.time_left_s.is_some_and(|left| left < c.warn_ahead_s);
        }
        if losing {
            (State::Warning, Reason::LosingDamping)
        } else if unknown {
            (State::Warning, Reason::OriginUnknown)
        } else if forced {
            (State::Stable, Reason::ForcedOnly)
        } else {
            (State::Stable, Reason::None)
        }
    }
}

#[cfg(test)]
#[path = "alarm_tests.rs"]
mod tests;
