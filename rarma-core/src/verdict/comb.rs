//! Whether the multiples of the rotation have left their place: the control has changed the
//! speed, and nobody has told.
//!
//! Chatter that begins takes a large share, but the rotation's lines stay where they are. When
//! the speed changes they go, all of them, and the cut goes on. Where they have gone to is asked first ([`super::turning`]);
//! this is for a change of which too few of them tell.

use super::HOP_S;
use crate::real::Real;
use crate::visit::state;

/// The lines have gone where they hold less than this part of the power they held. The cut is as
/// loud as before within this, and its inverse.
const GONE: f64 = 0.4;
/// The same for what the spectrum holds at the multiples of the speed, explained or not.
const EMPTY: f64 = 0.3;
/// What they held is averaged over this time, s.
const MEMORY_S: f64 = 1.0;
/// They must be gone for so many windows: one may be an entry or an exit.
const WINDOWS: u8 = 2;
/// The rotation explains most of the sound where it holds more than this part of the band's power.
const MOST: f64 = 0.5;
/// While the new speed is looked for nothing is called, s.
const SETTLING_S: f64 = 1.0;

/// Power of one window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Powers<T> {
    /// Of the lines that the rotation explains.
    pub(super) explained: T,
    /// At the multiples of the speed, where they can be told apart.
    pub(super) at_multiples: Option<T>,
    /// Of the band.
    pub(super) total: T,
    /// Of the strongest lines, whatever makes them.
    pub(super) lines: T,
}

/// The rotation's lines over time.
#[derive(Debug, Clone)]
pub(super) struct Comb<T> {
    explained: T,
    at_multiples: T,
    total: T,
    lines: T,
    gone: u8,
    settling_s: T,
}

state! { Comb<T> {
    explained, at_multiples, total, lines, gone, settling_s;
    where *gone < WINDOWS
} }

impl<T: Real> Comb<T> {
    /// Of nothing heard.
    pub(super) const BLANK: Self = Self {
        explained: T::ZERO,
        at_multiples: T::ZERO,
        total: T::ZERO,
        lines: T::ZERO,
        gone: 0,
        settling_s: T::ZERO,
    };

    /// The speed is looked for anew.
    pub(super) fn is_settling(&self) -> bool {
        self.settling_s > T::ZERO
    }

    /// The rotation, as believed, explains most of what was heard of late.
    pub(super) fn explains_most(&self) -> bool {
        self.explained > T::from_f64(MOST) * self.total
    }

    /// A band of this power is as loud as it was of late.
    pub(super) fn is_as_loud(&self, total: T) -> bool {
        let gone = T::from_f64(GONE);
        total > gone * self.total && self.total > gone * total
    }

    /// Takes a window; whether the lines have just gone.
    pub(super) fn leaves(&mut self, now: &Powers<T>) -> bool {
        let gone = T::from_f64(GONE);
        if self.is_settling() {
            self.settling_s -= T::from_f64(HOP_S);
            if !self.is_settling() {
                self.explained = now.explained;
                self.at_multiples = now.at_multiples.unwrap_or(T::ZERO);
                self.total = now.total;
                self.lines = now.lines;
            }
            return false;
        }
        let empty = now
            .at_multiples
            .is_some_and(|p| p < T::from_f64(EMPTY) * self.at_multiples);
        // A tool that leaves the cut takes its lines with it, though what is left may be as loud.
        let still_cuts = now.lines > gone * self.lines;
        if empty && still_cuts {
            // What is suspected is not learned: the belief follows later than the spectrum.
            if now.explained < gone * self.explained {
                self.gone += 1;
            }
            if self.gone < WINDOWS {
                return false;
            }
            self.gone = 0;
            self.settling_s = T::from_f64(SETTLING_S);
            return true;
        }
        self.gone = 0;
        let gain = T::from_f64(HOP_S / MEMORY_S);
        self.explained += gain * (now.explained - self.explained);
        self.total += gain * (now.total - self.total);
        self.lines += gain * (now.lines - self.lines);
        if let Some(p) = now.at_multiples {
            self.at_multiples += gain * (p - self.at_multiples);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(comb: &mut Comb<f64>, powers: Powers<f64>) -> bool {
        (0..10).any(|_| comb.leaves(&powers))
    }

    fn cut(explained: f64, at_multiples: f64, lines: f64, total: f64) -> Powers<f64> {
        Powers {
            explained,
            at_multiples: Some(at_multiples),
            total,
            lines,
        }
    }

    fn turned() -> Powers<f64> {
        cut(0.1, 0.1, 1.2, 1.3)
    }

    fn cutting() -> Comb<f64> {
        let mut comb = Comb::BLANK;
        for _ in 0..10 {
            assert!(!heard(&mut comb, cut(1.0, 1.1, 1.2, 1.3)));
        }
        comb
    }

    #[test]
    fn lines_that_go_while_the_cut_goes_on_are_a_change_of_speed() {
        let mut comb = cutting();
        assert!(heard(&mut comb, turned()));
        assert!(comb.is_settling());
    }

    #[test]
    fn chatter_and_an_exit_are_none() {
        // Ten times as loud; the rotation's lines stay, though few of them are seen.
        assert!(!heard(&mut cutting(), cut(0.2, 1.0, 12.0, 13.0)));
        assert!(!heard(&mut cutting(), cut(0.01, 0.01, 0.01, 0.02)));
        // The room is as loud as the cut was, but has no lines.
        assert!(!heard(&mut cutting(), cut(0.01, 0.1, 0.3, 1.3)));
    }

    #[test]
    fn a_speed_is_looked_for_for_a_second() {
        let mut comb = cutting();
        assert!(heard(&mut comb, turned()));
        let windows = (0..100)
            .take_while(|_| {
                comb.leaves(&turned());
                comb.is_settling()
            })
            .count();
        let seconds = windows as f64 * HOP_S;
        assert!((0.5..=1.0).contains(&seconds), "{seconds}");
    }
}
