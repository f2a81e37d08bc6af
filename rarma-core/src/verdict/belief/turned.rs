//! A rotation that may have been turned: what is believed of each speed holds for the speed it would be now, too.

use super::{Belief, SPEEDS, STEP};
use crate::real::Real;

/// The speeds are taken about the believed one once it is so far off the told one.
const FAR: f64 = 0.1;

impl<T: Real> Belief<T> {
    /// Either the rotation has been turned, by e^r, or it has stayed and a line of it moves by itself: both are believed
    /// in as much, until the lines have told.
    pub(in crate::verdict) fn may_have_turned(&mut self, r: T) {
        self.shift(-r * T::from_f64(1.0 / STEP), T::max);
        self.go_along();
        self.turned = self.mean + r;
    }

    /// The speeds go with the believed one, once it is far off the told one.
    pub(in crate::verdict) fn go_along(&mut self) {
        if self.mean.abs() < T::from_f64(FAR) {
            return;
        }
        let steps = (self.mean * T::from_f64(1.0 / STEP)).round();
        self.shift(steps, |_, heard| heard);
        let by = steps * T::from_f64(STEP);
        self.told_hz *= by.exp();
        self.mean -= by;
    }

    /// Takes for each speed what is heard so many steps further on, where there is such a one; between two steps on the
    /// straight line between them, for many small turns would add up to an error.
    pub(super) fn shift(&mut self, steps: T, take: impl Fn(T, T) -> T) {
        let whole = (steps.abs().to_f32() as usize).min(SPEEDS);
        let part = steps.abs() - T::from_u32(whole as u32);
        for n in 0..SPEEDS {
            // None is read after it was written.
            let (i, near, far) = if steps > T::ZERO {
                (n, n + whole, n + whole + 1)
            } else {
                let i = SPEEDS - 1 - n;
                (i, i.wrapping_sub(whole), i.wrapping_sub(whole + 1))
            };
            if let Some(near) = self.heard.get(near).copied() {
                let far = self.heard.get(far).copied().unwrap_or(near);
                self.heard[i] = take(self.heard[i], near + part * (far - near));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::verdict::belief::Desk;
    use crate::verdict::frame::HALF;
    use crate::verdict::{Belief, Listening, VerdictConfig};

    /// A belief of 50 turns a second that has heard three lines of `hz` for a second.
    fn heard(hz: f64) -> (Belief<f64>, [(f64, f64); HALF]) {
        let mut rooms = [(0.0, 0.0); HALF];
        let mut belief = Belief::BLANK;
        let listening = Listening {
            fs_hz: 5000.0,
            spindle_hz: Some(50.0),
            teeth: Some(4),
            folding_hz: None,
        };
        let config = VerdictConfig::default();
        belief.restart(&config, 50.0, &listening, 6.0, &mut Desk(&mut rooms));
        hear(&mut belief, &[hz; 3], 20, &mut rooms);
        (belief, rooms)
    }

    /// The first lines of the teeth, each at a speed of its own.
    fn hear(belief: &mut Belief<f64>, at: &[f64], windows: u32, rooms: &mut [(f64, f64); HALF]) {
        for _ in 0..windows {
            belief.forget(2.0);
            for (k, hz) in (1..).zip(at) {
                belief.hear(f64::from(4 * k) * hz, 0.7, 2.0, &mut Desk(rooms));
            }
            belief.settle(&mut Desk(rooms));
        }
    }

    #[test]
    fn a_rotation_that_has_turned_is_believed_at_once() {
        for part in [0.01_f64, -0.01, 0.04, -0.04] {
            let (mut belief, mut rooms) = heard(50.0);
            let hz = 50.0 * (1.0 + part);
            belief.may_have_turned(part.ln_1p());
            hear(&mut belief, &[hz; 3], 3, &mut rooms);
            let off = belief.turn_hz() / hz - 1.0;
            assert!(off.abs() < 0.003, "{part}: {off}");
        }
    }

    #[test]
    fn one_line_that_moves_does_not_turn_it() {
        for part in [0.02_f64, -0.02, 0.04] {
            let (mut belief, mut rooms) = heard(50.0);
            belief.may_have_turned(part.ln_1p());
            let moved = 50.0 * (1.0 + part);
            hear(&mut belief, &[50.0, 50.0, moved], 10, &mut rooms);
            let off = belief.turn_hz() / 50.0 - 1.0;
            assert!(off.abs() < 0.003, "{part}: {off}");
        }
    }

    #[test]
    fn the_speeds_go_with_one_that_is_turned_far() {
        let (mut belief, mut rooms) = heard(50.0);
        let mut hz = 50.0;
        for _ in 0..40 {
            belief.may_have_turned(0.01);
            hz *= 0.01_f64.exp();
            hear(&mut belief, &[hz; 3], 2, &mut rooms);
        }
        let off = belief.turn_hz() / hz - 1.0;
        assert!(off.abs() < 0.003, "{off}");
        assert!(!belief.reaches(50.0) && belief.reaches(hz));
    }
}
