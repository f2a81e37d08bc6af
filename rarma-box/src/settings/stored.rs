//! One setting as a record in flash.
//!
//! Version of the setting's meaning, kind, then four bytes of value, or the 32 of a key. A
//! setting that was reset is stored as "not set": it follows its default when that changes.
//! The store guards a record with its own CRC; that is no check of meaning, so version, kind
//! and range are checked here.

use super::value::{Setting, SettingError, SettingValue};
use crate::key::{KEY_BYTES, LinkKey};
use heapless::Vec;

/// Most bytes of a record.
pub const RECORD_BYTES: usize = 2 + KEY_BYTES;
const REAL: u8 = 1;
const WHOLE: u8 = 2;
const KEY: u8 = 3;
const NOT_SET: u8 = 0;

/// Why a record is not read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecordError {
    /// Of another length than its kind's, or of no kind.
    Form,
    /// Written when the setting meant something else.
    Outdated {
        /// Version in the record.
        found: u8,
    },
    /// Out of range or of the other kind.
    Value(SettingError),
}

/// The record of a value; of "not set" if none.
pub fn to_record(setting: &Setting, value: Option<SettingValue>) -> Vec<u8, RECORD_BYTES> {
    let (kind, [a, b, c, d]) = match value {
        Some(SettingValue::Real(x)) => (REAL, x.to_le_bytes()),
        Some(SettingValue::Whole(n)) => (WHOLE, n.to_le_bytes()),
        Some(SettingValue::Key(LinkKey(key))) => {
            let mut record = Vec::new();
            // The longest record has room for a key.
            let _ = record.extend_from_slice(&[setting.version, KEY]);
            let _ = record.extend_from_slice(&key);
            return record;
        }
        None | Some(SettingValue::Hidden(_)) => (NOT_SET, [0; 4]),
    };
    let mut record = Vec::new();
    let _ = record.extend_from_slice(&[setting.version, kind, a, b, c, d]);
    record
}

/// The value of a record; none if it says "not set".
///
/// # Errors
/// See [`RecordError`]; the default stays in force then.
pub fn from_record(setting: &Setting, record: &[u8]) -> Result<Option<SettingValue>, RecordError> {
    let &[version, kind, ref value @ ..] = record else {
        return Err(RecordError::Form);
    };
    if version != setting.version {
        return Err(RecordError::Outdated { found: version });
    }
    let form = RecordError::Form;
    let word = || value.try_into().map_err(|_| form);
    let value = match kind {
        NOT_SET => return word().map(|_: [u8; 4]| None),
        REAL => SettingValue::Real(f32::from_le_bytes(word()?)),
        WHOLE => SettingValue::Whole(u32::from_le_bytes(word()?)),
        KEY => SettingValue::Key(LinkKey(value.try_into().map_err(|_| form)?)),
        _ => return Err(form),
    };
    setting.check(value).map_err(RecordError::Value)?;
    Ok(Some(value))
}
