//! Arguments of Python as those of the command, whose own parser knows what is allowed.

use crate::error::{in_python, name_in_python};
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use rarma_cli::args::{Cli, Command};
use std::error::Error;
use std::fmt::Display;

/// What messages call a signal that was passed in.
pub const SIGNAL: &str = "x";

/// A command line in the making.
pub struct Line(Vec<String>);

impl Line {
    /// A command and what comes before its options.
    pub fn new(command: &str, input: &str) -> Self {
        Self(["rarma", command, input].map(str::to_owned).to_vec())
    }

    /// One that was made before.
    pub fn of_words(words: Vec<String>) -> Self {
        Self(words)
    }

    /// Its words.
    pub fn words(&self) -> &[String] {
        &self.0
    }

    /// A command over a signal of this rate.
    pub fn of_signal(command: &str, sample_rate_hz: f64) -> Self {
        Self::new(command, SIGNAL).with("fs", sample_rate_hz)
    }

    /// An option.
    pub fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0.push(format!("--{name}={value}"));
        self
    }

    /// An option, if there is a value.
    pub fn with_some(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// Two numbers.
    pub fn with_pair(self, name: &str, pair: Option<(f64, f64)>) -> Self {
        self.with_some(name, pair.map(|(a, b)| format!("{a}:{b}")))
    }

    /// A switch.
    pub fn with_flag(mut self, name: &str, is: bool) -> Self {
        if is {
            self.0.push(format!("--{name}"));
        }
        self
    }

    /// An order (p, q).
    pub fn with_order(self, order: Option<(i64, i64)>) -> Self {
        self.with_some("order", order.map(|(p, q)| format!("{p},{q}")))
    }

    /// A band: (low, high) in Hz, or "full".
    pub fn with_band(self, band: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(band) = band else {
            return Ok(self);
        };
        if let Ok((low, high)) = band.extract::<(f64, f64)>() {
            return Ok(self.with("band", format!("{low}:{high}")));
        }
        match band.extract::<String>() {
            Ok(word) => Ok(self.with("band", word)),
            Err(_) => Err(PyTypeError::new_err(format!(
                "band_hz: {} is no band (pass two numbers in Hz, such as (300, 2500), or \"full\")",
                band.repr()?
            ))),
        }
    }

    /// What the command's own parser makes of it.
    ///
    /// # Errors
    /// ValueError: which argument, its value, and what is allowed.
    pub fn parse(self) -> PyResult<Command> {
        Cli::try_parse_from(self.0)
            .map(|cli| cli.command)
            .map_err(|why| refused(&why))
    }
}

/// The same of another command: a defect of this package.
pub fn other_command() -> PyErr {
    PyRuntimeError::new_err("the arguments became another command: a defect of rarma")
}

fn refused(why: &clap::Error) -> PyErr {
    let context = |kind| match why.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(all)) => Some(all.join(", ")),
        _ => None,
    };
    let argument = context(ContextKind::InvalidArg).unwrap_or_default();
    let name = argument.trim_start_matches('-');
    let name = name_in_python(name.split([' ', '=']).next().unwrap_or_default());
    let value = context(ContextKind::InvalidValue).unwrap_or_default();
    PyValueError::new_err(match (why.kind(), why.source()) {
        (ErrorKind::ValueValidation, Some(what)) => {
            format!("{name}: {value}: {}", in_python(&what.to_string()))
        }
        (ErrorKind::InvalidValue, _) => {
            let valid = context(ContextKind::ValidValue).unwrap_or_default();
            format!("{name}: {value:?} is none of {valid}")
        }
        _ => {
            let text = why.to_string();
            in_python(text.lines().next().unwrap_or_default())
        }
    })
}
