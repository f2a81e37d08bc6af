//! A speed that moves away from its lines is read off the model's poles.
//!
//! The search for lines needs a speed that holds still for its frame (1.2 s at 1650 Hz), and
//! the loop of the lines follows no more than its memory allows. An override turned step by
//! step outruns both. The lines are in the signal again then, and the model has them as poles
//! of no damping: one near the line that was the loudest, and another one at a multiple of the
//! speed which that one tells, are the rotation. A chatter beside a line moves alone. Where
//! one line is nearly all there is, it tells the speed by itself for a while.
//!
//! Rate: decision rate.

use super::Spindle;
use crate::condition::Lock;
use crate::decide::{Mode, SPEED_ACCURACY};
use crate::real::Real;
use crate::visit::state;

/// For so long after two poles, the lines or the setting have told the speed, it is looked for
/// nearby, s.
const KNOWN_S: f64 = 2.0;
/// It has moved by this part of itself at most since it was last read.
const STRIDE: f64 = 0.015;
/// The poles of lines that move have no more damping than this.
const SMEARED: f64 = 0.02;
/// Two poles tell the same speed within so many standard deviations and this part of it: the
/// pole of the weaker line is late.
const AGREE_SD: f64 = 2.0;
const LATE: f64 = 0.002;
/// Where that is more than this part of the spacing, nearly every pole would agree.
const CHANCE: f64 = 0.05;
/// A pole that holds more than this part of all power is nearly all there is.
const DOMINATING: f64 = 0.8;
/// By itself only the line of a low multiple tells the speed: a stride is up to 0.09 of the
/// spacing there, and hardly a chatter lies so near.
const LOW_MULTIPLE: f64 = 6.0;

/// A pole pair of little damping.
#[derive(Debug, Clone, Copy)]
struct Pole<T> {
    /// Frequency and its standard deviation, Hz.
    hz: T,
    sd_hz: T,
    damping: T,
    amplitude: T,
    /// Part of all power.
    share: T,
}

impl<T: Real> Pole<T> {
    fn of(mode: &Mode<T>) -> Option<Self> {
        (mode.damping < T::from_f64(SMEARED)).then_some(Self {
            hz: mode.frequency,
            sd_hz: mode.frequency_sd,
            damping: mode.damping,
            amplitude: mode.amplitude,
            share: mode.share_of_all,
        })
    }
}

/// The least damped of the poles that hold nearly all of the power: a model of more poles than
/// there are modes puts two at one.
fn dominating<T: Real>(poles: impl Iterator<Item = Pole<T>>) -> Option<Pole<T>> {
    poles
        .filter(|pole| pole.share > T::from_f64(DOMINATING))
        .reduce(|a, b| if b.damping < a.damping { b } else { a })
}

/// The speed that was read last, Hz, its loudest line, and how long ago it was certain, s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moving<T> {
    loudest: u32,
    speed_hz: T,
    age_s: T,
}

state! { Moving<T> { loudest, speed_hz, age_s } }

impl<T: Real> Moving<T> {
    /// One line at the speed that was told is nearly all there is.
    fn at_rest(setting_hz: T, poles: impl Iterator<Item = Pole<T>>) -> Option<Self> {
        let pole = dominating(poles)?;
        let n = (pole.hz / setting_hz).round();
        let low = n >= T::ONE && n <= T::from_f64(LOW_MULTIPLE);
        let speed_hz = pole.hz / n;
        let there = (speed_hz - setting_hz).abs() < setting_hz * T::from_f64(SPEED_ACCURACY);
        (low && there).then(|| Self {
            loudest: n.to_f32() as u32,
            speed_hz,
            age_s: T::ZERO,
        })
    }

    /// Speed and its deviation, Hz, and whether two poles tell it.
    fn read_off(&self, poles: impl Iterator<Item = Pole<T>> + Clone) -> Option<(T, T, bool)> {
        if let Some((speed, sd)) = self.of_two(poles.clone()) {
            return Some((speed, sd, true));
        }
        let pole = dominating(poles)?;
        let n = T::from_u32(self.loudest);
        (n <= T::from_f64(LOW_MULTIPLE) && self.is_near(&pole))
            .then(|| (pole.hz / n, pole.sd_hz / n, false))
    }

    /// The pole may be the loudest line.
    fn is_near(&self, pole: &Pole<T>) -> bool {
        let line = T::from_u32(self.loudest) * self.speed_hz;
        (pole.hz - line).abs() < line * T::from_f64(STRIDE)
    }

    /// Speed and its deviation, Hz, that two poles tell together.
    fn of_two(&self, poles: impl Iterator<Item = Pole<T>> + Clone) -> Option<(T, T)> {
        let n = T::from_u32(self.loudest);
        let line = poles
            .clone()
            .filter(|pole| self.is_near(pole))
            .reduce(|a, b| if b.amplitude > a.amplitude { b } else { a })?;
        let (one, one_sd) = (line.hz / n, line.sd_hz / n);
        poles
            .filter_map(|pole| {
                let m = (pole.hz / one).round();
                if m < T::ONE || m == n {
                    return None;
                }
                let (other, other_sd) = (pole.hz / m, pole.sd_hz / m);
                let variance = one_sd * one_sd + other_sd * other_sd;
                let within = T::from_f64(AGREE_SD) * variance.sqrt() + one * T::from_f64(LATE);
                let apart = (one - other).abs();
                if !(apart < within && m * within < one * T::from_f64(CHANCE)) {
                    return None;
                }
                // Each by its weight; what they differ by is not known better.
                let weight = other_sd * other_sd / variance;
                let sd = (one_sd * other_sd / variance.sqrt()).max(apart * T::from_f64(0.5));
                Some((other + (one - other) * weight, sd))
            })
            .next()
    }
}

impl<T: Real> Spindle<T> {
    /// The modes of this decision: where the lines have lost the speed, those that stand for
    /// lines tell it. While an alarm stands only two together do: one alone may be the chatter.
    pub(in crate::monitor) fn hear_modes(&mut self, modes: &[Option<Mode<T>>], period_s: T) {
        if let Some((speed, _)) = self.locked() {
            self.remember_loudest(speed);
            return;
        }
        if self.tacho_reading.is_some() || self.is_denied() {
            return;
        }
        let held = self.standing.is_held();
        let poles = modes.iter().flatten().filter_map(Pole::of);
        let at_rest = |setting| Moving::at_rest(setting, poles.clone());
        if !held && let Some(moving) = self.setting.and_then(at_rest) {
            self.moving = moving;
            return;
        }
        self.moving.age_s += period_s;
        if self.moving.age_s > T::from_f64(KNOWN_S) {
            return;
        }
        let Some((speed, sd, are_two)) = self.moving.read_off(poles) else {
            return;
        };
        if held && !are_two {
            return;
        }
        self.moving.speed_hz = speed;
        if are_two {
            self.moving.age_s = T::ZERO;
        }
        self.found = Some(((speed, sd), T::ZERO));
        self.found_at_entry = false;
        self.carry(speed);
        let accuracy = speed * T::from_f64(SPEED_ACCURACY);
        if let Some(lines) = &mut self.lines
            && lines.lock() != Lock::Locked
            && lines
                .spindle_hz()
                .is_none_or(|(there, _)| (there - speed).abs() > accuracy)
        {
            lines.start(speed, sd.max(accuracy));
        }
    }

    /// The loudest of the lines that are removed, the places of flip chatter apart.
    fn remember_loudest(&mut self, speed: T) {
        let rotation = self.rotation();
        let sure = self.removed().filter(|(n, _)| !rotation.may_flip(*n));
        let loudest = sure.reduce(|a, b| if b.1 > a.1 { b } else { a });
        self.moving = Moving {
            loudest: loudest.map_or(0, |(multiple, _)| multiple),
            speed_hz: speed,
            age_s: T::ZERO,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: Moving<f64> = Moving {
        loudest: 4,
        speed_hz: 100.0,
        age_s: 0.0,
    };

    /// Frequency and its deviation, amplitude, share.
    fn poles(of: &[[f64; 4]]) -> Vec<Pole<f64>> {
        let pole = |&[hz, sd_hz, amplitude, share]: &[f64; 4]| Pole {
            hz,
            sd_hz,
            damping: 0.001,
            amplitude,
            share,
        };
        of.iter().map(pole).collect()
    }

    fn told(of: &[[f64; 4]]) -> Option<(f64, f64, bool)> {
        KNOWN.read_off(poles(of).into_iter())
    }

    #[test]
    fn two_lines_tell_the_speed_that_has_moved() {
        let (speed, sd, two) =
            told(&[[303.0, 0.2, 0.1, 0.1], [404.0, 0.1, 1.0, 0.6]]).expect("a speed");
        assert!(two && (speed - 101.0).abs() < 1e-9, "{speed}");
        assert!((0.01..0.05).contains(&sd), "{sd}");
        // The pole of the weaker line is late: the louder one counts more.
        let (speed, sd, _) =
            told(&[[302.5, 0.3, 0.1, 0.1], [404.0, 0.1, 1.0, 0.6]]).expect("a speed");
        assert!((100.95..101.0).contains(&speed), "{speed}");
        assert!((0.05..0.1).contains(&sd), "{sd}");
    }

    #[test]
    fn a_line_among_others_tells_nothing() {
        assert_eq!(told(&[[404.0, 0.1, 1.0, 0.6]]), None);
        // A chatter beside the line, whose own lines stay.
        let beside = [[404.0, 0.1, 1.0, 0.6], [300.0, 0.1, 0.1, 0.1]];
        assert_eq!(told(&beside), None);
        // A chatter with sidebands a turn apart: all by the same, not by the same part.
        let sidebands = [[404.0, 0.05, 1.0, 0.6], [304.0, 0.05, 0.1, 0.1]];
        assert_eq!(told(&sidebands), None);
        // Further than it can have moved.
        assert_eq!(
            told(&[[309.0, 0.1, 0.1, 0.1], [412.0, 0.1, 1.0, 0.9]]),
            None
        );
        assert_eq!(told(&[]), None);
    }

    #[test]
    fn one_line_that_is_nearly_all_there_is_tells_it_alone() {
        let alone = told(&[[404.0, 0.4, 1.0, 0.95], [350.0, 0.4, 0.01, 0.01]]);
        assert_eq!(alone, Some((101.0, 0.1, false)));
        let high = Moving {
            loudest: 9,
            ..KNOWN
        };
        let line = poles(&[[909.0, 0.4, 1.0, 0.95]]);
        assert_eq!(high.read_off(line.into_iter()), None, "too high a multiple");
    }

    #[test]
    fn a_line_at_the_setting_is_where_it_starts() {
        let rest = |of: &[[f64; 4]]| Moving::at_rest(100.0, poles(of).into_iter());
        let found = rest(&[[400.3, 0.1, 1.0, 0.95]]).expect("a line");
        assert_eq!((found.loudest, found.speed_hz), (4, 400.3 / 4.0));
        assert!(rest(&[[404.0, 0.1, 1.0, 0.95]]).is_none(), "1 % off");
        assert!(rest(&[[400.3, 0.1, 1.0, 0.5]]).is_none(), "half of it");
        assert!(rest(&[[900.0, 0.1, 1.0, 0.95]]).is_none(), "too high");
        assert!(rest(&[[40.0, 0.1, 1.0, 0.95]]).is_none(), "below the first");
    }

    #[test]
    fn where_any_pole_would_agree_none_is_asked() {
        // 20 spacings up, and as far off as half of one.
        let vague = [[404.0, 1.0, 1.0, 0.6], [2040.0, 10.0, 0.1, 0.1]];
        assert_eq!(told(&vague), None);
        let bad = [[404.0, f64::NAN, 1.0, 0.6], [303.0, 0.1, 0.1, 0.1]];
        assert_eq!(told(&bad), None);
        let line = poles(&[[303.0, 0.1, 0.1, 0.95]]);
        assert_eq!(Moving::default().read_off(line.into_iter()), None);
    }
}
