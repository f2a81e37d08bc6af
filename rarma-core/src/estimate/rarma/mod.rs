//! Recursive ARMA: a new model at every sample.
//!
//! Rate: once a (decimated) sample, in fixed time. See [`RecursiveArma`].

mod gradient;
mod innovation;
mod readings;
mod restart;
mod start;

use super::config::{Gradient, RarmaConfig};
use super::schur;
use super::status::{Limit, Status, Step};
use crate::real::Real;
use crate::ud::UdFactors;
use innovation::Weighed;
use start::Start;

/// Least innovation variance, so that silence divides by a normal number.
pub(super) const SMALLEST_VARIANCE: f64 = 1e-30;
/// Samples from here on are rejected: their squares would leave the range of `f32`.
const LARGEST_SAMPLE: f64 = 1e15;
/// Growth of the covariance at an outlier.
const OUTLIER_INFLATION: f64 = 1.03;
/// Gain of the recent innovation variance, and how far σ² may be above it. Of
/// 2e7 white normal innovations the recent variance was never below 0.36 of the true one.
const RECENT_GAIN: f64 = 1.0 / 32.0;
const RECENT_RATIO: f64 = 4.0;

/// Recursive prediction-error estimator of an ARMA(p, q) model.
///
/// Model: A(q)·y(t) = C(q)·e(t) with A = 1 + Σ aᵢ q⁻ⁱ and C = 1 + Σ cᵢ q⁻ⁱ, both
/// with **plus** signs (eqs. 46 and 70 of the thesis; its eq. 35 has the opposite
/// sign). A textbook AR in the form y = Σ φᵢ y(t−i) has aᵢ = −φᵢ; moving-average
/// coefficients keep their sign.
///
/// Recurrence, with θ = (a, c), φ = (−y(t−1)…, e(t−1)…), and σ² the running
/// innovation variance:
///
/// ```text
/// e   = y − φᵀθ                       one-step prediction error
/// ψ   = φ filtered by 1/C(q)          gradient (RPEM), or φ itself (RPLR)
/// α   = λσ² + ψᵀPψ,  K = Pψ/α
/// θ  ← θ + K·e                        shortened if C would leave |z| < radius
/// P  ← (P − Pψψᵀ P/α)/λ + R_e         U·D·Uᵀ factors; R_e the random walk
/// ```
///
/// Because the noise variance σ² stands in α (the thesis' R_s is 1 in its place),
/// P is the covariance of θ itself, whatever the units of the input.
///
/// Generics: `P` and `Q` are the orders, `N` must be P + Q, checked when the code
/// is built:
///
/// ```compile_fail
/// use rarma_core::estimate::{RarmaConfig, RecursiveArma};
/// // 2 + 1 is not 4
/// let model = RecursiveArma::<f32, 2, 1, 4>::new(RarmaConfig::default());
/// ```
///
/// ```
/// use rarma_core::estimate::{Arma21, RarmaConfig};
/// let mut model = Arma21::<f64>::new(RarmaConfig::default());
/// let (mut y1, mut y2, mut seed) = (0.0, 0.0, 1u32);
/// for _ in 0..20_000 {
///     seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     let e = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
///     let y = 1.6 * y1 - 0.95 * y2 + e;   // a = (−1.6, 0.95), c = 0
///     (y2, y1) = (y1, y);
///     model.update(y);
/// }
/// assert!((model.a()[0] + 1.6).abs() < 0.02 && (model.a()[1] - 0.95).abs() < 0.02);
/// ```
#[derive(Debug, Clone)]
// What every sample touches comes first: with the order left to the compiler the same
// code took up to a third more instructions at (8,7).
#[repr(C)]
pub struct RecursiveArma<T, const P: usize, const Q: usize, const N: usize> {
    /// θ = (a₁…a_p, c₁…c_q)
    pub(super) theta: [T; N],
    /// φ = (−y(t−1)…−y(t−p), e(t−1)…e(t−q))
    pub(super) phi: [T; N],
    /// ψ = φ filtered by 1/C (RPEM), or φ again (RPLR)
    pub(super) psi: [T; N],
    /// Filtered outputs older than ψ holds them; used only where q > p.
    pub(super) older: [T; N],
    pub(super) covariance: UdFactors<T, N>,
    pub(super) config: RarmaConfig<T>,
    pub(super) inverse_lambda: T,
    pub(super) inverse_radius: T,
    pub(super) sigma2: T,
    /// Gain of the next innovation on σ².
    pub(super) variance_gain: T,
    /// Innovation variance over the last few tens of samples.
    pub(super) recent: T,
    /// Mean square of the input over a long memory: sets the dynamic range.
    pub(super) power: T,
    /// Samples that the start-up has worked through.
    pub(super) known: u32,
    pub(super) count: u32,
    /// Factor whose turn it is to be held in range and, with a random walk, spread.
    pub(super) turn: usize,
    /// Factors that stood at the ceiling in this round of turns.
    pub(super) at_ceiling: usize,
    pub(super) start: Start<T, N>,
}

/// ARMA(2,1): one mode.
pub type Arma21<T> = RecursiveArma<T, 2, 1, 3>;
/// ARMA(4,3): two modes.
pub type Arma43<T> = RecursiveArma<T, 4, 3, 7>;
/// ARMA(6,5): three modes.
pub type Arma65<T> = RecursiveArma<T, 6, 5, 11>;
/// ARMA(8,7): four modes.
pub type Arma87<T> = RecursiveArma<T, 8, 7, 15>;
/// ARMA(2,2): one mode in white measurement noise.
pub type Arma22<T> = RecursiveArma<T, 2, 2, 4>;
/// ARMA(4,4): two modes in white measurement noise.
pub type Arma44<T> = RecursiveArma<T, 4, 4, 8>;
/// ARMA(6,6): three modes in white measurement noise.
pub type Arma66<T> = RecursiveArma<T, 6, 6, 12>;
/// ARMA(8,8): four modes in white measurement noise.
pub type Arma88<T> = RecursiveArma<T, 8, 8, 16>;

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// A model that has seen nothing. Settings out of range are replaced as a whole
    /// by the defaults; [`RarmaConfig::checked`] names the field beforehand.
    pub fn new(config: RarmaConfig<T>) -> Self {
        const { assert!(N == P + Q, "N must be P + Q") };
        const { assert!(N > 0, "an ARMA(0,0) model has nothing to estimate") };
        Self::raw(config)
    }

    /// Takes one sample; see the type for the recurrence. A sample that is not
    /// finite, or 1e15 and more, is rejected and changes nothing.
    #[inline]
    pub fn update(&mut self, y: T) -> Step<T> {
        self.step(y, P, Q)
    }

    /// The update for orders p ≤ P, q ≤ Q; constants when called from `update`.
    #[inline(always)]
    pub(super) fn step(&mut self, y: T, p: usize, q: usize) -> Step<T> {
        // False for NaN as well.
        if !(y.abs() < T::from_f64(LARGEST_SAMPLE)) {
            return Step {
                innovation: T::ZERO,
                status: Status::Rejected,
            };
        }
        self.count = self.count.saturating_add(1);
        if self.start.is_over() {
            self.advance(y, p, q)
        } else {
            self.start_up(y, p, q)
        }
    }

    /// One step of the recurrence.
    #[inline(always)]
    pub(super) fn advance(&mut self, y: T, p: usize, q: usize) -> Step<T> {
        let n = p + q;
        let e = self.predict(y, p, q);
        if !e.is_finite() {
            return self.reject();
        }

        // Noise variance for this sample; a wild sample counts with its own size.
        let Weighed {
            e2,
            variance,
            bound,
            outlier,
        } = self.weigh(y, e);
        let r = if outlier {
            e2 / self.config.outlier_ratio
        } else {
            variance
        };

        let r_lambda = self.config.forgetting * r;
        // What was learnt at a far lower level was learnt with too small a variance:
        // each outlier takes some of that confidence back.
        let growth = if outlier {
            self.inverse_lambda * T::from_f64(OUTLIER_INFLATION)
        } else {
            self.inverse_lambda
        };
        let mut gain = [T::ZERO; N];
        let inverse = self
            .covariance
            .measure(n, &self.psi, r_lambda, growth, &mut gain);
        let full_step = self.correct(p, q, &gain, e * inverse);

        if self.turn >= n {
            self.turn = 0;
            if self.at_ceiling >= n {
                // Every factor has wound up: nothing is remembered, so begin anew.
                self.reset();
                return Step {
                    innovation: e,
                    status: Status::Starting,
                };
            }
            self.at_ceiling = 0;
        }
        let turn = self.turn;
        self.turn += 1;
        let (floor, ceiling) = (self.config.d_floor, self.config.d_ceiling);
        let at_ceiling = self.covariance.hold(turn, floor, ceiling);
        if at_ceiling {
            self.at_ceiling += 1;
        }
        if self.config.random_walk > T::ZERO {
            let share = self.config.random_walk * T::from_u32(n as u32);
            self.covariance.spread(turn, share);
        }
        let filtered = matches!(self.config.gradient, Gradient::Filtered);
        let _ = self.filter(y, e, p, q, filtered);
        self.track_variance(if outlier { bound } else { e2 } * (r_lambda * inverse));
        let status = if !full_step {
            Status::Limiting(Limit::NoiseModel)
        } else if outlier {
            Status::Limiting(Limit::Outlier)
        } else if at_ceiling {
            Status::Limiting(Limit::Covariance)
        } else {
            Status::Running
        };
        Step {
            innovation: e,
            status,
        }
    }

    /// e = y − φᵀθ, and the shift of φ by this sample.
    #[inline(always)]
    pub(super) fn predict(&mut self, y: T, p: usize, q: usize) -> T {
        let mut e = y;
        let mut newer = -y;
        for i in 0..p {
            let f = self.phi[i];
            e -= f * self.theta[i];
            self.phi[i] = newer;
            newer = f;
        }
        newer = T::ZERO;
        for i in p..p + q {
            let f = self.phi[i];
            e -= f * self.theta[i];
            self.phi[i] = newer;
            newer = f;
        }
        if q > 0 {
            self.phi[p] = e;
        }
        e
    }

    /// θ ← θ + Pψ·`step` with C kept inside the radius: the full step (returns true),
    /// else a quarter of it, else the noise part stays as it was.
    #[inline(always)]
    pub(super) fn correct(&mut self, p: usize, q: usize, gain: &[T; N], step: T) -> bool {
        let n = p + q;
        let before = self.theta;
        for j in p..n {
            self.theta[j] += gain[j] * step;
        }
        let full = schur::inside_inverse::<T, N>(&self.theta[p..n], self.inverse_radius);
        let mut taken = step;
        if !full {
            taken = step * T::from_f64(0.25);
            for j in p..n {
                self.theta[j] = before[j] + gain[j] * taken;
            }
            if !schur::inside_inverse::<T, N>(&self.theta[p..n], self.inverse_radius) {
                self.theta[p..n].copy_from_slice(&before[p..n]);
            }
        }
        for (t, k) in self.theta[..p].iter_mut().zip(gain) {
            *t += *k * taken;
        }
        full
    }

    /// Both 1/C filters, and the shift of ψ by one sample. Returns the newest filtered
    /// pair (−y_f, e_f): x_f = x − Σ c_j x_f(t−j), or x itself if not `filtered`.
    #[inline(always)]
    pub(super) fn filter(&mut self, y: T, e: T, p: usize, q: usize, filtered: bool) -> (T, T) {
        let n = p + q;
        let (mut y_f, mut e_f) = (-y, e);
        if filtered {
            for j in 0..q {
                let c = self.theta[p + j];
                let past = if j < p {
                    self.psi[j]
                } else {
                    self.older[j - p]
                };
                y_f -= c * past;
                e_f -= c * self.psi[p + j];
            }
        }
        for i in (1..q.saturating_sub(p)).rev() {
            self.older[i] = self.older[i - 1];
        }
        if q > p {
            self.older[0] = if p > 0 { self.psi[p - 1] } else { y_f };
        }
        for i in (1..p).rev() {
            self.psi[i] = self.psi[i - 1];
        }
        for i in (p + 1..n).rev() {
            self.psi[i] = self.psi[i - 1];
        }
        if p > 0 {
            self.psi[0] = y_f;
        }
        if q > 0 {
            self.psi[p] = e_f;
        }
        (y_f, e_f)
    }

    /// Innovation variance: the plain mean at first, then over its memory, but after
    /// a loud passage no more than a few times that of the last samples: what follows
    /// would otherwise count for nothing until the passage is forgotten.
    #[inline(always)]
    pub(super) fn track_variance(&mut self, e2: T) {
        self.recent += (e2 - self.recent) * T::from_f64(RECENT_GAIN);
        self.sigma2 += self.variance_gain * (e2 - self.sigma2);
        self.sigma2 = self.sigma2.min(self.recent * T::from_f64(RECENT_RATIO));
        if self.variance_gain > self.config.variance_gain {
            self.variance_gain =
                (self.variance_gain / (T::ONE + self.variance_gain)).max(self.config.variance_gain);
        }
    }
}

#[cfg(test)]
#[path = "rarma_tests.rs"]
mod tests;
