//! Settings of a recursive model, checked.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyInt;
use rarma_core::estimate::{ConfigError, Gain, Gradient, RarmaConfig};

/// Settings by their names in Python.
pub struct Settings {
    pub forgetting: f64,
    pub random_walk: f64,
    pub method: String,
    pub start_samples: u32,
}

impl Settings {
    /// As the core has them.
    ///
    /// # Errors
    /// ValueError: which is out of range.
    pub fn config(&self) -> PyResult<RarmaConfig<f64>> {
        let refused = |what: String| Err(PyValueError::new_err(what));
        let gradient = match self.method.as_str() {
            "rplr" => Gradient::Pseudo,
            _ => Gradient::Filtered,
        };
        let gain = match self.method.as_str() {
            "rpem" | "rplr" => Gain::Covariance,
            "gradient" => Gain::normalised(),
            other => {
                return refused(format!("method: {other:?} is none of rpem, rplr, gradient"));
            }
        };
        let config = RarmaConfig {
            gradient,
            gain,
            forgetting: self.forgetting,
            random_walk: self.random_walk,
            start_samples: self.start_samples,
            ..RarmaConfig::default()
        };
        config.checked().or_else(|why| {
            refused(match why {
                ConfigError::Forgetting => {
                    format!(
                        "forgetting: {}: must lie between 0.9 and 1",
                        self.forgetting
                    )
                }
                ConfigError::RandomWalk => {
                    format!(
                        "random_walk: {}: must lie between 0 and 0.01",
                        self.random_walk
                    )
                }
                _ => format!(
                    "forgetting: {}, random_walk: {}: both must be finite",
                    self.forgetting, self.random_walk
                ),
            })
        })
    }
}

/// A whole number from 0 to `most`; `name` is what messages call it.
///
/// # Errors
/// TypeError for what is no whole number, ValueError for one out of range.
pub fn whole(name: &str, n: &Bound<'_, PyAny>, most: usize) -> PyResult<usize> {
    let is_integer = n.is_instance_of::<PyInt>() || n.hasattr("__index__")?;
    if !is_integer {
        return Err(PyTypeError::new_err(format!(
            "{name}: {} is no whole number (pass an int)",
            n.repr()?
        )));
    }
    let fits = n.extract::<usize>().ok().filter(|n| *n <= most);
    fits.ok_or_else(|| PyValueError::new_err(format!("{name}: {n}: must lie between 0 and {most}")))
}
