//! Do two sensors hear the same mode, and are both suspicious of it?
//!
//! Rate: decision rate. The two listen to one machine: a mode of the machine lies
//! at one frequency with one damping ratio wherever it is read, only its amplitude
//! depends on the place.

use super::mode::{Label, Mode};
use crate::real::Real;

/// Who hears the mode in question: the alarm's, else the loudest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
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
const AGREE_SDS: f64 = 2.0;
/// Frequencies closer than this part of f are one, however sure the readings are:
/// the estimators converge apart, and a limit cycle wanders.
const AGREE_LEAST: f64 = 0.01;
/// Frequencies further apart than this part of f are two, however unsure the
/// readings are.
const AGREE_MOST: f64 = 0.05;
/// Suspicion of each that is enough where two sensors are suspicious of the same mode.
///
/// Two sensors share the randomness of the process: what one reads wrong for that
/// reason, the other does too, and agreement is worth little. A mode of 1.5 % was called
/// 20 times in 6.4 min by two sensors that call on their own, 22 times with 0.9, 29 with
/// 0.75, 41 with 0.6; the call of a true one came at 46, 44, 42, 34 ms.
const JOINT_SUSPICION: f64 = 0.9;

/// Two readings of one mode: |f₁ − f₂| within [`AGREE_SDS`]·√(sd₁² + sd₂²), at least
/// [`AGREE_LEAST`] and at most [`AGREE_MOST`] of the lower f. NaN is nobody's mode.
fn same_mode<T: Real>(a: &Mode<T>, b: &Mode<T>) -> bool {
    let sd = (a.frequency_sd * a.frequency_sd + b.frequency_sd * b.frequency_sd).sqrt();
    let f = a.frequency.min(b.frequency);
    let width = (sd * T::from_f64(AGREE_SDS))
        .clamp(f * T::from_f64(AGREE_LEAST), f * T::from_f64(AGREE_MOST));
    (a.frequency - b.frequency).abs() <= width
}

/// The mode of `modes` that is `mode`, the nearest if there are several.
pub(crate) fn partner<T: Real>(mode: &Mode<T>, modes: &[Option<Mode<T>>]) -> Option<Mode<T>> {
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
pub(crate) fn unexplained<T: Real>(mode: &Mode<T>) -> bool {
    !mode.origin.explains() && mode.label != Label::Forced
}

/// Whichever of two readings of a mode is surer of its damping.
pub(crate) fn surer<T: Real>(a: Mode<T>, b: Mode<T>) -> Mode<T> {
    if b.damping_sd < a.damping_sd { b } else { a }
}

/// The loudest mode that two sensors are both suspicious of: each for
/// [`JOINT_SUSPICION`] of what a call by one alone needs, and nothing explains it.
pub(crate) fn jointly_suspicious<T: Real>(
    first: &[Option<Mode<T>>],
    second: &[Option<Mode<T>>],
) -> Option<Mode<T>> {
    let enough = |m: &Mode<T>| unexplained(m) && m.suspicion >= T::from_f64(JOINT_SUSPICION);
    let mut found: Option<Mode<T>> = None;
    for mode in first.iter().flatten().filter(|m| enough(m)) {
        let Some(other) = partner(mode, second).filter(|m| enough(m)) else {
            continue;
        };
        if found.is_none_or(|f| mode.share > f.share) {
            found = Some(Mode {
                share: mode.share,
                ..surer(*mode, other)
            });
        }
    }
    found
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
            share_of_all: 0.6,
            gradient: 0.0,
            time_left_s: None,
            label: Label::Structural,
            origin: Origin::Free,
            harmonic: None,
            suspicion: 0.0,
            evidence: Evidence::default(),
            was_damped: false,
            grew: false,
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

    #[test]
    fn both_must_be_suspicious_of_the_same_mode() {
        let sure = Mode {
            suspicion: 0.95,
            ..mode(900.0, 0.5, 0.001, 0.0005)
        };
        let at = |other| {
            let found = jointly_suspicious(&[None, Some(sure)], &[Some(other)]);
            found.map(|m| (m.frequency, m.damping_sd))
        };
        let surer = Mode {
            frequency: 903.0,
            damping_sd: 0.0004,
            ..sure
        };
        assert_eq!(at(surer), Some((903.0, 0.0004)));
        for other in [
            Mode {
                frequency: 980.0,
                ..sure
            },
            Mode {
                suspicion: 0.85,
                ..sure
            },
            Mode {
                label: Label::Forced,
                ..sure
            },
            Mode {
                origin: Origin::Rotation,
                ..sure
            },
        ] {
            assert_eq!(at(other), None, "{other:?}");
        }
    }
}
