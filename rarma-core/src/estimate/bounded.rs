//! The recursive estimator with an order chosen at run time, for the host.

use super::config::RarmaConfig;
use super::rarma::RecursiveArma;
use super::status::Step;
use crate::real::Real;
use crate::ud::UdFactors;

/// Largest p and largest q of [`BoundedArma`].
pub const MAX_ORDER: usize = 30;
const N: usize = 2 * MAX_ORDER;

/// [`RecursiveArma`] for any p, q up to 30: the same source with the order as a
/// value. Storage is that of (30,30); the box uses the sized aliases instead.
#[derive(Debug, Clone)]
pub struct BoundedArma<T> {
    pub(super) inner: RecursiveArma<T, MAX_ORDER, MAX_ORDER, N>,
    p: usize,
    q: usize,
}

impl<T: Real> BoundedArma<T> {
    /// A model of order (p, q); none if p or q is above 30 or both are 0.
    pub fn new(p: usize, q: usize, config: RarmaConfig<T>) -> Option<Self> {
        (p <= MAX_ORDER && q <= MAX_ORDER && p + q > 0).then(|| Self {
            inner: RecursiveArma::raw(config),
            p,
            q,
        })
    }

    /// Takes one sample; see [`RecursiveArma`].
    pub fn update(&mut self, y: T) -> Step<T> {
        self.inner.step(y, self.p, self.q)
    }

    /// See [`RecursiveArma::finish_start`].
    pub fn finish_start(&mut self) {
        self.inner.finish(self.p, self.q);
    }

    /// Coefficients a₁…a_p.
    pub fn a(&self) -> &[T] {
        &self.inner.theta()[..self.p]
    }

    /// Coefficients c₁…c_q.
    pub fn c(&self) -> &[T] {
        &self.inner.theta()[self.p..self.p + self.q]
    }

    /// Innovation variance σ².
    pub fn sigma2(&self) -> T {
        self.inner.sigma2()
    }

    /// The start-up is over.
    pub fn ready(&self) -> bool {
        self.inner.ready()
    }

    /// Covariance factors of θ = (a, c), and the factor that scales them.
    pub fn covariance(&self) -> (&UdFactors<T, N>, T) {
        (self.inner.covariance(), self.inner.covariance_factor())
    }
}
