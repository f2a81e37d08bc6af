//! Has this mode lost its damping? A sequential test on the innovations.
//!
//! Rate: `process` once a decimated sample, `steer` at the decision rate.

use crate::real::Real;
use crate::visit::state;

/// Cumulated log likelihood ratios of one mode: undamped against damped.
///
/// The mode's own part of the signal is x = A(q)/(q_k(q)·C(q))·y, what is left when the
/// model takes everything away but the pole pair q_k. If the mode has the damping ratio
/// ζ, then e_ζ(t) = x(t) − u·x(t−1) + v·x(t−2) is white, with u = 2r·cos θ, v = r²,
/// r = e^(−ζω). Two hypotheses about ζ differ by (e₀² − e₁²)/2σ² a sample, whatever the
/// mode's loudness, and a cumulated sum (Page's test) that falls below zero starts anew:
///
/// ```text
/// g ← max(0, g + (e₀² − e₁²)/2σ²),   σ² ← mean of min(e₀², e₁²)
/// ```
///
/// Three of them run: undamped against [`DAMPED_RATIO`] thresholds, undamped against
/// the mode's usual damping, and the first one backwards, for the way back. In the
/// limit no test calls sooner at the same rate of false calls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SequentialTest<T> {
    x: [T; 2],
    undamped: Pair<T>,
    damped: Pair<T>,
    usual: Pair<T>,
    variance: T,
    lost: T,
    lost_from_usual: T,
    regained: T,
    usual_again: T,
}

state! { SequentialTest<T> {
    x, undamped, damped, usual, variance, lost, lost_from_usual, regained, usual_again
} }

/// What the test of one mode says at a decision, in nats.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evidence<T> {
    /// Undamped, rather than damped by [`DAMPED_RATIO`] thresholds.
    pub lost: T,
    /// Undamped, rather than damped as it usually is.
    pub lost_from_usual: T,
    /// Damped by [`DAMPED_RATIO`] thresholds, rather than undamped.
    pub regained: T,
    /// Damped as it usually is, rather than undamped.
    pub usual_again: T,
}

/// Evidence of a lost damping that is enough, nats, against each of the two damped
/// hypotheses. Calls in minutes of a mode of ζ = 2 and 5 %: table in the book's bench page.
const ENOUGH: (f64, f64) = (8.0, 18.0);
/// Evidence of regained damping that is enough, nats; and of the usual damping, where
/// the vibration has gone as well.
const ENOUGH_BACK: (f64, f64) = (12.0, 7.0);

impl<T: Real> Evidence<T> {
    /// How near the call is: 1 and more is enough.
    pub fn of_call(&self) -> T {
        let by_damped = self.lost / T::from_f64(ENOUGH.0);
        by_damped.min(self.lost_from_usual / T::from_f64(ENOUGH.1))
    }

    /// The damping is back; `gone` says that the vibration is, too.
    pub fn is_back(&self, gone: bool) -> bool {
        let usual = gone && self.usual_again >= T::from_f64(ENOUGH_BACK.1);
        usual || self.regained >= T::from_f64(ENOUGH_BACK.0)
    }
}

/// u and v of a pole pair.
#[derive(Debug, Clone, Copy)]
struct Pair<T> {
    u: T,
    v: T,
}

state! { Pair<T> { u, v } }

impl<T: Real> Pair<T> {
    fn new(angle: T, cosine: T, damping: T) -> Self {
        let r = (-damping * angle).exp();
        Self {
            u: T::from_f64(2.0) * r * cosine,
            v: r * r,
        }
    }

    #[inline(always)]
    fn innovation2(&self, x: T, past: &[T; 2]) -> T {
        let e = x - self.u * past[0] + self.v * past[1];
        e * e
    }
}

/// Damping of the damped hypothesis, in thresholds; that of the undamped one is
/// a fifth of the threshold. Halfway between, at the threshold, the sums neither rise nor fall.
pub const DAMPED_RATIO: f64 = 2.0;
/// Damping of the undamped hypothesis, in thresholds.
const UNDAMPED_RATIO: f64 = 0.2;
/// Highest usual damping that is tested against, in thresholds.
pub(crate) const USUAL_RATIO: f64 = 5.0;
/// Lowest one, in thresholds.
const LEAST_USUAL_RATIO: f64 = 0.4;
/// Memory of σ², s.
const VARIANCE_TAU_S: f64 = 0.03;
/// Most that one sample counts: a shock is no evidence about damping.
const MOST_A_SAMPLE: f64 = 3.0;
/// The sums stop at this multiple of what is enough, so that they come down again.
const MOST: f64 = 1.5;

impl<T: Real> Default for SequentialTest<T> {
    fn default() -> Self {
        let none = Pair {
            u: T::ZERO,
            v: T::ZERO,
        };
        Self {
            x: [T::ZERO; 2],
            undamped: none,
            damped: none,
            usual: none,
            variance: T::ZERO,
            lost: T::ZERO,
            lost_from_usual: T::ZERO,
            regained: T::ZERO,
            usual_again: T::ZERO,
        }
    }
}

impl<T: Real> SequentialTest<T> {
    /// Sets the hypotheses: frequency as an angle per sample, rad; the threshold; the
    /// mode's usual damping ratio.
    pub fn steer(&mut self, angle: T, threshold: T, usual: T) {
        let (_, cosine) = angle.sin_cos();
        let at = |ratio: f64| Pair::new(angle, cosine, threshold * T::from_f64(ratio));
        self.undamped = at(UNDAMPED_RATIO);
        self.damped = at(DAMPED_RATIO);
        let usual = usual
            .max(threshold * T::from_f64(LEAST_USUAL_RATIO))
            .min(threshold * T::from_f64(USUAL_RATIO));
        self.usual = Pair::new(angle, cosine, usual);
    }

    /// Takes the mode's part of the signal; see [`Self::variance_gain`].
    #[inline(always)]
    pub fn process(&mut self, x: T, variance_gain: T) {
        let e1 = self.undamped.innovation2(x, &self.x);
        let e0 = self.damped.innovation2(x, &self.x);
        let e2 = self.usual.innovation2(x, &self.x);
        self.x = [x, self.x[0]];
        let half = T::from_f64(0.5) / self.variance.max(T::from_f64(1e-30));
        let most = T::from_f64(MOST_A_SAMPLE);
        let step = ((e0 - e1) * half).clamp(-most, most);
        let usual = ((e2 - e1) * half).clamp(-most, most);
        let hold = |g: T, enough: f64| g.clamp(T::ZERO, T::from_f64(MOST * enough));
        self.lost = hold(self.lost + step, ENOUGH.0);
        self.lost_from_usual = hold(self.lost_from_usual + usual, ENOUGH.1);
        self.regained = hold(self.regained - step, ENOUGH_BACK.0);
        self.usual_again = hold(self.usual_again - usual, ENOUGH_BACK.1);
        self.variance += variance_gain * (e0.min(e1) - self.variance);
    }

    /// Gain of σ² for rate `fs`, Hz.
    pub fn variance_gain(fs: f64) -> T {
        T::from_f64((1.0 / (VARIANCE_TAU_S * fs)).min(1.0))
    }

    /// The sums as they stand.
    pub fn evidence(&self) -> Evidence<T> {
        Evidence {
            lost: self.lost,
            lost_from_usual: self.lost_from_usual,
            regained: self.regained,
            usual_again: self.usual_again,
        }
    }

    /// What has been gathered counts no longer; the mode is the same.
    pub fn forget(&mut self) {
        self.lost = T::ZERO;
        self.lost_from_usual = T::ZERO;
        self.regained = T::ZERO;
        self.usual_again = T::ZERO;
    }

    /// Something else explains the vibration: that it is undamped proves nothing.
    pub fn discount(&mut self) {
        self.lost = T::ZERO;
        self.lost_from_usual = T::ZERO;
    }

    /// Begins anew, as for another mode.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}
