//! `decode`: what a sensor box sent.

use crate::error::detached;
use crate::json::from_value;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rarma_cli::frames::Teller;
use rarma_recordings::FrameReader;
use serde_json::Value;

/// Decodes frames of a sensor box: `rarma decode`.
///
/// Parameters
/// ----------
/// data : bytes
///     What the box sent, or the content of a record (.frames). Frames that are broken or cut off
///     are passed over.
///
/// Returns
/// -------
/// list of dict
///     A message each, as the lines of `rarma decode --json`: session, sequence and message, a
///     dict with the message's name as its one key; advice where an alarm is called and speed and
///     teeth are known.
///
/// Raises
/// ------
/// ValueError
///     There is no whole frame in it.
#[pyfunction]
pub fn decode<'py>(py: Python<'py>, data: &[u8]) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (messages, losses) = detached(py, || {
        let mut reader = FrameReader::default();
        let mut teller = Teller::default();
        let mut messages: Vec<Value> = Vec::new();
        reader.take(data, |head, message| {
            messages.extend(serde_json::from_str::<Value>(&teller.json(head, &message)));
        });
        Ok((messages, reader.losses()))
    })?;
    if messages.is_empty() {
        let losses = losses.map_or(String::new(), |losses| format!(": {losses}"));
        return Err(PyValueError::new_err(format!(
            "data: {} bytes without a whole frame{losses} (is it what a box sent?)",
            data.len()
        )));
    }
    messages.iter().map(|m| from_value(py, m)).collect()
}
