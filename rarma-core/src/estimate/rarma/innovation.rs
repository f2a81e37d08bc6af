//! What one innovation is worth beside the noise, the same in every recursion.
//!
//! Rate: once a sample.

use super::{RecursiveArma, SMALLEST_VARIANCE};
use crate::estimate::status::{Status, Step};
use crate::real::Real;

/// An innovation beside the noise.
pub(super) struct Weighed<T> {
    /// Its square.
    pub e2: T,
    /// Noise variance for this sample.
    pub variance: T,
    /// Largest square that counts in full.
    pub bound: T,
    /// Whether it is larger.
    pub outlier: bool,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// Starts anew. Cannot happen while C is kept stable and the input is bounded, only
    /// if the input spans the whole number range.
    pub(super) fn reject(&mut self) -> Step<T> {
        self.reset();
        Step {
            innovation: T::ZERO,
            status: Status::Rejected,
        }
    }

    /// How large an innovation is beside the noise; follows the power of the input.
    #[inline(always)]
    pub(super) fn weigh(&mut self, y: T, e: T) -> Weighed<T> {
        let e2 = e * e;
        self.power += self.config.power_gain * (y * y - self.power);
        let floor = self.power * self.config.dynamic_range + T::from_f64(SMALLEST_VARIANCE);
        // A model that predicts worse than no model at all would otherwise take its
        // own errors for noise and stop learning.
        let variance = self.sigma2.min(self.power).max(floor);
        let bound = self.config.outlier_ratio * variance;
        Weighed {
            e2,
            variance,
            bound,
            outlier: e2 > bound,
        }
    }
}
