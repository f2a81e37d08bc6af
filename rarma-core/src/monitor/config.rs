//! Settings of a monitor.

use crate::condition::{Band, BandError};
use crate::decide::AlarmConfig;
use crate::estimate::{Gradient, RarmaConfig};
use crate::order::Order;
use crate::real::Real;
use crate::verdict::{Listening, VerdictConfig, VerdictError};

/// Everything a monitor needs to know. SI units; `f64` because it is read once.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MonitorConfig {
    /// Sampling rate of the input, Hz.
    pub fs_hz: f64,
    /// Largest value the converter gives, input units, where it is known. Without
    /// it clipping is not looked for.
    pub full_scale: Option<f64>,
    /// Band that is analysed. Default [`Band::usual`].
    pub band: Option<Band>,
    /// Model order. Default (8,7).
    pub order: Order,
    /// Spindle frequency, Hz, where it is known.
    pub spindle_hz: Option<f64>,
    /// Teeth on the cutter, where they are known.
    pub teeth: Option<u32>,
    /// Pulses a turn of a tacho whose pulses are told by `Monitor::pulse`, 1..=100, where
    /// there is one. Its speed goes before the setting.
    pub tacho_pulses: Option<u32>,
    /// Damping ratio below which a mode counts as undamped, 0.0005..=0.2,
    /// default 0.01.
    pub threshold: f64,
    /// A stretch of time known to be idle, s from the start.
    pub idle_s: Option<(f64, f64)>,
    /// Memory of the estimator, s, default 0.1; at least [`LEAST_MEMORY`] samples
    /// of the decimated rate are kept whatever it says.
    pub memory_s: f64,
    /// Random walk of the parameters, variance per sample, default 0.
    pub random_walk: f64,
    /// Gradient of the estimator. Default: filtered (RPEM).
    pub gradient: Gradient,
    /// The sampler has no anti-alias filter: multiples of the speed may lie folded anywhere.
    pub aliased: bool,
    /// Numbers of the verdict on lines.
    pub verdict: VerdictConfig,
}

/// Shortest memory of the estimator, decimated samples.
pub const LEAST_MEMORY: f64 = 500.0;
/// Decisions are made this often, s, or at every decimated sample if that is rarer.
pub const DECISION_PERIOD_S: f64 = 0.002;

/// Why a monitor cannot be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MonitorError {
    /// The band does not fit the rate.
    Band(BandError),
    /// The threshold must lie in 0.0005..=0.2.
    Threshold,
    /// The spindle frequency must be positive, finite, and below 5000 Hz.
    Spindle,
    /// Teeth must be 1..=1000.
    Teeth,
    /// Tacho pulses a turn must be 1..=100.
    Tacho,
    /// The idle stretch must start at 0 or later and end after it starts.
    Idle,
    /// The memory must lie in 0.001..=100 s.
    Memory,
    /// The random walk must lie in 0..=0.01.
    RandomWalk,
    /// Full scale must be positive and finite.
    FullScale,
    /// A number of the verdict is out of range.
    Verdict(VerdictError),
}

impl MonitorConfig {
    /// Defaults for an input of rate `fs_hz`.
    pub fn new(fs_hz: f64) -> Self {
        Self {
            fs_hz,
            full_scale: None,
            band: None,
            order: Order::O87,
            spindle_hz: None,
            teeth: None,
            tacho_pulses: None,
            threshold: 0.01,
            idle_s: None,
            memory_s: 0.1,
            random_walk: 0.0,
            gradient: Gradient::Filtered,
            aliased: false,
            verdict: VerdictConfig::default(),
        }
    }

    /// The band in use.
    pub fn band(&self) -> Band {
        self.band.unwrap_or_else(|| Band::usual(self.fs_hz))
    }

    /// Whether a spindle may turn so fast, Hz.
    pub(super) fn is_speed(spindle_hz: f64) -> bool {
        (1e-3..=5000.0).contains(&spindle_hz)
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn check(&self) -> Result<(), MonitorError> {
        let within = |x: f64, lo: f64, hi: f64| x >= lo && x <= hi;
        self.band().check(self.fs_hz).map_err(MonitorError::Band)?;
        if !within(self.threshold, 0.0005, 0.2) {
            return Err(MonitorError::Threshold);
        }
        if self.spindle_hz.is_some_and(|f| !Self::is_speed(f)) {
            return Err(MonitorError::Spindle);
        }
        if self.teeth.is_some_and(|z| !(1..=1000).contains(&z)) {
            return Err(MonitorError::Teeth);
        }
        if self.tacho_pulses.is_some_and(|n| !(1..=100).contains(&n)) {
            return Err(MonitorError::Tacho);
        }
        if self
            .idle_s
            .is_some_and(|(from, to)| !(from >= 0.0 && to > from && to.is_finite()))
        {
            return Err(MonitorError::Idle);
        }
        if !within(self.memory_s, 0.001, 100.0) {
            return Err(MonitorError::Memory);
        }
        if !within(self.random_walk, 0.0, 0.01) {
            return Err(MonitorError::RandomWalk);
        }
        if self.full_scale.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
            return Err(MonitorError::FullScale);
        }
        self.verdict.check().map_err(MonitorError::Verdict)
    }

    /// Settings of the estimator at decimated rate `fs`.
    pub(super) fn estimator<T: Real>(&self, fs: f64) -> RarmaConfig<T> {
        let memory = (self.memory_s * fs).max(LEAST_MEMORY);
        RarmaConfig {
            gradient: self.gradient,
            forgetting: T::from_f64(1.0 - 1.0 / memory),
            random_walk: T::from_f64(self.random_walk),
            variance_gain: T::from_f64(1.0 / memory),
            ..RarmaConfig::default()
        }
    }

    /// What the verdict on lines is told, at decimated rate `fs`.
    pub(super) fn listening(&self, fs: f64) -> Listening {
        Listening {
            fs_hz: fs,
            spindle_hz: self.spindle_hz.filter(|hz| *hz >= 0.1),
            teeth: self.teeth,
            folding_hz: self.aliased.then_some(self.fs_hz),
        }
    }

    /// Settings of the verdict.
    pub(super) fn alarm<T: Real>(&self) -> AlarmConfig<T> {
        AlarmConfig {
            threshold: T::from_f64(self.threshold),
            ..AlarmConfig::default()
        }
    }
}
