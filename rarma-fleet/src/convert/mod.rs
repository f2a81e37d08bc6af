//! The JSON of other commands to records: `ldbb`, `cers`, `els limit`, `monitor`.
//!
//! Those objects name neither machine nor time: the caller does. Only the fields that are needed are read,
//! so that those commands may say more.

mod monitor;
mod rigs;

use crate::record::{
    Body, Id, MOST_NUMBER, Name, NameError, Record, SCHEMA, Utc, session_of_bytes,
};
use serde_json::Value;

/// What such a file does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Of which machine.
    pub machine: Name,
    /// When: of a recording its first sample, of a test its end.
    pub time: Utc,
    /// Who says so: the `box` of the records.
    pub sender: Name,
    /// Tool.
    pub tool: Option<Name>,
    /// Operator.
    pub operator: Option<Name>,
}

/// Why nothing was made of it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ConvertError {
    /// Not JSON.
    #[error("not JSON: {0}")]
    Json(String),
    /// JSON of something else.
    #[error("neither records nor the JSON of `ldbb`, `cers`, `els limit` or `monitor`")]
    Unknown,
    /// A field is not there, or not of its type.
    #[error("{0} is missing, or not what it is elsewhere")]
    Field(String),
    /// A text that cannot be a name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// There is nothing in it to keep.
    #[error("{0}")]
    Nothing(&'static str),
}

/// Records of what another command printed with `--json`.
///
/// They are named by the content and by what `head` tells: the same file with the same machine and time gives
/// the same records, and is taken once.
///
/// # Errors
/// [`ConvertError`].
pub fn records(text: &str, head: &Head) -> Result<Vec<Record>, ConvertError> {
    let said = said(text, head)?;
    let named = format!("{text}\n{} {} {}", head.machine, head.time, head.sender);
    let session = session_of_bytes(named.as_bytes()).min(MOST_NUMBER);
    let record = |(seq, (time, body)): (u64, (Utc, Body))| Record {
        schema: SCHEMA,
        id: Id {
            sender: head.sender.clone(),
            session,
            seq,
        },
        machine: head.machine.clone(),
        time,
        clock: None,
        tool: head.tool.clone(),
        operator: head.operator.clone(),
        settings: None,
        firmware: Name::new(env!("CARGO_PKG_VERSION")).ok(),
        body,
    };
    Ok((0..).zip(said).map(record).collect())
}

/// What is said, and when.
fn said(text: &str, head: &Head) -> Result<Vec<(Utc, Body)>, ConvertError> {
    let mut values = Vec::new();
    for value in serde_json::Deserializer::from_str(text).into_iter::<Value>() {
        values.push(value.map_err(|e| ConvertError::Json(e.to_string()))?);
    }
    let last = values.last().ok_or(ConvertError::Nothing("it is empty"))?;
    if last.get("summary").is_some() {
        return monitor::said(&values, head.time);
    }
    let has = |names: &[&str]| names.iter().all(|name| last.get(name).is_some());
    let body = if has(&["findings", "radius_mm"]) {
        rigs::stiffness(last)?
    } else if has(&["principal_deg", "modes"]) {
        rigs::modes(last)?
    } else if has(&["ks_n_per_mm2", "polar"]) {
        rigs::limits(last)?
    } else {
        return Err(ConvertError::Unknown);
    };
    Ok(vec![(head.time, body)])
}

/// A number of an object.
fn number(value: &Value, name: &str) -> Result<f64, ConvertError> {
    value
        .get(name)
        .and_then(Value::as_f64)
        .ok_or_else(|| ConvertError::Field(name.to_owned()))
}

/// A list of an object.
fn list<'a>(value: &'a Value, name: &str) -> Result<&'a [Value], ConvertError> {
    let list = value.get(name).and_then(Value::as_array);
    list.map(Vec::as_slice)
        .ok_or_else(|| ConvertError::Field(name.to_owned()))
}

/// A text of an object.
fn text<'a>(value: &'a Value, name: &str) -> Result<&'a str, ConvertError> {
    value
        .get(name)
        .and_then(Value::as_str)
        .ok_or_else(|| ConvertError::Field(name.to_owned()))
}

#[cfg(test)]
mod convert_tests;
