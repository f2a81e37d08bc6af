//! What may be ordered.

use core::fmt;

/// An override may lie between these, whatever is set: wider than any controller's own range.
const OVERRIDES: (f64, f64) = (0.1, 2.0);
/// See [`ActConfig::rate_per_s`].
const RATE_PER_S: f64 = 0.5;
/// See [`ActConfig::tries`].
const TRIES: u32 = 3;

/// What may be ordered. It stands for the whole run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActConfig {
    /// Orders are given; else it is only said what would be ordered.
    pub act: bool,
    /// The smallest override that may be ordered, 0.1 or more.
    pub least: f64,
    /// The largest, above the smallest, 2 at most. 1 lies between them: what is programmed is
    /// always allowed.
    pub most: f64,
    /// The override changes by so much a second at most, 0.05 to 5, usually 0.5: a speed 10 %
    /// off is there after 0.2 s. Half chatters for longer; double asks a spindle of 10 000 1/min
    /// for more than the 5000 1/min in a second that usual drives give.
    pub rate_per_s: f64,
    /// Speeds that are tried one after the other in one program, 1 to 10, usually 3: of random
    /// cuts with a pocket six in ten are stable at the first, seven at the third.
    pub tries: u32,
    /// The feed is ordered with the speed, so that the feed of a tooth stays.
    pub keeps_feed: bool,
}

impl ActConfig {
    /// These limits, and all else as usual.
    pub fn limits(act: bool, least: f64, most: f64) -> Self {
        Self {
            act,
            least,
            most,
            rate_per_s: RATE_PER_S,
            tries: TRIES,
            keeps_feed: true,
        }
    }

    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), ActError> {
        let check = |ok: bool, error| if ok { Ok(()) } else { Err(error) };
        check(
            self.least >= OVERRIDES.0
                && self.least <= 1.0
                && self.most >= 1.0
                && self.most <= OVERRIDES.1
                && self.least < self.most,
            ActError::Limits,
        )?;
        check(
            self.rate_per_s >= 0.05 && self.rate_per_s <= 5.0,
            ActError::Rate,
        )?;
        check((1..=10).contains(&self.tries), ActError::Tries)
    }

    /// Whether this override may be ordered; NaN may not.
    pub(super) fn allows(&self, spindle: f64) -> bool {
        spindle >= self.least && spindle <= self.most
    }
}

/// Why nothing can be ordered with these settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ActError {
    /// The limits must lie in 0.1..=2 and hold 1 between them.
    Limits,
    /// The rate must lie in 0.05..=5 a second.
    Rate,
    /// Tries must be 1..=10.
    Tries,
}

impl fmt::Display for ActError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Limits => "the limits of the override must lie in 10 to 200 % and hold 100 %",
            Self::Rate => "the override may change by 5 to 500 % a second",
            Self::Tries => "tries must be 1 to 10",
        })
    }
}
