//! Recursive ARMA: a new model at every sample.
//!
//! Rate: once a (decimated) sample, in fixed time. See [`RecursiveArma`].

use super::config::{Gradient, RarmaConfig};
use super::schur;
use super::ud::UdFactors;
use crate::real::Real;

/// Gain on σ² when the gradient takes over: the start-up's large errors fade.
const RESTART_VARIANCE_GAIN: f64 = 0.05;
/// Least innovation variance, so that silence divides by a normal number.
const SMALLEST_VARIANCE: f64 = 1e-30;

/// What the estimator is doing, returned with every update.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Start-up: pseudo-linear regression, the model is not to be used yet.
    Starting,
    /// Running freely.
    Running,
    /// Running, but something is being held back; see the limit.
    Limiting(Limit),
    /// The sample was not finite and has been left out; nothing changed.
    Rejected,
}

/// What is being held back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The step would have made C(q) unstable; the noise part was shortened or kept.
    NoiseModel,
    /// A covariance factor stands at its ceiling: too little excitation.
    Covariance,
    /// The sample was far outside the innovations' spread and weighs less.
    Outlier,
}

/// Result of one update.
#[derive(Debug, Clone, Copy)]
pub struct Step<T> {
    /// One-step prediction error (innovation) e(t) = y(t) − φᵀθ(t−1), input units.
    pub innovation: T,
    /// What the estimator is doing.
    pub status: Status,
}

/// Recursive prediction-error estimator of an ARMA(p, q) model.
///
/// Model: A(q)·y(t) = C(q)·e(t) with A = 1 + Σ aᵢ q⁻ⁱ and C = 1 + Σ cᵢ q⁻ⁱ, both
/// with **plus** signs (eqs. 46 and 70 of the thesis; its eq. 35 has the opposite
/// sign). A textbook AR in the form y = Σ φᵢ y(t−i) has aᵢ = −φᵢ; moving-average
/// coefficients keep their sign.
///
/// Recurrence, with θ = (a, c), φ = (−y(t−1)…, ε(t−1)…), and σ² the running
/// innovation variance:
///
/// ```text
/// e   = y − φᵀθ                       one-step prediction error
/// ψ   = φ filtered by 1/C(q)          gradient (RPEM), or φ itself (RPLR)
/// α   = λσ² + ψᵀPψ,  K = Pψ/α
/// θ  ← θ + K·e                        shortened if C would leave |z| < radius
/// P  ← (P − Pψψᵀ P/α)/λ + R_e         U·D·Uᵀ factors; R_e the random walk
/// ε   = y − φᵀθ                       residual, enters the next φ
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
pub struct RecursiveArma<T, const P: usize, const Q: usize, const N: usize> {
    config: RarmaConfig<T>,
    /// Forgetting factor of this sample: rises to the set one after each start.
    lambda: T,
    inverse_lambda: T,
    /// θ = (a₁…a_p, c₁…c_q)
    theta: [T; N],
    /// φ = (−y(t−1)…−y(t−p), ε(t−1)…ε(t−q))
    phi: [T; N],
    /// ψ = φ filtered by 1/C
    psi: [T; N],
    /// Filtered outputs older than ψ holds them; used only where q > p.
    older: [T; N],
    covariance: UdFactors<T, N>,
    sigma2: T,
    /// Gain of the next innovation on σ².
    variance_gain: T,
    /// Mean square of the input over a long memory: sets the dynamic range.
    power: T,
    /// Σ of the weights and Σ of the squared weights of the samples in memory.
    weight: T,
    weight2: T,
    count: u32,
    /// Factor whose turn it is to be held in range and, with a random walk, spread.
    turn: usize,
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

    /// Storage without the check of N, for a run-time order below the capacity.
    pub(super) fn raw(config: RarmaConfig<T>) -> Self {
        let config = config.checked().unwrap_or_default();
        Self {
            lambda: config.forgetting.min(config.start_forgetting),
            inverse_lambda: T::ONE / config.forgetting.min(config.start_forgetting),
            theta: [T::ZERO; N],
            phi: [T::ZERO; N],
            psi: [T::ZERO; N],
            older: [T::ZERO; N],
            covariance: UdFactors::diagonal(config.start_variance),
            sigma2: T::ZERO,
            variance_gain: T::ONE,
            power: T::ZERO,
            weight: T::ZERO,
            weight2: T::ZERO,
            count: 0,
            turn: 0,
            config,
        }
    }

    /// Takes one sample; see the type for the recurrence. A sample that is not
    /// finite is rejected and changes nothing.
    #[inline]
    pub fn update(&mut self, y: T) -> Step<T> {
        self.step(y, P, Q)
    }

    /// The update for orders p ≤ P, q ≤ Q; constants when called from `update`.
    #[inline(always)]
    pub(super) fn step(&mut self, y: T, p: usize, q: usize) -> Step<T> {
        if !y.is_finite() {
            return Step {
                innovation: T::ZERO,
                status: Status::Rejected,
            };
        }
        let n = p + q;
        if self.count < self.config.settle_samples {
            self.observe(y, p, q);
            return Step {
                innovation: y,
                status: Status::Starting,
            };
        }
        let starting = self.count < self.config.startup_samples;
        let filtered = !starting && matches!(self.config.gradient, Gradient::Filtered);
        if filtered && self.count == self.config.startup_samples {
            // Pseudo-linear regression has found the neighbourhood: go on from
            // its θ with the true gradient and a small covariance.
            self.covariance.reset(self.config.restart_variance);
            self.weight = T::ZERO;
            self.weight2 = T::ZERO;
            self.lambda = self.config.forgetting.min(self.config.start_forgetting);
            self.inverse_lambda = T::ONE / self.lambda;
            self.variance_gain = self.variance_gain.max(T::from_f64(RESTART_VARIANCE_GAIN));
        }

        let mut e = y;
        for (f, t) in self.phi[..n].iter().zip(&self.theta[..n]) {
            e -= *f * *t;
        }
        if !e.is_finite() {
            // Cannot happen while C is kept stable and the input is bounded; if
            // the input spans the whole number range, start anew.
            self.reset();
            return Step {
                innovation: T::ZERO,
                status: Status::Rejected,
            };
        }

        // Noise variance for this sample; a wild sample counts with its own size.
        let e2 = e * e;
        self.power += self.config.power_gain * (y * y - self.power);
        let floor = (self.power * self.config.dynamic_range).max(T::from_f64(SMALLEST_VARIANCE));
        // A model that predicts worse than no model at all would otherwise take its
        // own errors for noise and stop learning.
        let variance = self.sigma2.min(self.power).max(floor);
        let bound = self.config.outlier_ratio * variance;
        let outlier = e2 > bound && !starting;
        let r = if outlier {
            e2 / self.config.outlier_ratio
        } else {
            variance
        };

        let regressor = if filtered { &self.psi } else { &self.phi };
        let r_lambda = self.lambda * r;
        let mut gain = [T::ZERO; N];
        let alpha = self.covariance.measure(n, regressor, r_lambda, &mut gain);
        let mut limit = self.correct(p, q, &gain, e);

        let at_ceiling = self.covariance.forget(
            n,
            self.inverse_lambda,
            self.turn,
            self.config.d_floor,
            self.config.d_ceiling,
        );
        if self.config.random_walk > T::ZERO {
            let share = self.config.random_walk * T::from_u32(n as u32);
            self.covariance.spread(self.turn, share);
        }
        self.turn = if self.turn + 1 >= n { 0 } else { self.turn + 1 };
        if limit.is_none() && outlier {
            limit = Some(Limit::Outlier);
        }
        if limit.is_none() && at_ceiling {
            limit = Some(Limit::Covariance);
        }

        self.shift(y, p, q);
        self.track_variance(if outlier { bound } else { e2 } * (r_lambda / alpha));
        self.weight = self.lambda * self.weight + T::ONE;
        self.weight2 = self.lambda * self.lambda * self.weight2 + T::ONE;
        self.age_forgetting();
        self.count = self.count.saturating_add(1);
        Step {
            innovation: e,
            status: match limit {
                _ if starting => Status::Starting,
                Some(limit) => Status::Limiting(limit),
                None => Status::Running,
            },
        }
    }

    /// The first samples only set the scale: σ² is the input power, θ stays 0.
    fn observe(&mut self, y: T, p: usize, q: usize) {
        let seen = T::from_u32(self.count + 1);
        self.power += (y * y - self.power) / seen;
        self.sigma2 = self.power;
        self.shift(y, p, q);
        self.count += 1;
    }

    /// θ ← θ + K·e with C kept inside the radius: the full step, else a quarter of
    /// it, else the noise part stays as it was.
    #[inline(always)]
    fn correct(&mut self, p: usize, q: usize, gain: &[T; N], e: T) -> Option<Limit> {
        let n = p + q;
        let mut next = self.theta;
        for (t, k) in next[..n].iter_mut().zip(&gain[..n]) {
            *t += *k * e;
        }
        let mut limit = None;
        if q > 0 && !schur::inside::<T, N>(&next[p..n], self.config.c_radius) {
            limit = Some(Limit::NoiseModel);
            let quarter = e * T::from_f64(0.25);
            for i in p..n {
                next[i] = self.theta[i] + gain[i] * quarter;
            }
            if !schur::inside::<T, N>(&next[p..n], self.config.c_radius) {
                next[p..n].copy_from_slice(&self.theta[p..n]);
            }
        }
        self.theta = next;
        limit
    }

    /// Residual with the new θ, both 1/C filters, and the shift of φ and ψ.
    #[inline(always)]
    fn shift(&mut self, y: T, p: usize, q: usize) {
        let n = p + q;
        let mut residual = y;
        for (f, t) in self.phi[..n].iter().zip(&self.theta[..n]) {
            residual -= *f * *t;
        }
        // ψ holds −y_f and ε_f, both filtered by 1/C: x_f = x − Σ c_j x_f(t−j).
        // The first stage is autoregressive: no residuals, so c stays 0.
        if self.count < self.config.autoregressive_samples {
            residual = T::ZERO;
        }
        let (mut y_f, mut e_f) = (-y, residual);
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
        for i in (1..q.saturating_sub(p)).rev() {
            self.older[i] = self.older[i - 1];
        }
        if q > p {
            self.older[0] = if p > 0 { self.psi[p - 1] } else { y_f };
        }
        for i in (1..p).rev() {
            self.phi[i] = self.phi[i - 1];
            self.psi[i] = self.psi[i - 1];
        }
        for i in (p + 1..n).rev() {
            self.phi[i] = self.phi[i - 1];
            self.psi[i] = self.psi[i - 1];
        }
        if p > 0 {
            self.phi[0] = -y;
            self.psi[0] = y_f;
        }
        if q > 0 {
            self.phi[p] = residual;
            self.psi[p] = e_f;
        }
    }

    /// The forgetting factor rises to the set one, so that what was learnt from a
    /// poor model at the start is forgotten again: λ ← λ + rate·(λ_set − λ).
    #[inline(always)]
    fn age_forgetting(&mut self) {
        let target = self.config.forgetting;
        if self.lambda == target {
            return;
        }
        self.lambda += self.config.forgetting_rate * (target - self.lambda);
        if (target - self.lambda).abs() < T::from_f64(1e-6) {
            self.lambda = target;
        }
        self.inverse_lambda = T::ONE / self.lambda;
    }

    /// Innovation variance: the plain mean at first, then over its memory.
    #[inline(always)]
    fn track_variance(&mut self, e2: T) {
        self.sigma2 += self.variance_gain * (e2 - self.sigma2);
        self.variance_gain =
            (self.variance_gain / (T::ONE + self.variance_gain)).max(self.config.variance_gain);
    }

    /// Forgets everything but the settings.
    pub fn reset(&mut self) {
        *self = Self::raw(self.config);
    }

    /// Coefficients a₁…a_p of A(q), without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.theta[..P]
    }

    /// Coefficients c₁…c_q of C(q), without the leading 1.
    pub fn c(&self) -> &[T] {
        &self.theta[P..]
    }

    /// θ = (a, c).
    pub fn theta(&self) -> &[T; N] {
        &self.theta
    }

    /// Innovation variance σ², input units squared.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }

    /// Samples taken since the last reset.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The start-up is over.
    pub fn ready(&self) -> bool {
        self.count > self.config.startup_samples
    }

    /// Factor from P to the covariance of θ. With weights λᵏ the estimate's
    /// covariance is P·Σλ²ᵏ/Σλᵏ: 1 without forgetting, 1/(1 + λ) in the long run
    /// with it. A random walk leaves P as it is.
    pub fn covariance_factor(&self) -> T {
        if self.weight > T::ZERO {
            self.weight2 / self.weight
        } else {
            T::ONE
        }
    }

    /// Covariance factors; multiply by [`Self::covariance_factor`].
    pub fn covariance(&self) -> &UdFactors<T, N> {
        &self.covariance
    }
}

#[cfg(test)]
#[path = "rarma_tests.rs"]
mod tests;
