//! A record as one line of JSON, and back.

use super::{MOST_LINE, Record, SCHEMA};
use serde::Deserialize;

/// Why a line is no record, or a record cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// Longer than [`MOST_LINE`].
    #[error("a line of {0} bytes: a record has at most 65536")]
    Long(usize),
    /// Not JSON, a field that is missing, or of another type.
    #[error("{0}")]
    Form(String),
    /// JSON that is no record at all: foreign.
    #[error(
        "no record: it has no field \"schema\" (records are made by `rarma gateway` and `rarma store add`)"
    )]
    Foreign,
    /// A later version.
    #[error(
        "schema {found}: this program knows up to {SCHEMA} (update it; the record was not touched)"
    )]
    Future {
        /// The version of the record.
        found: u64,
    },
    /// A number out of its range.
    #[error("the field \"{field}\" {why}")]
    Value {
        /// Which field.
        field: &'static str,
        /// What is wrong with it.
        why: &'static str,
    },
}

#[derive(Deserialize)]
struct Version {
    schema: Option<u64>,
}

/// Reads one line.
///
/// # Errors
/// [`RecordError`]: nothing is taken of a line that is not whole and right.
pub fn from_line(line: &str) -> Result<Record, RecordError> {
    if line.len() > MOST_LINE {
        return Err(RecordError::Long(line.len()));
    }
    // It repeats words of the line, which may hold anything.
    let one_line = |c: &char| !c.is_control();
    let form =
        |e: serde_json::Error| RecordError::Form(e.to_string().chars().filter(one_line).collect());
    // The version first: a record of a later one may look different in every other respect.
    let version: Version = serde_json::from_str(line).map_err(form)?;
    match version.schema {
        None => return Err(RecordError::Foreign),
        Some(found) if found > u64::from(SCHEMA) => return Err(RecordError::Future { found }),
        Some(_) => {}
    }
    let record: Record = serde_json::from_str(line).map_err(form)?;
    record.check()?;
    Ok(record)
}

/// Writes one line, without its end.
///
/// # Errors
/// [`RecordError::Value`] for a number that is none or out of range: JSON has no NaN.
pub fn to_line(record: &Record) -> Result<String, RecordError> {
    record.check()?;
    let line = serde_json::to_string(record).map_err(|e| RecordError::Form(e.to_string()))?;
    if line.len() > MOST_LINE {
        Err(RecordError::Long(line.len()))
    } else {
        Ok(line)
    }
}
