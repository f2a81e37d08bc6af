//! What is known of a machine at one time, in the form in which it is sent and kept.
//!
//! One record is one line of JSON. All kinds have the same head: who made it ([`Id`]), of
//! which machine, when ([`Utc`], and the box's own clock), with which settings and firmware.
//! What is said stands in the [`Body`].
//!
//! **Identity.** A record is named by `box`, `session` and `seq`. `session` is the number that a
//! box draws when it starts, so that a box that counts from 0 again does not take old names;
//! `seq` counts in the session. Who makes a record of something that can be read twice (a frame in a
//! recording, a file) derives `session` and `seq` from it and not from the time of reading: then the
//! same thing gives the same name, and a store takes it once, whatever way it came and in whatever
//! order.
//!
//! **Versions.** [`SCHEMA`] is the version of the whole form. A new field that may be left out does
//! not raise it: who does not know the field passes over it, and a store keeps the line as it came.
//! A new kind, or a field that changes its meaning, raises it. A line of a higher version is refused by
//! its number ([`RecordError::Future`]), never half understood.

mod body;
mod capability;
mod check;
mod line;
mod name;
mod reading;
mod time;

pub use body::{Advice, AlarmCalled, AlarmReleased, Body, Kind, Mode, Outcome, Speed, Verdict};
pub use capability::{
    DirectionLimit, DirectionStiffness, Hysteresis, Limits, MachineError, Modes, OdrStatistics,
    Stiffness, StructuralMode,
};
pub use line::{RecordError, from_line, to_line};
pub use name::{Name, NameError};
pub use rarma_core::decide::{Label, State};
pub use reading::{Quantity, Reading};
pub(crate) use time::DAY_US;
pub use time::{Clock, TimeError, Utc};

use serde::{Deserialize, Serialize};

/// Version of the form of a record. A record of a higher one is refused.
pub const SCHEMA: u32 = 1;

/// Largest `session` and `seq`: what every reader of JSON holds exactly, 2⁵³ − 1.
pub const MOST_NUMBER: u64 = (1 << 53) - 1;

/// Longest line of a record, bytes.
pub const MOST_LINE: usize = 64 * 1024;

/// The name of a record: the same name is the same record. Sorted by it, the records of a
/// session stand in the order in which they were made.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Id {
    /// Who made it: a box; or of a test without a box, what stands in for one.
    #[serde(rename = "box")]
    pub sender: Name,
    /// Which run of the box: the number it draws when it starts. At most [`MOST_NUMBER`].
    pub session: u64,
    /// Number in the session. At most [`MOST_NUMBER`].
    pub seq: u64,
}

/// One record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of the form; [`SCHEMA`] in a new record.
    pub schema: u32,
    /// Name of the record.
    #[serde(flatten)]
    pub id: Id,
    /// Of which machine.
    pub machine: Name,
    /// When it was so, UTC.
    pub time: Utc,
    /// What the box's own clock said then; none where a person or a file told the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<Clock>,
    /// Tool in the spindle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<Name>,
    /// Who ran the machine. A pseudonym does as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<Name>,
    /// Hash of the settings that were in force ([`settings_hash`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<Name>,
    /// Version of the firmware, or of the program that evaluated the test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<Name>,
    /// What is said: `kind`, and `body`.
    #[serde(flatten)]
    pub body: Body,
}

/// Hash of settings: the first 16 hexadecimal digits of the SHA-256 of their bytes. Two records
/// with the same hash were made with the same settings.
///
/// # Panics
/// Never: 16 digits are a name.
#[must_use]
pub fn settings_hash(settings: &[u8]) -> Name {
    Name::new(&hex(settings)[..16]).expect("digits are a name")
}

/// A `session` for records of a file: 52 bits of the SHA-256 of its bytes, and not 0. The same
/// file gives the same records.
#[must_use]
pub fn session_of_bytes(bytes: &[u8]) -> u64 {
    u64::from_str_radix(&hex(bytes)[..13], 16)
        .unwrap_or(1)
        .max(1)
}

fn hex(bytes: &[u8]) -> String {
    use sha2::Digest as _;
    use std::fmt::Write as _;
    let mut text = String::with_capacity(64);
    for byte in sha2::Sha256::digest(bytes) {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests;
