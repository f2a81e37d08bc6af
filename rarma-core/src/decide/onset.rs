//! Did a line rise by itself? What tells self-excitation where the speed is unknown.
//!
//! Rate: decision rate. When a tool enters, everything rises: the contact is heard in
//! all of the band, and forced lines come with it. A self-excited vibration grows out of
//! a cut that goes on as before.

use crate::real::Real;
use crate::visit::state;

/// Steps of history, and the length of one, s.
const STEPS: usize = 10;
const STEP_S: f64 = 0.05;
/// The newest steps are not compared with.
const LATE: usize = 3;
/// The line alone has this many times (9 dB) the power that all had together …
const ALONE: f64 = 8.0;
/// … of the mean power it has this many times (12 dB), if it has risen clearly …
const CLEARLY: f64 = 16.0;
/// … and everything else no more than this many times (6 dB).
const OTHERS: f64 = 4.0;

/// Memory of the usual power, s, and by how much (3 dB) a band is louder than usual.
const USUAL_TAU_S: f64 = 2.0;
const LOUDER: f64 = 2.0;
/// Of the power a moment ago (1.2 dB): less is dying away.
const FALLING: f64 = 0.75;

/// The power of what no line explains, over the last half second, and of all of the band.
#[derive(Debug, Clone)]
pub(crate) struct Onset<T> {
    history: [T; STEPS],
    /// All of the band, newest first.
    band: [T; 2],
    filled: usize,
    left_s: T,
    usual: T,
}

state! { Onset<T> {
    history, band, filled, left_s, usual;
    where *filled <= STEPS
} }

impl<T: Real> Default for Onset<T> {
    fn default() -> Self {
        Self {
            history: [T::ZERO; STEPS],
            band: [T::ZERO; 2],
            filled: 0,
            left_s: T::ZERO,
            usual: T::ZERO,
        }
    }
}

impl<T: Real> Onset<T> {
    /// Time passes; `power` is the mean square of the band now, without the lines that are
    /// removed, and `band` with them: lines that have just gone are still subtracted, so
    /// that what is left rises where a cut ends.
    pub fn note(&mut self, power: T, band: T, period_s: T) {
        self.left_s -= period_s;
        if self.left_s > T::ZERO {
            return;
        }
        self.left_s += T::from_f64(STEP_S);
        self.usual = match self.filled {
            0 => power,
            _ => self.usual + (power - self.usual) * T::from_f64(STEP_S / USUAL_TAU_S),
        };
        self.history.rotate_right(1);
        if let Some(newest) = self.history.first_mut() {
            *newest = power;
        }
        self.band = [band, self.band[0]];
        self.filled = (self.filled + 1).min(STEPS);
    }

    /// What is left jumps when the lines go, or come back: it begins anew.
    pub fn begin_anew(&mut self) {
        *self = Self {
            band: self.band,
            ..Self::default()
        };
    }

    /// What is left is louder by 3 dB than it was over the last seconds.
    pub fn is_louder(&self, power: T) -> bool {
        self.filled > 0 && power > self.usual * T::from_f64(LOUDER)
    }

    /// The vibration is dying away: less by 1.2 dB in all of the band than 0.05 to 0.1 s
    /// ago. What rings on at the end of a cut is no chatter.
    pub fn is_falling(&self, band: T) -> bool {
        band < self.band[1] * T::from_f64(FALLING)
    }

    /// The line of power `line` in a band of power `power` has risen by itself within
    /// the last half second: against the powers of 0.15 to 0.5 s ago, each by itself.
    pub fn rose_alone(&self, line: T, power: T) -> bool {
        let rest = (power - line).max(T::ZERO);
        let history = self.history.iter().take(self.filled);
        history.skip(LATE).any(|before| {
            *before > T::ZERO
                && line > *before * T::from_f64(ALONE)
                && rest < *before * T::from_f64(OTHERS)
        })
    }

    /// It has, against the mean of those powers: more than the power of a mode of low
    /// damping does by chance.
    pub fn rose_clearly(&self, line: T, power: T) -> bool {
        let rest = (power - line).max(T::ZERO);
        let history = self.history.iter().take(self.filled).skip(LATE);
        let (sum, count) = history.fold((T::ZERO, T::ZERO), |(sum, count), before| {
            (sum + *before, count + T::ONE)
        });
        sum > T::ZERO
            && line * count > sum * T::from_f64(CLEARLY)
            && rest * count < sum * T::from_f64(OTHERS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(powers: &[(f64, f64)]) -> Onset<f64> {
        let mut onset = Onset::default();
        for (power, seconds) in powers {
            for _ in 0..(seconds / 0.002) as usize {
                onset.note(*power, *power, 0.002);
            }
        }
        onset
    }

    #[test]
    fn a_line_that_grows_in_a_steady_cut_rose_alone() {
        let cut = heard(&[(1.0, 2.0), (30.0, 0.1)]);
        assert!(cut.rose_alone(28.0, 30.0));
        assert!(!cut.rose_alone(5.0, 6.0), "too little");
        assert!(!cut.rose_alone(20.0, 30.0), "the rest has grown with it");
        assert!(cut.rose_clearly(28.0, 30.0) && !cut.rose_clearly(5.0, 6.0));
        // Over a gap in a loud cut, as a mode of low damping has them, it has not.
        let gap = heard(&[(10.0, 2.0), (1.0, 0.1), (10.0, 0.15), (30.0, 0.1)]);
        assert!(gap.rose_alone(28.0, 30.0) && !gap.rose_clearly(28.0, 30.0));
        assert!(cut.is_falling(22.0) && !cut.is_falling(23.0));
        // Half a second later it is no news.
        let late = heard(&[(1.0, 2.0), (30.0, 0.7)]);
        assert!(!late.rose_alone(28.0, 30.0));
        assert!(!Onset::default().rose_alone(28.0, 30.0), "nothing before");
        assert!(!cut.rose_alone(f64::NAN, 30.0));
        assert!(cut.is_louder(30.0) && !late.is_louder(1.0) && !cut.is_louder(f64::NAN));
    }
}
