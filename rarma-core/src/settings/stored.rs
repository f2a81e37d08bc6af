//! One setting as a record in flash.
//!
//! Six bytes: version of the setting's meaning, kind, four bytes of value. A setting that
//! was reset is stored as "not set": it follows its default when that changes. The store
//! guards a record with its own CRC; that is no check of meaning, so version, kind and
//! range are checked here.

use super::value::{Setting, SettingError, SettingValue};

/// Bytes of a record.
pub const RECORD_BYTES: usize = 6;
const REAL: u8 = 1;
const WHOLE: u8 = 2;
const NOT_SET: u8 = 0;

/// Why a record is not read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecordError {
    /// Not six bytes, or of no kind.
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
pub fn to_record(setting: &Setting, value: Option<SettingValue>) -> [u8; RECORD_BYTES] {
    let (kind, [a, b, c, d]) = match value {
        None => (NOT_SET, [0; 4]),
        Some(SettingValue::Real(x)) => (REAL, x.to_le_bytes()),
        Some(SettingValue::Whole(n)) => (WHOLE, n.to_le_bytes()),
    };
    [setting.version, kind, a, b, c, d]
}

/// The value of a record; none if it says "not set".
///
/// # Errors
/// See [`RecordError`]; the default stays in force then.
pub fn from_record(setting: &Setting, record: &[u8]) -> Result<Option<SettingValue>, RecordError> {
    let &[version, kind, a, b, c, d] = record else {
        return Err(RecordError::Form);
    };
    if version != setting.version {
        return Err(RecordError::Outdated { found: version });
    }
    let value = match kind {
        NOT_SET => return Ok(None),
        REAL => SettingValue::Real(f32::from_le_bytes([a, b, c, d])),
        WHOLE => SettingValue::Whole(u32::from_le_bytes([a, b, c, d])),
        _ => return Err(RecordError::Form),
    };
    setting.check(value).map_err(RecordError::Value)?;
    Ok(Some(value))
}
