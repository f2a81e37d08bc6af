//! What a scintillation means: limits, critical values, the verdict.
//!
//! Rate: decision rate.

use crate::real::Real;

/// Scintillation of a mode exactly at its limit of stability, averaged damping
/// h ∝ A³: w(V) is half a Gaussian bell and S = π/2 − 1. Less: self-excited.
pub const LIMIT_SCINTILLATION: f64 = 0.570_796_327;
/// Scintillation of a tone in noise of its own power, where w(V) stops decreasing.
pub const SUSPICIOUS_SCINTILLATION: f64 = 0.75;
/// Least N for a verdict that a mode is linear. At 32 a steady tone is told from one
/// by a linear mode in 84 % of the cases if it has four times the noise's power, in
/// 28 % if twice.
const LEAST_EFFECTIVE: f64 = 32.0;
/// z of S below which noise on a linear mode is excluded (1 %), and doubted (5 %).
const EXCLUDED_Z: f64 = -2.33;
const DOUBTED_Z: f64 = -1.64;
/// z of S, or of the drift, above which nothing stationary is left: up to 0.3 % of the
/// readings of a linear mode lie beyond 3.
const NOT_STATIONARY_Z: f64 = 3.0;
/// What the distribution of V says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Amplitude {
    /// Too few independent values.
    #[default]
    TooShort,
    /// S consistent with 1, or at least 0.75: a linear mode driven by noise.
    Forced,
    /// S below 0.75 and not by chance (5 %), but not low enough to be sure.
    Suspicious,
    /// S below 0.571, and noise on a linear mode excluded (1 %): a limit cycle. A line
    /// stronger than the noise looks the same.
    SelfExcited,
    /// S above 1, or the mean of V drifts: entry, exit, growth, a changing machine.
    NotStationary,
}

/// S and what it means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AmplitudeReading<T> {
    /// S = Var V/E²V: 1 for noise on a linear mode, 0 for a steady tone; 1 while
    /// nothing is known.
    pub scintillation: T,
    /// Standard deviation of S if the mode is linear, 2S/√N₂.
    pub scintillation_sd: T,
    /// N, number of independent values of V in the memory.
    pub effective: T,
    /// Mean of V, squared input units.
    pub mean: T,
    /// The verdict.
    pub verdict: Amplitude,
    /// How far S is from a linear mode's, in standard deviations of ln S; below −2.33
    /// with a probability of 1 % if the mode is linear.
    pub z: T,
    /// How far the means of the memory's two halves are apart, in standard deviations.
    pub drift_z: T,
}

impl<T: Real> AmplitudeReading<T> {
    /// Kurtosis E x⁴/E²x² of the vibration itself, 1.5·(1 + S): 3 for noise on a linear
    /// mode, 1.5 for a steady tone.
    pub fn kurtosis(&self) -> T {
        T::from_f64(1.5) * (T::ONE + self.scintillation)
    }
}

/// 1 % critical value of S: less is had by a linear mode in noise in 1 % of the cases.
///
/// ```text
/// S₁% = exp(−4.66/√N₂)
/// ```
///
/// N₂ is the number of independent values that the scatter of S is worth, between N
/// (values far apart) and 2N (V observed all the time); it is ∞ > `effective` > 0. With
/// N₂ = 32, 64, 128, 256 independent values: 0.439, 0.559, 0.662, 0.747.
pub fn critical_scintillation<T: Real>(effective: T) -> T {
    if effective > T::ZERO {
        (T::from_f64(2.0 * EXCLUDED_Z) / effective.sqrt()).exp()
    } else {
        T::ZERO
    }
}

/// The verdict on a scintillation, N, and the two z.
pub(super) fn verdict<T: Real>(s: T, effective: T, z: T, drift_z: T) -> Amplitude {
    let is = |z: T, limit: f64| z < T::from_f64(limit);
    if z.max(drift_z.abs()) > T::from_f64(NOT_STATIONARY_Z) {
        Amplitude::NotStationary
    } else if is(s, LIMIT_SCINTILLATION) && is(z, EXCLUDED_Z) {
        // Holds at any N: the fewer there are, the lower S must be.
        Amplitude::SelfExcited
    } else if is(effective, LEAST_EFFECTIVE) {
        Amplitude::TooShort
    } else if is(s, SUSPICIOUS_SCINTILLATION) && is(z, DOUBTED_Z) {
        Amplitude::Suspicious
    } else {
        Amplitude::Forced
    }
}
