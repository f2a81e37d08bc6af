//! What can be read off the recursive estimator. Decision rate, or rarer.

use super::RecursiveArma;
use crate::estimate::config::Gain;
use crate::real::Real;
use crate::ud::UdFactors;

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// Coefficients a₁…a_p of A(q), without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.theta[..P]
    }

    /// Coefficients c₁…c_q of C(q), without the leading 1.
    pub fn c(&self) -> &[T] {
        &self.theta[P..]
    }

    /// −y(t), −y(t−1), … −y(t−p+1), each filtered by 1/C with the model of its time;
    /// unfiltered with [`Gradient::Pseudo`](crate::estimate::Gradient::Pseudo).
    pub fn filtered_outputs(&self) -> &[T] {
        &self.psi[..P]
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
        self.start.is_ready()
    }

    /// Does what is left of the start-up at once, with the samples there are: for a
    /// series that ends early. Slow path, of unbounded work.
    pub fn finish_start(&mut self) {
        self.finish(P, Q);
    }

    /// Factor from P to the covariance of θ. With weights w = λᵏ, and the samples of
    /// the start-up all weighing the same, the estimate's covariance is P·Σw²/Σw: 1
    /// without forgetting, 1/(1 + λ) in the long run with it. A random walk leaves P as
    /// it is; so does the normalised gradient, with which it is 1. Slow path.
    pub fn covariance_factor(&self) -> T {
        let lambda = self.config.forgetting;
        let kept = matches!(self.config.gain, Gain::Normalised { .. });
        if kept || lambda == T::ONE || self.count == 0 {
            return T::ONE;
        }
        let steps = self.count.saturating_sub(self.known);
        let left = (T::from_u32(steps) * lambda.ln()).exp();
        let known = T::from_u32(self.known) * left;
        let sum = known + (T::ONE - left) / (T::ONE - lambda);
        let squares = known * left + (T::ONE - left * left) / (T::ONE - lambda * lambda);
        squares / sum
    }

    /// Covariance factors; multiply by [`Self::covariance_factor`]. With
    /// [`Gain::Normalised`] they are those of the start-up.
    pub fn covariance(&self) -> &UdFactors<T, N> {
        &self.covariance
    }
}
