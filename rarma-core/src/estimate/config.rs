//! Settings of the recursive estimator.

use crate::real::Real;

/// Samples of the start-up's least squares at most.
pub(super) const MOST: usize = 400;

/// Which derivative of the prediction error drives the recursion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Gradient {
    /// Pseudo-linear regression (RPLR, extended least squares): φ itself. Robust
    /// from a cold start, scatters more on several modes.
    Pseudo,
    /// Prediction error method (RPEM): φ filtered by 1/C(q). Reaches the
    /// Cramér–Rao bound, needs a start near the truth.
    #[default]
    Filtered,
}

/// Gain K of θ ← θ + K·e.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(u8)]
pub enum Gain<T> {
    /// From the covariance of θ, a step in the direction of Newton (eq. 43 of the
    /// thesis).
    #[default]
    Covariance,
    /// Normalised gradient: K = `step`·ψ/|ψ|² (eqs. 41 and 42), in O(n) instead of
    /// O(n²). Forgetting and random walk are not used, and the covariance stays that
    /// of the start-up. See [`Gain::normalised`] for a step.
    Normalised {
        /// γ, 0..=1: part of the prediction error that one step takes away.
        step: T,
    },
}

impl<T: Real> Gain<T> {
    /// Normalised gradient with a step of 0.001: of those measured the one nearest to
    /// the bound after 5000 samples at order (2,1) (docs/estimators.md).
    pub fn normalised() -> Self {
        Self::Normalised {
            step: T::from_f64(0.001),
        }
    }
}

/// A setting out of range, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// `forgetting` must lie in 0.9..=1.
    Forgetting,
    /// `random_walk` must lie in 0..=0.01.
    RandomWalk,
    /// `start_variance` must be positive and finite.
    Variance,
    /// `start_samples` must lie in 0..=400.
    StartSamples,
    /// `c_radius` must lie in 0.5..=1.
    CRadius,
    /// The step of [`Gain::Normalised`] must lie in 0..=1.
    Step,
    /// A field is NaN or infinite.
    NotFinite,
}

/// Settings of [`RecursiveArma`](super::RecursiveArma). No field has an input
/// unit: the estimator scales itself by the innovation variance it finds.
#[derive(Debug, Clone, Copy)]
pub struct RarmaConfig<T> {
    /// Gradient after the start-up. Default: filtered (RPEM).
    pub gradient: Gradient,
    /// Gain after the start-up. Default: from the covariance.
    pub gain: Gain<T>,
    /// Forgetting factor λ per sample, 0.9..=1, default 1 (remember everything).
    /// The memory is 1/(1 − λ) samples.
    pub forgetting: T,
    /// Variance of a random walk of every parameter, per sample, 0..=0.01, default
    /// 0. The thesis' R_e. Recovers faster than forgetting after a loud passage.
    pub random_walk: T,
    /// Samples of the start-up's least squares, 0..=400, default 400. The model is
    /// ready after about two and a half times as many, and nothing is lost: the
    /// samples that came meanwhile are worked off. 0 starts cold, which fails on
    /// several modes (docs/decisions/0003).
    pub start_samples: u32,
    /// Variance of each parameter before anything is known, default 1e4: in
    /// ARMA(8,7) a coefficient is up to 70.
    pub start_variance: T,
    /// Largest root radius allowed for C(q), 0.5..=1, default 0.998.
    pub c_radius: T,
    /// A squared innovation above this multiple of σ² is an outlier and weighs
    /// less. Default 25 (five standard deviations).
    pub outlier_ratio: T,
    /// Least gain of an innovation on σ². Default 0: σ² is the mean over all.
    pub variance_gain: T,
    /// Gain of the input power that sets the dynamic range. Default 1e-3.
    pub power_gain: T,
    /// σ² is not let below this fraction of the input power. Default 1e-9 (90 dB).
    pub dynamic_range: T,
    /// Ceiling of a covariance factor. Default 1000: no wind-up beyond it.
    pub d_ceiling: T,
    /// Floor of a covariance factor. Default 1e-12.
    pub d_floor: T,
}

impl<T: Real> Default for RarmaConfig<T> {
    fn default() -> Self {
        Self {
            gradient: Gradient::Filtered,
            gain: Gain::Covariance,
            forgetting: T::ONE,
            random_walk: T::ZERO,
            start_samples: MOST as u32,
            start_variance: T::from_f64(1e4),
            c_radius: T::from_f64(0.998),
            outlier_ratio: T::from_f64(25.0),
            variance_gain: T::ZERO,
            power_gain: T::from_f64(1e-3),
            dynamic_range: T::from_f64(1e-9),
            d_ceiling: T::from_f64(1000.0),
            d_floor: T::from_f64(1e-12),
        }
    }
}

impl<T: Real> RarmaConfig<T> {
    /// Zeros, and out of range: of a model that has not been started.
    pub(super) const BLANK: Self = Self {
        gradient: Gradient::Pseudo,
        gain: Gain::Covariance,
        forgetting: T::ZERO,
        random_walk: T::ZERO,
        start_samples: 0,
        start_variance: T::ZERO,
        c_radius: T::ZERO,
        outlier_ratio: T::ZERO,
        variance_gain: T::ZERO,
        power_gain: T::ZERO,
        dynamic_range: T::ZERO,
        d_ceiling: T::ZERO,
        d_floor: T::ZERO,
    };

    /// These settings, or the name of the first that is out of range.
    ///
    /// # Errors
    /// The field that is out of range.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let within = |x: T, lo: f64, hi: f64| x >= T::from_f64(lo) && x <= T::from_f64(hi);
        let step = match self.gain {
            Gain::Covariance => T::ZERO,
            Gain::Normalised { step } => step,
        };
        let all = [
            step,
            self.forgetting,
            self.random_walk,
            self.start_variance,
            self.c_radius,
            self.outlier_ratio,
            self.variance_gain,
            self.power_gain,
            self.dynamic_range,
            self.d_ceiling,
            self.d_floor,
        ];
        if !all.iter().all(|x| x.is_finite()) {
            Err(ConfigError::NotFinite)
        } else if !within(self.forgetting, 0.9, 1.0) {
            Err(ConfigError::Forgetting)
        } else if !within(self.random_walk, 0.0, 0.01) {
            Err(ConfigError::RandomWalk)
        } else if !(self.start_variance > T::ZERO) {
            Err(ConfigError::Variance)
        } else if self.start_samples > MOST as u32 {
            Err(ConfigError::StartSamples)
        } else if !within(self.c_radius, 0.5, 1.0) {
            Err(ConfigError::CRadius)
        } else if !within(step, 0.0, 1.0) {
            Err(ConfigError::Step)
        } else {
            Ok(self)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(gain: Gain<f64>, c_radius: f64) -> Option<ConfigError> {
        let config = RarmaConfig {
            gain,
            c_radius,
            ..RarmaConfig::default()
        };
        config.checked().err()
    }

    #[test]
    fn the_step_lies_between_nothing_and_all_of_the_error() {
        let of = |step| check(Gain::Normalised { step }, 0.998);
        for step in [0.0, -0.0, 1e-9, 0.001, 1.0] {
            assert_eq!(of(step), None, "{step}");
        }
        for step in [-1e-9, -1.0, 1.0 + 1e-9, 2.0, f64::MAX] {
            assert_eq!(of(step), Some(ConfigError::Step), "{step}");
        }
        for step in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(of(step), Some(ConfigError::NotFinite), "{step}");
        }
        assert_eq!(check(Gain::normalised(), 0.998), None);
        assert_eq!(check(Gain::Covariance, 0.998), None);
        // The first field that is out of range is named.
        let both = check(Gain::Normalised { step: 2.0 }, 0.1);
        assert_eq!(both, Some(ConfigError::CRadius));
    }
}
