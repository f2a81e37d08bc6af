//! Settings of the recursive estimator.

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Which derivative of the prediction error drives the recursion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Gradient {
    /// Pseudo-linear regression (RPLR, extended least squares): φ itself. Robust
    /// from a cold start, scatters more on several modes.
    Pseudo,
    /// Prediction error method (RPEM): φ filtered by 1/C(q). Reaches the
    /// Cramér–Rao bound, needs a start near the truth.
    #[default]
    Filtered,
}

/// A setting out of range, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConfigError {
    /// `forgetting` and `start_forgetting` must lie in 0.9..=1, `forgetting_rate` in
    /// 0..=1.
    Forgetting,
    /// `random_walk` must lie in 0..=0.01.
    RandomWalk,
    /// `start_variance` and `restart_variance` must be positive and finite.
    Variance,
    /// `c_radius` must lie in 0.5..=1.
    CRadius,
    /// A field is NaN or infinite.
    NotFinite,
}

/// Settings of [`RecursiveArma`](super::RecursiveArma). No field has an input
/// unit: the estimator scales itself by the innovation variance it finds.
#[derive(Debug, Clone, Copy)]
pub struct RarmaConfig<T> {
    /// Gradient after the start-up. Default: filtered (RPEM).
    pub gradient: Gradient,
    /// Forgetting factor λ per sample, 0.9..=1, default 1 (remember everything).
    /// The memory is 1/(1 − λ) samples.
    pub forgetting: T,
    /// Forgetting factor at the start of each stage, 0.9..=1, default 0.99: what a
    /// poor model taught is forgotten again.
    pub start_forgetting: T,
    /// Rate at which it rises to `forgetting`, per sample, 0..=1, default 0.005.
    pub forgetting_rate: T,
    /// Variance of a random walk of every parameter, per sample, 0..=0.01, default
    /// 0. The thesis' R_e. Recovers faster than forgetting after a loud passage.
    pub random_walk: T,
    /// First samples that only set the scale (σ² starts as the input power).
    /// Default 64; 0 for a short series whose variance is given beforehand.
    pub settle_samples: u32,
    /// Up to this sample only A is estimated, by least squares, which cannot
    /// diverge; C joins with residuals that mean something. Default 320.
    pub autoregressive_samples: u32,
    /// Samples of pseudo-linear regression before the gradient takes over.
    /// Default 1000; a cold start with the filtered gradient fails (docs/decisions/0003).
    pub startup_samples: u32,
    /// Variance of each parameter before the first sample. Default 0.1.
    pub start_variance: T,
    /// Variance of each parameter when the gradient takes over. Default 1.
    pub restart_variance: T,
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
            forgetting: T::ONE,
            start_forgetting: T::from_f64(0.99),
            forgetting_rate: T::from_f64(0.005),
            random_walk: T::ZERO,
            settle_samples: 64,
            autoregressive_samples: 320,
            startup_samples: 1000,
            start_variance: T::from_f64(0.1),
            restart_variance: T::ONE,
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
    /// These settings, or the name of the first that is out of range.
    ///
    /// # Errors
    /// The field that is out of range.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let within = |x: T, lo: f64, hi: f64| x >= T::from_f64(lo) && x <= T::from_f64(hi);
        let all = [
            self.forgetting,
            self.start_forgetting,
            self.forgetting_rate,
            self.random_walk,
            self.start_variance,
            self.restart_variance,
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
        } else if !within(self.forgetting, 0.9, 1.0)
            || !within(self.start_forgetting, 0.9, 1.0)
            || !within(self.forgetting_rate, 0.0, 1.0)
        {
            Err(ConfigError::Forgetting)
        } else if !within(self.random_walk, 0.0, 0.01) {
            Err(ConfigError::RandomWalk)
        } else if !(self.start_variance > T::ZERO && self.restart_variance > T::ZERO) {
            Err(ConfigError::Variance)
        } else if !within(self.c_radius, 0.5, 1.0) {
            Err(ConfigError::CRadius)
        } else {
            Ok(self)
        }
    }
}
