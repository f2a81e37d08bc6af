//! Recursive instrumental variables: A alone, whatever C is.
//!
//! Rate: once a sample, in fixed time O(p²). See [`RecursiveIv`].

use super::rarma::SMALLEST_VARIANCE;
use super::status::{Limit, Status, Step};
use crate::real::Real;

/// Samples from here on are rejected, as by the recursive ARMA estimator.
const LARGEST_SAMPLE: f64 = 1e15;
/// Least part of λr that the denominator λr + φᵀPζ may be, either sign. P is not
/// symmetric, so the sum passes through 0.
const LEAST_DENOMINATOR: f64 = 0.1;
/// Σ|P_ij| at most, over p² times the start variance.
const LARGEST_GAIN: f64 = 100.0;
/// Input power over that when P began at most. Beyond it single precision has no digit
/// left for λr, and what was learnt in near silence weighs nothing any more.
const LOUDER: f64 = 1e3;
/// Samples besides p + q over which the power is measured before the first step.
const WARM_UP: u32 = 32;

/// Settings of [`RecursiveIv`]; no field has an input unit.
#[derive(Debug, Clone, Copy)]
pub struct IvConfig<T> {
    /// Forgetting factor λ per sample, 0.9..=1, default 1.
    pub forgetting: T,
    /// Diagonal of P before anything is known and after a new beginning, positive,
    /// default 1e4: a coefficient of eight is up to 70.
    pub start_variance: T,
    /// Gain of the input power, 0..=1, default 1e-3. The power only sets the scale of P
    /// when it begins anew.
    pub power_gain: T,
}

impl<T: Real> Default for IvConfig<T> {
    fn default() -> Self {
        Self {
            forgetting: T::ONE,
            start_variance: T::from_f64(1e4),
            power_gain: T::from_f64(1e-3),
        }
    }
}

impl<T: Real> IvConfig<T> {
    fn is_valid(&self) -> bool {
        let within = |x: T, lo: f64, hi: f64| x >= T::from_f64(lo) && x <= T::from_f64(hi);
        within(self.forgetting, 0.9, 1.0)
            && within(self.start_variance, 1e-6, 1e9)
            && within(self.power_gain, 0.0, 1.0)
    }
}

/// Recursive estimator of A in A(q)·y = C(q)·e by instruments, the outputs of q samples
/// before; C is not modelled.
///
/// Model: A = 1 + Σ aᵢ q⁻ⁱ, plus signs, as in
/// [`RecursiveArma`](super::RecursiveArma). C(q)·e(t) holds e(t)…e(t−q) only, and
/// y(t−1−q) and older do not, so that with φ = (−y(t−1)…−y(t−p)):
///
/// ```text
/// ζ   = (−y(t−1−q)…−y(t−p−q))        instruments
/// e   = y − φᵀθ                       equation error: what C makes of the innovations
/// K   = Pζ/(λr + φᵀPζ)
/// θ  ← θ + K·e
/// P  ← (P − K·φᵀP)/λ
/// ```
///
/// r, the input power when P last began, makes P free of units. With q = 0 this is
/// recursive least squares. After n samples without forgetting θ solves
/// Σ ζ·(y − φᵀθ) = 0 up to the start, as `rarma_fit::instrumental_variables` with p lags does for
/// a whole series.
///
/// P is not symmetric, and neither is it definite: nothing but a check keeps it
/// healthy. Where the denominator comes near 0 the sample is left out; where P is too
/// large or no number it begins anew, with θ as it is. Both are reported as
/// [`Limit::Instruments`].
///
/// Source: T. Söderström and P. Stoica, *System Identification*, 1989, section 9.3.
#[derive(Debug, Clone)]
pub struct RecursiveIv<T, const P: usize> {
    config: IvConfig<T>,
    inverse_lambda: T,
    p: usize,
    q: usize,
    theta: [T; P],
    /// −y(t−1)…−y(t−P); the first p are φ.
    past: [T; P],
    /// ζ.
    instruments: [T; P],
    /// P, row by row.
    gain: [[T; P]; P],
    /// r, and λr.
    scale: T,
    noise: T,
    power: T,
    sigma2: T,
    count: u32,
    /// Samples until the first step.
    wait: u32,
}

impl<T: Real, const P: usize> RecursiveIv<T, P> {
    /// An A of order p in 1..=P, with instruments q in 0..=P samples late; none if p, q
    /// or a setting is out of range.
    pub fn new(p: usize, q: usize, config: IvConfig<T>) -> Option<Self> {
        ((1..=P).contains(&p) && q <= P && config.is_valid()).then(|| Self::raw(p, q, config))
    }

    fn raw(p: usize, q: usize, config: IvConfig<T>) -> Self {
        Self {
            inverse_lambda: T::ONE / config.forgetting,
            p,
            q,
            theta: [T::ZERO; P],
            past: [T::ZERO; P],
            instruments: [T::ZERO; P],
            gain: [[T::ZERO; P]; P],
            scale: T::ZERO,
            noise: T::ZERO,
            power: T::ZERO,
            sigma2: T::ZERO,
            count: 0,
            wait: (p + q) as u32 + WARM_UP,
            config,
        }
    }

    /// Takes one sample; see the type. A sample that is not finite, or 1e15 and more, is
    /// rejected and changes nothing.
    pub fn update(&mut self, y: T) -> Step<T> {
        // False for NaN as well.
        if !(y.abs() < T::from_f64(LARGEST_SAMPLE)) {
            return Step {
                innovation: T::ZERO,
                status: Status::Rejected,
            };
        }
        self.count = self.count.saturating_add(1);
        let rate = self.config.power_gain.max(T::ONE / T::from_u32(self.count));
        self.power += rate * (y * y - self.power);
        let step = if self.wait > 0 {
            self.start_up(y)
        } else {
            self.advance(y)
        };
        self.shift(y);
        step
    }

    /// Fills the registers. Silence teaches nothing: P has no scale before a signal.
    fn start_up(&mut self, y: T) -> Step<T> {
        if self.wait > 1 {
            self.wait -= 1;
        } else if self.power > T::from_f64(SMALLEST_VARIANCE) {
            self.wait = 0;
            self.begin();
        }
        Step {
            innovation: y,
            status: Status::Starting,
        }
    }

    /// P as before anything is known, at the present power.
    fn begin(&mut self) {
        self.scale = self.power.max(T::from_f64(SMALLEST_VARIANCE));
        self.noise = self.config.forgetting * self.scale;
        self.gain = [[T::ZERO; P]; P];
        for (i, row) in self.gain.iter_mut().enumerate() {
            row[i] = self.config.start_variance;
        }
    }

    fn advance(&mut self, y: T) -> Step<T> {
        let p = self.p;
        let (phi, zeta) = (&self.past[..p], &self.instruments[..p]);
        let e = y - dot(phi, &self.theta[..p]);
        if !e.is_finite() {
            // The input spans the whole number range, or θ has run away: begin anew.
            *self = Self::raw(self.p, self.q, self.config);
            return Step {
                innovation: T::ZERO,
                status: Status::Limiting(Limit::Instruments),
            };
        }
        let weight = T::ONE / T::from_u32(self.count);
        self.sigma2 += (e * e - self.sigma2) * weight.max(T::ONE - self.config.forgetting);

        // Pζ and φᵀP.
        let (mut column, mut row) = ([T::ZERO; P], [T::ZERO; P]);
        for i in 0..p {
            column[i] = dot(&self.gain[i][..p], zeta);
            for (sum, x) in row[..p].iter_mut().zip(&self.gain[i]) {
                *sum += phi[i] * *x;
            }
        }
        let denominator = self.noise + dot(phi, &column[..p]);
        let least = self.noise * T::from_f64(LEAST_DENOMINATOR);
        let healthy = denominator.abs() >= least;
        let inverse = if healthy {
            T::ONE / denominator
        } else {
            T::ZERO
        };
        let mut size = T::ZERO;
        for i in 0..p {
            let k = column[i] * inverse;
            self.theta[i] += k * e;
            for j in 0..p {
                let x = (self.gain[i][j] - k * row[j]) * self.inverse_lambda;
                self.gain[i][j] = x;
                size += x.abs();
            }
        }
        // False for NaN as well.
        let most = T::from_f64(LARGEST_GAIN) * T::from_u32((p * p) as u32);
        let bounded = size <= most * self.config.start_variance;
        let louder = self.power > self.scale * T::from_f64(LOUDER);
        if !bounded || louder {
            self.begin();
        }
        Step {
            innovation: e,
            status: if healthy && bounded && !louder {
                Status::Running
            } else {
                Status::Limiting(Limit::Instruments)
            },
        }
    }

    /// Both registers by one sample.
    fn shift(&mut self, y: T) {
        let mut newest = -y;
        for x in &mut self.past {
            core::mem::swap(x, &mut newest);
        }
        // −y(t−q); what has just left the register if q is its length.
        let mut late = self.past.get(self.q).copied().unwrap_or(newest);
        for x in &mut self.instruments {
            core::mem::swap(x, &mut late);
        }
    }

    /// Coefficients a₁…a_p of A(q), without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.theta[..self.p]
    }

    /// Mean square of the equation error A(q)·y = C(q)·e, input units squared: not that
    /// of the innovations unless q is 0.
    pub fn equation_variance(&self) -> T {
        self.sigma2
    }

    /// Samples taken since the last beginning.
    pub fn count(&self) -> u32 {
        self.count
    }
}

fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (x, y)| sum + *x * *y)
}

#[cfg(test)]
#[path = "iv_tests.rs"]
mod tests;
