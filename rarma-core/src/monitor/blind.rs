//! Would a chatter be heard? A line of the rotation that rises by itself may be one that
//! hides under it, in the notch of a removed line.
//!
//! Rate: decision rate. Forced lines rise together when a cut deepens; that one of them
//! rises while everything else stays is told as blindness, never as chatter.

use crate::real::Real;

/// Steps of history, and the length of one, s.
const STEPS: usize = 10;
const STEP_S: f64 = 0.05;
/// Steps that are too young to compare with.
const YOUNG: usize = 3;
/// The line has this many times (6 dB) the power it had …
const ROSE: f64 = 4.0;
/// … and everything else no more than this many times (3 dB).
const OTHERS: f64 = 2.0;
/// Least part of the band's power at a line that may hide a chatter.
const LOUD: f64 = 0.25;
/// It is told for this long, s.
const HOLD_S: f64 = 1.0;

/// The loudest line of the rotation over the last half second.
#[derive(Debug, Clone, Default)]
pub(super) struct Blindness<T> {
    /// Power of the line, and of everything else, input units squared.
    history: [Option<(T, T)>; STEPS],
    left_s: T,
    hold_s: T,
}

impl<T: Real> Blindness<T> {
    /// A decision: power of the loudest line that is removed, and of all of the band. `changing` says that the cut or the speed changes, so that a line that
    /// rises says nothing.
    pub(super) fn note(&mut self, line: T, power: T, changing: bool, period_s: T) {
        let rest = (power - line).max(T::ZERO);
        if changing {
            self.history = [None; STEPS];
        } else if line > power * T::from_f64(LOUD) && self.rose(line, rest) {
            self.hold_s = T::from_f64(HOLD_S);
        }
        self.hold_s = (self.hold_s - period_s).max(T::ZERO);
        self.left_s -= period_s;
        if self.left_s <= T::ZERO {
            self.left_s += T::from_f64(STEP_S);
            self.history.rotate_right(1);
            if let Some(newest) = self.history.first_mut() {
                *newest = Some((line, rest)).filter(|_| !changing);
            }
        }
    }

    fn rose(&self, line: T, rest: T) -> bool {
        self.history.iter().skip(YOUNG).flatten().any(|before| {
            before.0 > T::ZERO
                && line > before.0 * T::from_f64(ROSE)
                && rest < before.1 * T::from_f64(OTHERS)
        })
    }

    /// A line rose by itself within the last second.
    pub(super) fn is_blind(&self) -> bool {
        self.hold_s > T::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(parts: &[(f64, f64, f64)]) -> bool {
        let mut blind = Blindness::<f64>::default();
        for (line, rest, seconds) in parts {
            for _ in 0..(seconds / 0.002) as usize {
                blind.note(*line, line + rest, false, 0.002);
            }
        }
        blind.is_blind()
    }

    #[test]
    fn only_a_line_that_rises_by_itself_blinds() {
        assert!(!after(&[(1.0, 1.0, 2.0)]));
        assert!(after(&[(1.0, 1.0, 2.0), (5.0, 1.0, 0.1)]));
        assert!(!after(&[(1.0, 40.0, 2.0), (5.0, 40.0, 0.5)]), "a whisper");
        assert!(!after(&[(1.0, 1.0, 2.0), (3.0, 1.0, 0.5)]), "too little");
        assert!(!after(&[(1.0, 1.0, 2.0), (5.0, 5.0, 0.5)]), "all rose");
        assert!(!after(&[(1.0, 1.0, 2.0), (5.0, 1.0, 2.0)]), "long ago");
        assert!(!after(&[(5.0, 1.0, 2.0)]), "there from the beginning");
        assert!(!after(&[(f64::NAN, 1.0, 1.0), (9.0, f64::NAN, 0.3)]));
        let mut entering = Blindness::<f64>::default();
        for n in 0..1000 {
            entering.note(if n < 900 { 1.0 } else { 9.0 }, 10.0, true, 0.002);
        }
        assert!(!entering.is_blind(), "the cut begins");
    }
}
