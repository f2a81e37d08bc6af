//! By how much a speed has moved lately: what follows it is late by as much.
//!
//! Rate: decision rate.

use crate::real::Real;
use crate::visit::state;

/// Steps of history, and the length of one, s: after an entry a spindle recovers by 1 %
/// in 0.3 s.
const STEPS: usize = 6;
const STEP_S: f64 = 0.05;

/// The speed over the last 0.3 s.
#[derive(Debug, Clone, Default)]
pub(super) struct Drift<T> {
    history: [Option<T>; STEPS],
    left_s: T,
}

state! { Drift<T> { history, left_s } }

impl<T: Real> Drift<T> {
    /// Time passes; `speed` is the one in use, Hz.
    pub(super) fn note(&mut self, speed: Option<T>, period_s: T) {
        self.left_s -= period_s;
        if self.left_s > T::ZERO {
            return;
        }
        self.left_s += T::from_f64(STEP_S);
        self.history.rotate_right(1);
        if let Some(newest) = self.history.first_mut() {
            *newest = speed;
        }
    }

    /// Widest distance of `speed` from what it was, as a part of it.
    pub(super) fn of(&self, speed: T) -> T {
        let apart = |before: &T| (*before - speed).abs() / speed;
        let history = self.history.iter().flatten();
        history.map(apart).fold(T::ZERO, |most, d| most.max(d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_that_moved_is_in_doubt_by_as_much_for_a_while() {
        let mut drift = Drift::<f64>::default();
        assert_eq!(drift.of(76.0), 0.0, "nothing is known");
        for _ in 0..500 {
            drift.note(Some(76.0), 0.002);
        }
        assert_eq!(drift.of(76.0), 0.0);
        for _ in 0..50 {
            drift.note(Some(75.24), 0.002);
        }
        assert!((drift.of(75.24) - 0.0101).abs() < 1e-4);
        for _ in 0..150 {
            drift.note(Some(75.24), 0.002);
        }
        assert_eq!(drift.of(75.24), 0.0, "0.3 s later");
        for _ in 0..500 {
            drift.note(None, 0.002);
        }
        assert_eq!(
            drift.of(75.0),
            0.0,
            "a speed that nobody says does not move"
        );
    }
}
