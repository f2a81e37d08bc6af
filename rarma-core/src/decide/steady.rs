//! Does the amplitude of a mode stay? Noise on a damped mode lets it fluctuate, a limit
//! cycle keeps it.
//!
//! Rate: decision rate. The short form of the amplitude statistic ([`Fpk`](super::Fpk)),
//! for every mode at once: it takes part in the decision of each.

use crate::real::Real;
use crate::visit::state;

/// Memory, s, and for how long a mode must have been heard, s.
const TAU_S: f64 = 0.25;
const LEAST_S: f64 = 0.3;
/// Below this scintillation an amplitude stays. Heard: 0.01 to 0.05 for limit cycles of
/// virtual cuts, 0.03 and 0.1 to 0.4 for the chatter of two machines, 0.6 and more for
/// stable modes of ζ = 0.3 %.
const STEADY: f64 = 0.25;

/// Scintillation S = Var V/E²V of the squared amplitude V over the last quarter second: 1
/// for noise on a damped mode, 0 for a steady tone.
///
/// ```text
/// m ← m + γ·(V − m),  m₂ ← m₂ + γ·(V² − m₂),  S = m₂/m² − 1,  γ = period/min(time heard, τ)
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Steadiness<T> {
    mean: T,
    /// E V²/E²V.
    square: T,
    heard_s: T,
}

state! { Steadiness<T> { mean, square, heard_s } }

impl<T: Real> Steadiness<T> {
    /// Takes the squared amplitude at a decision; one that is no number is left out.
    pub fn note(&mut self, squared: T, period_s: T) {
        if !(squared.is_finite() && squared >= T::ZERO) {
            return;
        }
        self.heard_s = (self.heard_s + period_s).min(T::ONE);
        let gain = period_s / self.heard_s.min(T::from_f64(TAU_S));
        let before = self.mean;
        self.mean += gain * (squared - self.mean);
        if self.mean > T::ZERO {
            let (old, new) = (before / self.mean, squared / self.mean);
            self.square = (T::ONE - gain) * self.square * old * old + gain * new * new;
        }
    }

    /// Mean of the squared amplitude over the last quarter second.
    pub fn mean(&self) -> T {
        self.mean
    }

    /// The amplitude stays as it is.
    pub fn is_steady(&self) -> bool {
        self.heard_s >= T::from_f64(LEAST_S) && self.square - T::ONE < T::from_f64(STEADY)
    }

    /// Begins anew.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn heard(seconds: f64, v: impl Fn(f64) -> f64) -> Steadiness<f64> {
        let mut steady = Steadiness::default();
        for n in 0..(seconds / PERIOD_S) as usize {
            steady.note(v(n as f64 * PERIOD_S), PERIOD_S);
        }
        steady
    }

    #[test]
    fn what_stays_is_steady_and_what_fluctuates_is_not() {
        assert!(heard(0.5, |_| 3.0).is_steady());
        assert!(heard(0.5, |_| 3e-18).is_steady(), "however quiet");
        assert!(!heard(0.2, |_| 3.0).is_steady(), "too short");
        // ± 50 % of the power, 10 times a second: S = 0.125.
        assert!(heard(2.0, |t| 1.0 + 0.5 * (62.8 * t).sin()).is_steady());
        // A beat to nothing: S = 0.5.
        assert!(!heard(2.0, |t| 1.0 + (62.8 * t).sin()).is_steady());
        // Growth by a factor of e in 60 ms.
        assert!(!heard(0.5, |t| (t / 0.06).exp()).is_steady());
        assert!(!heard(0.5, |_| f64::NAN).is_steady());
        let mut again = heard(0.5, |_| 3.0);
        again.reset();
        assert!(!again.is_steady());
    }
}
