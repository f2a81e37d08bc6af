//! What is known of one mode over time: damping, loudness, gradient, suspicion.
//!
//! Rate: decision rate.

use super::config::AlarmConfig;
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Where a mode's vibration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Label {
    /// Undamped, and not explained by the rotation.
    SelfExcited,
    /// A damped resonance.
    Structural,
    /// At a multiple of the spindle or tooth frequency, or of a stronger line.
    Forced,
}

/// One mode at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode<T> {
    /// Undamped natural frequency, Hz.
    pub frequency: T,
    /// Standard deviation of it, Hz.
    pub frequency_sd: T,
    /// Operational damping ratio ζ.
    pub damping: T,
    /// Standard deviation of it.
    pub damping_sd: T,
    /// Peak amplitude of the vibration at the mode, input units.
    pub amplitude: T,
    /// Part of the band's power, less what the rotation explains, that is at the
    /// mode, 0 to about 1; 0 for a mode that the rotation explains.
    pub share: T,
    /// Change of ζ per second; negative while stability is being lost.
    pub gradient: T,
    /// Where the vibration comes from.
    pub label: Label,
    /// Multiple of the spindle frequency it sits on, if it is lightly damped.
    pub harmonic: Option<u32>,
}

/// What is measured of one mode at one decision.
#[derive(Debug, Clone, Copy)]
pub struct Reading<T> {
    /// Frequency, Hz, and its standard deviation.
    pub frequency: (T, T),
    /// Damping ratio and its standard deviation.
    pub damping: (T, T),
    /// Peak amplitude, input units.
    pub amplitude: T,
    /// Part of the band's power less what the rotation explains.
    pub share: T,
    /// Multiple of the spindle frequency.
    pub harmonic: Option<u32>,
    /// A line at a half or a third of the frequency is there that the rotation
    /// does not explain: the mode is a harmonic of it.
    pub overtone: bool,
    /// Inside the band that is analysed.
    pub in_band: bool,
}

/// Memory of one mode.
#[derive(Debug, Clone, Copy)]
pub struct ModeTrack<T> {
    smooth_damping: Option<T>,
    gradient: T,
    suspicion_s: T,
    overtone_s: T,
}

impl<T: Real> Default for ModeTrack<T> {
    fn default() -> Self {
        Self {
            smooth_damping: None,
            gradient: T::ZERO,
            suspicion_s: T::ZERO,
            overtone_s: T::ZERO,
        }
    }
}

/// Smoothing of ζ ahead of its gradient, s.
const GRADIENT_TAU_S: f64 = 0.05;
/// An overtone label outlives the moment it was seen, s.
const OVERTONE_HOLD_S: f64 = 0.1;

impl<T: Real> ModeTrack<T> {
    /// How long the mode has been undamped, loud and unexplained, s, each moment
    /// weighted by how sure it is.
    pub fn suspicion_s(&self) -> T {
        self.suspicion_s
    }

    /// Takes one reading. `config` says what is undamped and loud; `period_s` is the
    /// time since the last decision.
    pub fn update(
        &mut self,
        reading: &Reading<T>,
        config: &AlarmConfig<T>,
        period_s: T,
    ) -> Mode<T> {
        let undamped = config.undamped(reading.damping);
        let loud = config.loud(reading.share);
        let (damping, damping_sd) = reading.damping;
        let gain = (period_s / T::from_f64(GRADIENT_TAU_S)).min(T::ONE);
        let before = self.smooth_damping.unwrap_or(damping);
        let after = before + gain * (damping - before);
        self.smooth_damping = Some(after);
        self.gradient += gain * ((after - before) / period_s - self.gradient);

        self.overtone_s = if reading.overtone {
            T::from_f64(OVERTONE_HOLD_S)
        } else {
            (self.overtone_s - period_s).max(T::ZERO)
        };
        let explained = reading.harmonic.is_some() || self.overtone_s > T::ZERO;
        // Suspicion grows as fast as the reading is sure, and goes as fast as it came:
        // one bad reading does not clear it.
        let evidence = if loud && reading.in_band {
            config.evidence(reading.damping)
        } else {
            -T::ONE
        };
        self.suspicion_s = if explained {
            T::ZERO
        } else {
            (self.suspicion_s + period_s * evidence).max(T::ZERO)
        };
        self.suspicion_s = self.suspicion_s.min(T::ONE);
        // A resonance with damping of its own is structural wherever it lies; only a
        // line is forced.
        let lightly_damped = config.may_be_line(reading.damping);
        Mode {
            frequency: reading.frequency.0,
            frequency_sd: reading.frequency.1,
            damping,
            damping_sd,
            amplitude: reading.amplitude,
            share: reading.share,
            gradient: self.gradient,
            label: if explained && lightly_damped {
                Label::Forced
            } else if undamped && loud && reading.in_band {
                Label::SelfExcited
            } else {
                Label::Structural
            },
            harmonic: reading.harmonic.filter(|_| lightly_damped),
        }
    }

    /// Forgets the mode; its place is taken by another.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}
