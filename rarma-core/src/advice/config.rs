//! What may be turned, and how sure advice must be.

use crate::real::Real;
use core::fmt;

/// The most that the largest speed of the reach may be over the smallest: beyond it the grid of
/// speeds would be coarser than half a percent.
pub const MOST_REACH: f64 = 4.0;
/// Usual [`AdviceConfig::least_chance`].
const LEAST_CHANCE: f64 = 0.2;
/// Usual [`AdviceConfig::hold`].
const HOLD: f64 = 0.01;

/// What may be turned, and how sure advice must be. It takes effect with the next question.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdviceConfig<T> {
    /// Least speed within reach, turns a second, > 0.
    pub least_hz: T,
    /// Largest, turns a second; above the least, at most [`MOST_REACH`] times it.
    pub most_hz: T,
    /// Power that the spindle can give over what it gives now, > 0; `None`: no limit. It
    /// matters only with `keeps_feed`: then the power grows as the speed does.
    pub most_power: Option<T>,
    /// The feed is changed with the speed, so that the feed of a tooth stays.
    pub keeps_feed: bool,
    /// Chance of being stable from which on a speed is proposed, 0.05 to 0.95, usually 0.2:
    /// a try costs little. On random machines, stable first proposals where there is a pocket
    /// and "none" where there is none, with a structure: 0.77 and 0.82; at 0.15 0.80 and 0.76,
    /// at 0.3 0.69 and 0.90.
    pub least_chance: T,
    /// A proposed speed must be good this far up and down, as a part of it, 0 to 0.05, usually
    /// 0.01: what a told speed is worth, and a step of an override. Half finds thinner pockets
    /// and more that are none; double loses those at many waves.
    pub hold: T,
}

impl<T: Real> AdviceConfig<T> {
    /// A reach, and all else as usual: feed of a tooth kept, no limit of power.
    pub fn reach(least_hz: T, most_hz: T) -> Self {
        Self {
            least_hz,
            most_hz,
            most_power: None,
            keeps_feed: true,
            least_chance: T::from_f64(LEAST_CHANCE),
            hold: T::from_f64(HOLD),
        }
    }

    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), AdviceError> {
        let positive = |x: T| x > T::ZERO && x.is_finite();
        let check = |ok: bool, error| if ok { Ok(()) } else { Err(error) };
        check(
            positive(self.least_hz)
                && self.most_hz > self.least_hz
                && self.most_hz <= self.least_hz * T::from_f64(MOST_REACH * 1.0001),
            AdviceError::Reach,
        )?;
        check(self.most_power.is_none_or(positive), AdviceError::Power)?;
        let within = |x: T, low: f64, high: f64| x >= T::from_f64(low) && x <= T::from_f64(high);
        check(within(self.least_chance, 0.049, 0.951), AdviceError::Chance)?;
        check(within(self.hold, 0.0, 0.0501), AdviceError::Hold)
    }

    /// The largest speed that reach and power allow, turns a second, from a present one.
    pub(super) fn top_hz(&self, spindle_hz: T) -> T {
        match self.most_power {
            Some(power) if self.keeps_feed => self.most_hz.min(power * spindle_hz),
            _ => self.most_hz,
        }
    }
}

/// Why there is no advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AdviceError {
    /// The reach must rise from above 0, by at most [`MOST_REACH`] times, and the power leave
    /// some of it.
    Reach,
    /// The power must be above 0.
    Power,
    /// The chance must lie in 0.05..=0.95.
    Chance,
    /// The hold must lie in 0..=0.05.
    Hold,
    /// The chatter's frequency must be above 0 Hz.
    Frequency,
    /// Standard deviations must be 0 or more.
    Deviation,
    /// Speeds must be above 0.
    Speed,
    /// Teeth must be 1..=1000.
    Teeth,
    /// Depths of known cuts must be above 0.
    Depth,
    /// The swing's amplitude must lie in 0.01..=0.5, its acceleration and frequency be above 0.
    Variation,
}

impl fmt::Display for AdviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reach => "the reach must rise from above 0, by at most 4 times, and the power leave some of it",
            Self::Power => "the power must be above 0",
            Self::Chance => "the least chance must lie in 0.05..=0.95",
            Self::Hold => "the hold must lie in 0..=0.05",
            Self::Frequency => "the chatter's frequency must be above 0 Hz",
            Self::Deviation => "standard deviations must be 0 or more",
            Self::Speed => "speeds must be above 0",
            Self::Teeth => "teeth must be 1..=1000",
            Self::Depth => "depths of known cuts must be above 0",
            Self::Variation => "the swing's amplitude must lie in 0.01..=0.5, its acceleration and frequency be above 0",
        })
    }
}
