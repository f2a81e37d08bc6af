//! Named tuples of the Python part of the package (`rarma/_results.py`).

use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A tuple of that name.
pub fn make<'py>(
    py: Python<'py>,
    name: &str,
    fields: Bound<'py, PyTuple>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import("rarma._results")?.getattr(name)?.call1(fields)
}
