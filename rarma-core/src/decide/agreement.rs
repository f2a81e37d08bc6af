//! Do two sensors hear the same mode, and are both suspicious of it?
//!
//! Rate: decision rate. The two listen to one machine: a mode of the machine lies
//! at one frequency with one damping ratio wherever it is read, only its amplitude
//! depends on the place.

use super::config::AlarmConfig;
use super::mode::{Label, Mode};
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Who hears the mode in question: the alarm's, else the loudest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// Both do; or both listen and neither hears a mode at all.
    Both,
    /// Only the first does.
    OnlyFirst,
    /// Only the second does.
    OnlySecond,
    /// One channel at most is listened to: the others are dropped or still starting.
    Single,
}

/// Joint standard deviations within which two frequencies are one.
pub const AGREE_SDS: f64 = 2.0;
/// Frequencies closer than this part of f are one, however sure the readings are:
/// the estimators converge apart, and a limit cycle wanders.
pub const AGREE_LEAST: f64 = 0.01;
/// Frequencies further apart than this part of f are two, however unsure the
/// readings are.
pub const AGREE_MOST: f64 = 0.05;
/// Of the share that makes a mode loud, the part that the quieter of two agreeing
/// sensors must have.
const QUIETER_PART: f64 = 0.5;
/// Standard deviations that both readings of ζ must lie below the threshold.
pub const CERTAIN_SDS: f64 = 2.0;
/// Suspicion of two that agree grows by this much a second, s.
const JOINT_RATE: f64 = 2.0;
/// Joint suspicion is remembered for this many confirmation times at most.
const MOST_CONFIRMATIONS: f64 = 2.0;

/// Two readings of one mode: |f₁ − f₂| within [`AGREE_SDS`]·√(sd₁² + sd₂²), at least
/// [`AGREE_LEAST`] and at most [`AGREE_MOST`] of the lower f. NaN is nobody's mode.
pub fn same_mode<T: Real>(a: &Mode<T>, b: &Mode<T>) -> bool {
    let sd = (a.frequency_sd * a.frequency_sd + b.frequency_sd * b.frequency_sd).sqrt();
    let f = a.frequency.min(b.frequency);
    let width = (sd * T::from_f64(AGREE_SDS))
        .clamp(f * T::from_f64(AGREE_LEAST), f * T::from_f64(AGREE_MOST));
    (a.frequency - b.frequency).abs() <= width
}

/// The mode of `modes` that is `mode`, the nearest if there are several.
pub fn partner<T: Real>(mode: &Mode<T>, modes: &[Option<Mode<T>>]) -> Option<Mode<T>> {
    let mut best: Option<Mode<T>> = None;
    for other in modes.iter().flatten() {
        let off = (other.frequency - mode.frequency).abs();
        if same_mode(mode, other) && best.is_none_or(|b| off < (b.frequency - mode.frequency).abs())
        {
            best = Some(*other);
        }
    }
    best
}

/// Nothing else explains the mode, and it is no line of unknown origin.
pub fn unexplained<T: Real>(mode: &Mode<T>) -> bool {
    !mode.origin.explains() && mode.label != Label::Forced
}

/// Whichever of two readings of a mode is surer of its damping.
pub fn surer<T: Real>(a: Mode<T>, b: Mode<T>) -> Mode<T> {
    if b.damping_sd < a.damping_sd { b } else { a }
}

/// For how long two sensors have been suspicious of the same mode.
///
/// While both read ζ + [`CERTAIN_SDS`]·sd below the threshold at one frequency, not
/// explained, the one loud and the other at least half as loud, suspicion grows by two
/// seconds a second (a single sensor's grows by one at most, [`AlarmConfig::evidence`]);
/// otherwise it falls by one.
///
/// Certainty is asked for because two sensors share the randomness of the process:
/// what one reads wrong for that reason, the other does too. With evidence as weak as
/// a single sensor's the calls of a damped mode (1.5 %) rose from 4 to 11 in 128 s;
/// with two standard deviations the call is as soon, and those calls are 5.
#[derive(Debug, Clone, Copy)]
pub struct JointSuspicion<T> {
    mode: Option<Mode<T>>,
    suspicion_s: T,
}

impl<T: Real> Default for JointSuspicion<T> {
    fn default() -> Self {
        Self {
            mode: None,
            suspicion_s: T::ZERO,
        }
    }
}

impl<T: Real> JointSuspicion<T> {
    /// One decision. `band` is the lowest and the highest frequency that may be
    /// called, Hz; `period_s` the time since the last decision.
    pub fn update(
        &mut self,
        first: &[Option<Mode<T>>],
        second: &[Option<Mode<T>>],
        config: &AlarmConfig<T>,
        band: (T, T),
        period_s: T,
    ) {
        let certain =
            |m: &Mode<T>| config.undamped((m.damping, m.damping_sd * T::from_f64(CERTAIN_SDS)));
        let mut found: Option<(Mode<T>, T)> = None;
        for mode in first.iter().flatten() {
            let Some(other) = partner(mode, second) else {
                continue;
            };
            let here = surer(*mode, other);
            let (louder, quieter) = (mode.share.max(other.share), mode.share.min(other.share));
            let suspect = unexplained(mode)
                && unexplained(&other)
                && here.frequency >= band.0
                && here.frequency <= band.1
                && config.loud(louder)
                && quieter >= config.loud_share * T::from_f64(QUIETER_PART)
                && certain(mode)
                && certain(&other);
            if suspect && found.is_none_or(|(_, loudness)| louder > loudness) {
                found = Some((here, louder));
            }
        }
        let Some((mode, _)) = found else {
            self.suspicion_s = (self.suspicion_s - period_s).max(T::ZERO);
            return;
        };
        if !self.mode.is_some_and(|before| same_mode(&before, &mode)) {
            self.suspicion_s = T::ZERO;
        }
        self.mode = Some(mode);
        let most = config.confirm_s * T::from_f64(MOST_CONFIRMATIONS);
        self.suspicion_s = (self.suspicion_s + period_s * T::from_f64(JOINT_RATE)).min(most);
    }

    /// Joint suspicion, s.
    pub fn suspicion_s(&self) -> T {
        self.suspicion_s
    }

    /// The mode, once the suspicion has lasted for the time that confirms it.
    pub fn confirmed(&self, config: &AlarmConfig<T>) -> Option<Mode<T>> {
        self.mode.filter(|_| self.suspicion_s >= config.confirm_s)
    }

    /// Forgets.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::{Evidence, Origin};

    fn mode(frequency: f64, frequency_sd: f64, damping: f64, damping_sd: f64) -> Mode<f64> {
        Mode {
            frequency,
            frequency_sd,
            damping,
            damping_sd,
            amplitude: 1.0,
            share: 0.6,
            gradient: 0.0,
            time_left_s: None,
            label: Label::Structural,
            origin: Origin::Free,
            harmonic: None,
            suspicion: 0.0,
            evidence: Evidence::default(),
        }
    }

    #[test]
    fn one_mode_within_the_joint_uncertainty() {
        let at = |f, sd| mode(f, sd, 0.01, 0.001);
        // One percent always; five at most; the joint deviation in between.
        assert!(same_mode(&at(900.0, 0.1), &at(908.9, 0.1)));
        assert!(!same_mode(&at(900.0, 0.1), &at(909.1, 0.1)));
        assert!(same_mode(&at(900.0, 6.0), &at(919.9, 8.0)));
        assert!(!same_mode(&at(900.0, 6.0), &at(920.1, 8.0)));
        assert!(!same_mode(&at(900.0, 500.0), &at(946.0, 500.0)));
        assert!(!same_mode(&at(900.0, f64::NAN), &at(900.0, 1.0)));
        let others = [Some(at(905.0, 1.0)), None, Some(at(901.0, 1.0))];
        let nearest = partner(&at(900.0, 1.0), &others).map(|m| m.frequency);
        assert_eq!(nearest, Some(901.0));
    }

    /// Decisions of 2 ms until both together are sure, none within a second.
    fn decisions(first: Mode<f64>, second: Mode<f64>) -> Option<usize> {
        let config = AlarmConfig::default();
        let mut joint = JointSuspicion::default();
        (1..=500).find(|_| {
            joint.update(
                &[Some(first)],
                &[None, Some(second)],
                &config,
                (300.0, 2500.0),
                0.002,
            );
            joint.confirmed(&config).is_some()
        })
    }

    #[test]
    fn two_that_agree_are_sure_in_half_the_time() {
        let sure = mode(900.0, 0.5, 0.001, 0.0005);
        // 60 ms of evidence, 4 ms of it with every 2 ms.
        assert_eq!(decisions(sure, sure), Some(15));
        for other in [
            mode(900.0, 1.0, 0.007, 0.0016),
            mode(980.0, 1.0, 0.001, 0.0005),
            mode(900.0, 1.0, 0.02, 0.002),
            Mode { share: 0.1, ..sure },
            Mode {
                label: Label::Forced,
                ..sure
            },
            Mode {
                origin: Origin::Rotation,
                ..sure
            },
        ] {
            assert_eq!(decisions(sure, other), None, "{other:?}");
        }
        let outside = mode(2600.0, 0.5, 0.001, 0.0005);
        assert_eq!(decisions(outside, outside), None);
    }
}
