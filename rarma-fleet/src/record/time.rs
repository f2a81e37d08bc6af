//! When: UTC to the microsecond, and a box's own clock beside it.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A time in UTC, microseconds since 1970 without leap seconds. Written as
/// `2026-03-01T12:00:00.123456Z`; read with any offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Utc(i64);

/// 2000-01-01 and 2200-01-01: a time outside is a clock that was never set.
const RANGE_US: std::ops::Range<i64> = 946_684_800_000_000..7_258_118_400_000_000;

/// A day, µs.
pub(crate) const DAY_US: i64 = 86_400_000_000;

/// Why a text or a number is no time.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TimeError {
    /// Not a date with a time and an offset.
    #[error("{0:?} is no time (write 2026-03-01T12:00:00Z)")]
    Form(String),
    /// A clock that was never set.
    #[error("the time {0} lies before 2000 or after 2200: the clock was never set")]
    NeverSet(String),
}

impl Utc {
    /// Of microseconds since 1970.
    ///
    /// # Errors
    /// [`TimeError::NeverSet`] outside of 2000 to 2200.
    pub fn from_micros(us: i64) -> Result<Self, TimeError> {
        if RANGE_US.contains(&us) {
            Ok(Self(us))
        } else {
            let said = Timestamp::from_microsecond(us).map_or(us.to_string(), |t| t.to_string());
            Err(TimeError::NeverSet(said))
        }
    }

    /// The time it is, of this computer's clock.
    ///
    /// # Errors
    /// [`TimeError::NeverSet`] where that clock was never set.
    pub fn now() -> Result<Self, TimeError> {
        Self::from_micros(Timestamp::now().as_microsecond())
    }

    /// Microseconds since 1970.
    #[must_use]
    pub fn micros(self) -> i64 {
        self.0
    }

    /// Whole days since 1970, UTC.
    #[must_use]
    pub fn day(self) -> i64 {
        self.0.div_euclid(DAY_US)
    }

    /// The month as a number, UTC: 202603 is March 2026.
    #[must_use]
    pub fn month(self) -> i64 {
        Timestamp::from_microsecond(self.0).map_or(0, |stamp| {
            let date = stamp.to_zoned(jiff::tz::TimeZone::UTC).date();
            i64::from(date.year()) * 100 + i64::from(date.month())
        })
    }

    /// So many seconds later (or earlier); held at 2000 and 2200.
    #[must_use]
    pub fn plus_s(self, seconds: f64) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "saturates, and is held in range"
        )]
        let us = (seconds * 1e6).round() as i64;
        Self(
            self.0
                .saturating_add(us)
                .clamp(RANGE_US.start, RANGE_US.end - 1),
        )
    }

    /// Seconds from another time to this one.
    #[must_use]
    #[allow(
        clippy::cast_precision_loss,
        reason = "to a microsecond over 200 years"
    )]
    pub fn since_s(self, earlier: Self) -> f64 {
        (self.0 - earlier.0) as f64 * 1e-6
    }
}

impl std::str::FromStr for Utc {
    type Err = TimeError;

    fn from_str(text: &str) -> Result<Self, TimeError> {
        let stamp: Timestamp = text.parse().map_err(|_| TimeError::Form(text.to_owned()))?;
        Self::from_micros(stamp.as_microsecond())
    }
}

impl TryFrom<String> for Utc {
    type Error = TimeError;

    fn try_from(text: String) -> Result<Self, TimeError> {
        text.parse()
    }
}

impl From<Utc> for String {
    fn from(time: Utc) -> Self {
        time.to_string()
    }
}

impl fmt::Display for Utc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Timestamp::from_microsecond(self.0) {
            Ok(stamp) => write!(f, "{stamp:.6}"),
            Err(_) => write!(f, "{} us", self.0),
        }
    }
}

/// A box's own clock at the time of a record. A box knows no UTC: the gateway compares the two as
/// records come, and says here what it found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// The box's clock, s since its start.
    pub box_s: f64,
    /// How much faster the box's clock runs than UTC, millionths; none while too little was heard
    /// to tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_ppm: Option<f64>,
    /// Standard deviation of that, millionths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_sd_ppm: Option<f64>,
    /// Standard deviation of the record's `time`, s; none where it was not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_sd_s: Option<f64>,
}
