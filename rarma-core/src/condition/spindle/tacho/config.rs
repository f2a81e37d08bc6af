//! Settings of a tacho, and what it says.

use crate::visit::choice;

/// Settings of a [`Tacho`](super::Tacho).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TachoConfig {
    /// Samples a second in which the times are given, Hz.
    pub fs_hz: f64,
    /// Pulses per turn, 1..=1000.
    pub pulses_per_turn: u32,
    /// Slowest speed, Hz: without a pulse for two of its intervals the tacho is silent.
    pub least_hz: f64,
    /// Scatter of the pulses' times about a smooth speed, as a fraction of their
    /// interval, above which they are noisy. Default 0.05.
    pub noisy_fraction: f64,
}

impl TachoConfig {
    /// One pulse per turn, from 2 Hz (120 rpm) up.
    pub fn new(fs_hz: f64) -> Self {
        Self {
            fs_hz,
            pulses_per_turn: 1,
            least_hz: 2.0,
            noisy_fraction: 0.05,
        }
    }
}

/// Which setting of [`TachoConfig`] is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TachoError {
    /// The rate must be positive and finite.
    Rate,
    /// 1 to 1000 pulses per turn.
    PulsesPerTurn,
    /// The slowest speed must be positive and below the rate.
    LeastSpeed,
    /// The fraction must lie in 0.001..=0.5.
    NoisyFraction,
}

/// What is wrong with the pulses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TachoFault {
    /// No pulse at all, or none for two intervals of the slowest speed.
    #[default]
    Silent,
    /// Pulses are missing: three of the last eight intervals were longer than 1.5 of
    /// the expected ones, or there is none for three.
    Missing,
    /// Extra pulses: three of the last eight came before 0.75 of an interval.
    Doubled,
    /// The times scatter too much, or three of the last eight pulses fit no rhythm.
    Noisy,
}

choice!(TachoFault: Silent, Missing, Doubled, Noisy);

/// Speed at the last pulse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TachoReading<T> {
    /// Turns a second, Hz, and standard deviation; none without a rhythm.
    pub spindle_hz: Option<(T, T)>,
    /// Part of a turn since a pulse (any of them, if there are several per turn),
    /// 0..1; none without a rhythm.
    pub turn: Option<T>,
    /// What is wrong, the worst first. A single pulse too many or too few is none.
    pub fault: Option<TachoFault>,
}
