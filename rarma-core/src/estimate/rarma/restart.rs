//! The recursive estimator begins, where it lies.
//!
//! Slow path, and cold in the sample path: a model that has lost its numbers begins anew.

use super::RecursiveArma;
use super::start::Start;
use crate::estimate::config::RarmaConfig;
use crate::real::Real;
use crate::ud::UdFactors;

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// Nothing at all, until [`Self::restart`]. Every bit is 0: where it is put, no copy of
    /// it is made first.
    pub(crate) const BLANK: Self = Self {
        theta: [T::ZERO; N],
        phi: [T::ZERO; N],
        psi: [T::ZERO; N],
        older: [T::ZERO; N],
        covariance: UdFactors::BLANK,
        config: RarmaConfig::BLANK,
        inverse_lambda: T::ZERO,
        inverse_radius: T::ZERO,
        sigma2: T::ZERO,
        variance_gain: T::ZERO,
        recent: T::ZERO,
        power: T::ZERO,
        known: 0,
        count: 0,
        turn: 0,
        at_ceiling: 0,
        start: Start::BLANK,
    };

    /// Storage without the check of N, for a run-time order below the capacity.
    pub(in crate::estimate) fn raw(config: RarmaConfig<T>) -> Self {
        let mut this = Self::BLANK;
        this.restart(config);
        this
    }

    /// Forgets everything and takes these settings, as [`Self::new`] does, but in place: a
    /// model is 6 KB, and no second one lies on the stack meanwhile.
    #[cold]
    #[inline(never)]
    pub fn restart(&mut self, config: RarmaConfig<T>) {
        // All of them by name, so that none is forgotten.
        let Self {
            theta,
            phi,
            psi,
            older,
            covariance,
            config: settings,
            inverse_lambda,
            inverse_radius,
            sigma2,
            variance_gain,
            recent,
            power,
            known,
            count,
            turn,
            at_ceiling,
            start,
        } = self;
        let config = config.checked().unwrap_or_default();
        for parameters in [theta, phi, psi, older] {
            parameters.fill(T::ZERO);
        }
        covariance.reset(config.start_variance);
        *inverse_lambda = T::ONE / config.forgetting;
        *inverse_radius = T::ONE / config.c_radius;
        *variance_gain = T::ONE;
        for x in [sigma2, recent, power] {
            *x = T::ZERO;
        }
        (*known, *count, *turn, *at_ceiling) = (0, 0, 0, 0);
        start.begin(config.start_samples, config.gain);
        *settings = config;
    }

    /// Forgets everything but the settings.
    pub fn reset(&mut self) {
        self.restart(self.config);
    }
}
