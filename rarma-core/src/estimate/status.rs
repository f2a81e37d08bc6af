//! What the recursive estimator says about itself, sample by sample.

/// What the estimator is doing, returned with every update.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// Start-up: samples are collected and worked through; the model is not to be
    /// used yet.
    Starting,
    /// Running freely.
    Running,
    /// Running, but something is being held back; see the limit.
    Limiting(Limit),
    /// The sample was not finite or beyond 1e15 and has been left out; nothing changed.
    Rejected,
}

/// What is being held back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Limit {
    /// The step would have made C(q) unstable; the noise part was shortened or kept.
    NoiseModel,
    /// A covariance factor stands at its ceiling: too little excitation.
    Covariance,
    /// The sample was far outside the innovations' spread and weighs less.
    Outlier,
    /// The instruments tell next to nothing about the regressors: the sample was left
    /// out, or the gain begins anew. Of [`RecursiveIv`](super::RecursiveIv) only.
    Instruments,
}

/// Result of one update.
#[derive(Debug, Clone, Copy)]
pub struct Step<T> {
    /// One-step prediction error (innovation) e(t) = y(t) − φᵀθ(t−1), input units.
    pub innovation: T,
    /// What the estimator is doing.
    pub status: Status,
}
