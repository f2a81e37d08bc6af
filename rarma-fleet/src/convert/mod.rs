//! The JSON of other commands to records: `ldbb`, `cers`, `els limit`, `monitor`, the log of `act`.
//!
//! Those objects name no machine, and but for the log no time: the caller does. Only the fields that are needed are read,
//! so that those commands may say more.

mod act;
mod monitor;
mod rigs;

use crate::record::{
    Body, Id, MOST_NUMBER, Name, NameError, Record, RecordError, SCHEMA, Utc, session_of_bytes,
};
use serde_json::Value;

/// What such a file does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Of which machine.
    pub machine: Name,
    /// When: of a recording its first sample, of a test its end. Not asked of a log, which tells it.
    pub time: Option<Utc>,
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
    #[error(
        "neither records nor the JSON of `ldbb`, `cers`, `els limit` or `monitor`, nor a log of `act`"
    )]
    Unknown,
    /// It does not say when it was, and nobody else does.
    #[error("it does not say when it was")]
    NoTime,
    /// A field is not there, or not of its type.
    #[error("{0} is missing, or not what it is elsewhere")]
    Field(String),
    /// A text that cannot be a name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A number of a record is none, or out of its range: a ratio to 0, or a sum beyond all numbers.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// There is nothing in it to keep.
    #[error("{0}")]
    Nothing(&'static str),
}

/// Records of what another command printed with `--json`, or of the log of `act`.
///
/// They are named by the content and by what `head` tells: the same file with the same machine and time gives
/// the same records, and is taken once. A log is named run by run, so that one that has grown gives the same records of
/// what was there before. Every record is sound ([`Record::check`]), or there is none.
///
/// # Errors
/// [`ConvertError`].
pub fn records(text: &str, head: &Head) -> Result<Vec<Record>, ConvertError> {
    let mut values = Vec::new();
    for value in serde_json::Deserializer::from_str(text).into_iter::<Value>() {
        values.push(value.map_err(|e| ConvertError::Json(e.to_string()))?);
    }
    let first = values.first().ok_or(ConvertError::Nothing("it is empty"))?;
    let all: Vec<Record> = if act::is_log(first) {
        let runs = act::runs(&values)?;
        let named = |run: &act::Run| format!("{}\n{} {}", run.name, head.machine, head.sender);
        let all = runs.into_iter().map(|run| (named(&run), run.said));
        let all = all.flat_map(|(named, said)| numbered(&named, said, head));
        all.collect()
    } else {
        let time = head.time.ok_or(ConvertError::NoTime)?;
        let named = format!("{text}\n{} {time} {}", head.machine, head.sender);
        numbered(&named, said(&values, time)?, head).collect()
    };
    all.iter().try_for_each(Record::check)?;
    Ok(all)
}

/// Records in the order in which they are said; their session is that of what names them.
fn numbered<'a>(
    named: &str,
    said: Vec<(Utc, Body)>,
    head: &'a Head,
) -> impl Iterator<Item = Record> + use<'a> {
    let session = session_of_bytes(named.as_bytes()).min(MOST_NUMBER);
    let record = move |(seq, (time, body)): (u64, (Utc, Body))| Record {
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
        // What those commands print does not hold all the settings.
        settings: None,
        firmware: Name::new(env!("CARGO_PKG_VERSION")).ok(),
        body,
    };
    (0..).zip(said).map(record)
}

/// What is said, and when.
fn said(values: &[Value], time: Utc) -> Result<Vec<(Utc, Body)>, ConvertError> {
    let last = &values[values.len() - 1];
    if last.get("summary").is_some() {
        return monitor::said(values, time);
    }
    let has = |names: &[&str]| names.iter().all(|name| last.get(name).is_some());
    let bodies = if has(&["findings", "radius_mm"]) {
        vec![rigs::stiffness(last)?]
    } else if has(&["principal_deg", "modes"]) {
        vec![rigs::modes(last)?]
    } else if last["sweep"]["tracks"].is_array() {
        rigs::sweep(&last["sweep"])?
    } else if has(&["ks_n_per_mm2", "polar"]) {
        vec![rigs::limits(last)?]
    } else {
        return Err(ConvertError::Unknown);
    };
    Ok(bodies.into_iter().map(|body| (time, body)).collect())
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
