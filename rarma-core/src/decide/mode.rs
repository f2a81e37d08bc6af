//! What is known of one mode over time: damping, loudness, gradient, suspicion.
//!
//! Rate: decision rate.

use super::config::AlarmConfig;
use super::origin::Origin;
use super::sequential::Evidence;
use crate::real::Real;
use crate::visit::state;

/// Where a mode's vibration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Label {
    /// Undamped, and nothing else explains it.
    SelfExcited,
    /// A damped resonance.
    Structural,
    /// A line that something else explains, see [`Origin`]; or one of unknown origin
    /// that has been undamped for as long as it is known.
    Forced,
}

/// One mode at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    /// Part of the band's power, less what is explained, that is at the mode, 0 to
    /// about 1; 0 for a mode that is explained.
    pub share: T,
    /// Part of all of the band's power, the spindle's lines included.
    pub share_of_all: T,
    /// Change of ζ per second; negative while stability is being lost.
    pub gradient: T,
    /// Time until ζ reaches zero at that rate, s, where the rate is certain by two
    /// standard deviations.
    pub time_left_s: Option<T>,
    /// Where the vibration comes from.
    pub label: Label,
    /// What else explains it.
    pub origin: Origin,
    /// Multiple of the spindle frequency it sits on, if it is lightly damped.
    pub harmonic: Option<u32>,
    /// How near it is to being called, 0..=1.
    pub suspicion: T,
    /// What the sequential test says.
    pub evidence: Evidence<T>,
    /// It was damped for certain until a moment ago.
    pub was_damped: bool,
    /// It has grown out of damping, or risen by itself.
    pub grew: bool,
}

/// What is measured of one mode at one decision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reading<T> {
    /// Frequency, Hz, and its standard deviation.
    pub frequency: (T, T),
    /// Damping ratio and its standard deviation.
    pub damping: (T, T),
    /// Peak amplitude, input units.
    pub amplitude: T,
    /// Part of the band's power less what is explained.
    pub share: T,
    /// Part of all of the band's power.
    pub share_of_all: T,
    /// What else explains a line there.
    pub origin: Origin,
    /// Multiple of the spindle frequency.
    pub harmonic: Option<u32>,
    /// Inside the band that is analysed.
    pub in_band: bool,
    /// It has grown out of damping, or risen by itself: where its origin is unknown, it
    /// is self-excited.
    pub grew: bool,
    /// Damping ratio below which it counts as undamped: the setting's, or less for a mode
    /// that may always have had so little.
    pub threshold: T,
    /// What the sequential test says.
    pub evidence: Evidence<T>,
}

/// Memory of one mode.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ModeTrack<T> {
    frequency: T,
    smooth_damping: Option<(T, T)>,
    undamped_s: T,
    on_rotation: bool,
    damped_s: T,
    since_damped_s: T,
}

state! { ModeTrack<T> {
    frequency, smooth_damping, undamped_s, on_rotation, damped_s, since_damped_s
} }

impl<T: Real> Default for ModeTrack<T> {
    fn default() -> Self {
        Self {
            frequency: T::ZERO,
            smooth_damping: None,
            undamped_s: T::ZERO,
            on_rotation: false,
            damped_s: T::ZERO,
            since_damped_s: T::ZERO,
        }
    }
}

/// Each of two smoothings of ζ, whose difference is its gradient, s.
const GRADIENT_TAU_S: f64 = 0.1;
/// sd of the gradient over that of a reading, 1/s: √(τ_r/2τ)/τ for readings that are
/// correlated over τ_r = 0.1 s, the estimator's usual memory.
const GRADIENT_NOISE: f64 = 7.07;
/// A mode is damped for certain where ζ less two deviations lies above this many thresholds; what
/// was so for [`DAMPED_S`] loses its damping if it is undamped within [`LOST_S`], s.
const SURELY_DAMPED: f64 = 2.0;
const DAMPED_S: f64 = 1.0;
const LOST_S: f64 = 1.0;
/// A mode that jumps further than this (relative) is another one.
pub(crate) const SAME_MODE: f64 = 0.03;

impl<T: Real> ModeTrack<T> {
    /// The mode is where it was at the last decision.
    pub fn is_at(&self, frequency: T) -> bool {
        (frequency - self.frequency).abs() <= self.frequency * T::from_f64(SAME_MODE)
    }

    /// Begins anew if `frequency` is not where the mode was; says whether it did.
    pub fn follow(&mut self, frequency: T) -> bool {
        let jumped = !self.is_at(frequency);
        if jumped {
            self.reset();
        }
        self.frequency = frequency;
        jumped
    }

    /// At the last decision it sat on a multiple of the speed.
    pub fn was_on_rotation(&self) -> bool {
        self.on_rotation
    }

    /// Takes one reading. `config` says what is undamped and loud; `period_s` is the
    /// time since the last decision.
    pub fn update(
        &mut self,
        reading: &Reading<T>,
        config: &AlarmConfig<T>,
        period_s: T,
    ) -> Mode<T> {
        let own = AlarmConfig {
            threshold: reading.threshold,
            ..*config
        };
        let undamped = own.undamped(reading.damping);
        let loud = config.loud(reading.share, reading.share_of_all);
        let (damping, damping_sd) = reading.damping;
        self.remember_damping(damping, period_s);
        let (gradient, time_left_s) = self.outlook(damping_sd);
        let origin = reading.origin;
        self.on_rotation = origin == Origin::Rotation;

        // Suspicion grows as fast as the reading is sure, and goes as fast as it came:
        // one bad reading does not clear it.
        let credible = loud && reading.in_band;
        let evidence = if credible {
            own.evidence(reading.damping)
        } else {
            -T::ONE
        };
        let most = config.confirm_s * T::from_f64(1.5);
        self.undamped_s = (self.undamped_s + period_s * evidence).clamp(T::ZERO, most);
        let sequential = if credible && config.credible(damping) {
            reading.evidence.of_call()
        } else {
            T::ZERO
        };
        if origin.explains() {
            self.undamped_s = T::ZERO;
        }
        let certainty = (self.undamped_s / config.confirm_s).max(sequential);
        let suspicion = if origin.explains() {
            T::ZERO
        } else {
            certainty.min(T::ONE)
        };
        // A resonance with damping of its own is structural wherever it lies; only a
        // line is forced.
        let lightly_damped = config.may_be_line(reading.damping);
        let unknown = origin == Origin::Unknown && !reading.grew;
        let suspected = (undamped && credible) || suspicion >= T::ONE;
        Mode {
            frequency: reading.frequency.0,
            frequency_sd: reading.frequency.1,
            damping,
            damping_sd,
            amplitude: reading.amplitude,
            share: reading.share,
            share_of_all: reading.share_of_all,
            gradient,
            time_left_s,
            label: if origin.explains() && lightly_damped {
                Label::Forced
            } else if suspected && !origin.explains() {
                if unknown {
                    Label::Forced
                } else {
                    Label::SelfExcited
                }
            } else {
                Label::Structural
            },
            origin,
            harmonic: reading.harmonic.filter(|_| lightly_damped),
            suspicion,
            evidence: reading.evidence,
            was_damped: self.was_damped(reading.damping, config, period_s),
            grew: reading.grew,
        }
    }

    /// Damped for certain for long enough, and that until a moment ago.
    fn was_damped(&mut self, (damping, sd): (T, T), config: &AlarmConfig<T>, period_s: T) -> bool {
        let least = config.threshold * T::from_f64(SURELY_DAMPED);
        if damping - T::from_f64(2.0) * sd > least {
            self.damped_s = (self.damped_s + period_s).min(T::from_f64(2.0 * DAMPED_S));
            self.since_damped_s = T::ZERO;
        } else {
            self.since_damped_s += period_s;
        }
        if self.since_damped_s > T::from_f64(LOST_S) {
            self.damped_s = T::ZERO;
        }
        self.damped_s >= T::from_f64(DAMPED_S)
    }

    /// Smooths the readings twice, for their gradient.
    fn remember_damping(&mut self, damping: T, period_s: T) {
        let gain = (period_s / T::from_f64(GRADIENT_TAU_S)).min(T::ONE);
        if damping.is_finite() {
            let (first, second) = self.smooth_damping.unwrap_or((damping, damping));
            let first = first + gain * (damping - first);
            self.smooth_damping = Some((first, second + gain * (first - second)));
        }
    }

    /// dζ/dt, 1/s, and the time left at that rate, s. With g = (s₁ − s₂)/τ, s₁ the
    /// readings smoothed over τ and s₂ smoothed twice; sd(g) is [`GRADIENT_NOISE`] times that
    /// of a reading.
    fn outlook(&self, damping_sd: T) -> (T, Option<T>) {
        let Some((first, second)) = self.smooth_damping else {
            return (T::ZERO, None);
        };
        let gradient = (first - second) / T::from_f64(GRADIENT_TAU_S);
        let certain = -gradient > damping_sd * T::from_f64(2.0 * GRADIENT_NOISE);
        // s₁ is as old as τ.
        let now = first + gradient * T::from_f64(GRADIENT_TAU_S);
        let left = certain.then(|| (now / -gradient).max(T::ZERO));
        (gradient, left)
    }

    /// What made it suspect counts no longer.
    pub fn clear(&mut self) {
        self.undamped_s = T::ZERO;
    }

    /// Forgets the mode; its place is taken by another.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}
