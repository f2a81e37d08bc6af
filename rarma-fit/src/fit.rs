//! A fitted ARMA model with its covariance.

use super::delta::{PoleDeviation, pole_deviation};
use super::prediction::{Orders, Residuals};
use rarma_core::real::Real;

/// An ARMA(p, q) model fitted to a whole series, p + q ≤ `N`.
///
/// A(q)·(y − mean) = C(q)·e with A = 1 + Σ aᵢ q⁻ⁱ and C = 1 + Σ cᵢ q⁻ⁱ, plus signs.
#[derive(Debug, Clone, Copy)]
pub struct ArmaFit<T, const N: usize> {
    pub(super) theta: [T; N],
    pub(super) order: Orders,
    pub(super) sigma2: T,
    pub(super) mean: T,
    pub(super) samples: usize,
    pub(super) covariance: [[T; N]; N],
    pub(super) log_likelihood: T,
    /// e(p−1), e(p−2) … as the fit took them, input units.
    pub(super) before: [T; N],
    pub(super) iterations: u32,
    pub(super) converged: bool,
}

impl<T: Real, const N: usize> ArmaFit<T, N> {
    /// Coefficients a₁…a_p, without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.theta[..self.order.p]
    }

    /// Coefficients c₁…c_q, without the leading 1.
    pub fn c(&self) -> &[T] {
        &self.theta[self.order.p..self.order.n()]
    }

    /// Innovation variance σ², input units squared; the sum of squares over the
    /// number of prediction errors, not corrected for the parameters.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }

    /// Mean of the series, input units; 0 unless it was estimated.
    pub fn mean(&self) -> T {
        self.mean
    }

    /// Prediction errors that σ² was counted from.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Natural logarithm of the likelihood at the estimate: the exact one from the
    /// likelihood fit, the one conditional on the first p samples from the
    /// prediction-error fit.
    pub fn log_likelihood(&self) -> T {
        self.log_likelihood
    }

    /// Covariance of parameters i and j of θ = (a, c); NaN outside p + q.
    pub fn covariance(&self, i: usize, j: usize) -> T {
        if i < self.order.n() && j < self.order.n() {
            self.covariance[i][j]
        } else {
            T::from_f64(f64::NAN)
        }
    }

    /// Standard deviation of parameter i of θ = (a, c).
    pub fn deviation(&self, i: usize) -> T {
        self.covariance(i, i).max(T::ZERO).sqrt()
    }

    /// Standard deviations of frequency and damping ratio of a root
    /// z = re + j·im of A, sampled at `fs` Hz; none for a real root.
    pub fn pole(&self, re: T, im: T, fs: T) -> Option<PoleDeviation<T>> {
        pole_deviation(self.a(), &self.covariance, re, im, fs)
    }

    /// Prediction errors e(t) from t = p on, those before as the fit took them: what a test of
    /// whiteness is given. The same series as the fit, or another, in whose first residuals those
    /// before are not its own.
    pub fn residuals<'a>(&self, y: &'a [T]) -> Residuals<'a, T, N> {
        Residuals {
            y,
            mean: self.mean,
            order: self.order,
            theta: self.theta,
            past: self.before,
            t: self.order.p,
        }
    }

    /// Linearisations the search took, over all starts.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// The search ended at a minimum; false if at the limit of iterations, or at
    /// the edge where a root of C reaches the largest allowed radius.
    pub fn converged(&self) -> bool {
        self.converged
    }
}
