//! What goes wrong, as Python exceptions: what, where, why, and what to do.

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rarma_cli::Failure;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A failure of the library, in the words of Python: `--max-depth-mm` is `max_depth_mm` there,
/// and a signal in memory is no file.
pub fn exception(failure: impl Into<Failure>) -> PyErr {
    let failure = failure.into();
    let text = in_python(&failure.to_string());
    match failure {
        Failure::Usage(_) | Failure::Input(_) => PyValueError::new_err(text),
        Failure::System(_) | Failure::NoSound(_) | Failure::Gone(_) | Failure::Closed => {
            PyOSError::new_err(text)
        }
    }
}

/// Runs long work while other threads of Python go on. A panic, which is a defect of this
/// package, ends as an exception like any other.
pub fn detached<V: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<V, Failure> + Send,
) -> PyResult<V> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work)))
        .map_err(|panic| {
            let what = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no more is known");
            PyRuntimeError::new_err(format!(
                "the work broke off: {what} (a defect of rarma: please report it with the call that caused it, and go on with a new object)"
            ))
        })?
        .map_err(exception)
}

/// Options that have another name in Python, with their units.
const RENAMED: [(&str, &str); 11] = [
    ("at", "at_hz"),
    ("band", "band_hz"),
    ("every", "every_s"),
    ("fs", "sample_rate_hz"),
    ("idle", "idle_s"),
    ("max", "max_p"),
    ("reach", "reach_percent"),
    ("speed_from", "tell_speed"),
    ("swing", "swing_percent"),
    ("swing_acceleration", "swing_acceleration_rad_s2"),
    ("tacho", "tell_speed"),
];

/// An option of the command line, without its dashes, as Python calls it.
pub fn name_in_python(option: &str) -> String {
    let name = option.replace('-', "_");
    let renamed = RENAMED.iter().find(|(from, _)| *from == name);
    renamed.map_or(name, |(_, to)| (*to).to_owned())
}

/// A message of the command line in words of Python.
pub fn in_python(text: &str) -> String {
    let is_of_a_name = |c: char| c.is_ascii_alphanumeric() || c == '-';
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        let option = &option[2..];
        let end = option.find(|c| !is_of_a_name(c)).unwrap_or(option.len());
        out.push_str(before);
        match option[..end].starts_with(|c: char| c.is_ascii_lowercase()) {
            true => out.push_str(&name_in_python(&option[..end])),
            false => out.push_str(&rest[at..at + 2 + end]),
        }
        rest = &option[end..];
    }
    out.push_str(rest);
    out.replace("whole file", "whole signal")
}
