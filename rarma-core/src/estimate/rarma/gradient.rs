//! The normalised gradient: the recursion without a covariance.
//!
//! Rate: once a sample, in O(n). See [`Gain::Normalised`].

use super::innovation::Weighed;
use super::{RecursiveArma, SMALLEST_VARIANCE};
use crate::estimate::config::{Gain, Gradient};
use crate::estimate::status::{Limit, Status, Step};
use crate::real::Real;

/// Part of the input power that is added to |ψ|², for each parameter: where the input
/// has just begun or has just ended, a few small numbers would otherwise take a whole
/// step.
const REGULARISATION: f64 = 1e-3;

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// One step of θ ← θ + γ·ψ·e/|ψ|², C kept stable (eqs. 41 and 42 of the thesis).
    /// An outlier counts as one that lies on the border.
    #[cold]
    #[inline(never)]
    pub(super) fn advance_steepest(&mut self, y: T, p: usize, q: usize) -> Step<T> {
        let n = p + q;
        let gamma = match self.config.gain {
            Gain::Normalised { step } => step,
            Gain::Covariance => T::ZERO,
        };
        let e = self.predict(y, p, q);
        let square = self.psi[..n].iter().fold(T::ZERO, |sum, x| sum + *x * *x);
        if !e.is_finite() || !square.is_finite() {
            return self.reject();
        }

        let Weighed {
            e2, bound, outlier, ..
        } = self.weigh(y, e);
        let error = if outlier { e * (bound / e2).sqrt() } else { e };

        let share = T::from_f64(REGULARISATION) * T::from_u32(n as u32);
        let length = square + self.power * share + T::from_f64(SMALLEST_VARIANCE);
        let direction = self.psi;
        let full_step = self.correct(p, q, &direction, gamma * error / length);
        let filtered = matches!(self.config.gradient, Gradient::Filtered);
        let _ = self.filter(y, e, p, q, filtered);
        self.track_variance(if outlier { bound } else { e2 });
        let status = if !full_step {
            Status::Limiting(Limit::NoiseModel)
        } else if outlier {
            Status::Limiting(Limit::Outlier)
        } else {
            Status::Running
        };
        Step {
            innovation: e,
            status,
        }
    }
}
