//! Several channels at once: `identify_channels`.

use crate::array::Signal;
use crate::error::detached;
use crate::json::to_python;
use crate::options::{Line, SIGNAL, other_command};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PySlice;
use rarma_cli::args::Command;
use rarma_cli::commands;
use rarma_recordings::input::{self, Recording};

/// Columns of an array of two dimensions.
///
/// # Errors
/// TypeError for what is no array; ValueError where it has no columns, or not two dimensions.
pub fn width(x: &Bound<'_, PyAny>) -> PyResult<usize> {
    let Ok(array) = x.cast::<PyUntypedArray>() else {
        return Err(PyTypeError::new_err(format!(
            "{SIGNAL}: {} is no numpy array (pass numpy.asarray({SIGNAL}, dtype=float))",
            x.get_type().name()?
        )));
    };
    if array.ndim() != 2 || array.shape()[1] == 0 {
        return Err(PyValueError::new_err(format!(
            "{SIGNAL}: shape {} is not that of channels, (n, channels) (pass numpy.column_stack of them)",
            array.getattr("shape")?
        )));
    }
    Ok(array.shape()[1])
}

/// One of them, borrowed, and what messages call it.
///
/// # Errors
/// As [`Signal::of`].
pub fn column<'py>(x: &Bound<'py, PyAny>, channel: usize) -> PyResult<(String, Signal<'py>)> {
    let name = format!("{SIGNAL}[:, {channel}]");
    let signal = Signal::of(&name, &x.get_item((PySlice::full(x.py()), channel))?)?;
    Ok((name, signal))
}

/// The columns of an array of two dimensions, as recordings.
fn columns(x: &Bound<'_, PyAny>, sample_rate_hz: f64) -> PyResult<Vec<Recording>> {
    let channels = width(x)?;
    (0..channels)
        .map(|channel| {
            let (name, signal) = column(x, channel)?;
            let samples = signal.samples().to_vec();
            let mut recording = Recording::in_memory(&name, samples, sample_rate_hz);
            (recording.channel, recording.channels) = (channel, channels);
            Ok(recording)
        })
        .collect()
}

/// Finds modes and mode shapes from several sensors at once: `rarma identify --channels`.
///
/// Covariance-driven stochastic subspace identification, with standard deviations of first order
/// from what each stretch of the record says otherwise than the whole (Döhler and Mevel, 2013).
///
/// Parameters
/// ----------
/// x : numpy array of float64 or float32, shape (n, channels)
///     Samples, each channel in any unit.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// order : int
///     States, two for each mode.
/// references : sequence of int, optional
///     Columns that the others are correlated with. Default: all.
/// rows : int
///     Block rows of the matrix of covariances, 2 to 200: lags 1 to 2·rows - 1 are used.
/// stretches : int
///     Stretches that the record is cut into for the deviations, 10 to 1000.
/// band_hz, detrend
///     As for `identify`.
///
/// Returns
/// -------
/// dict
///     method, order, channels, references, rows, stretches, band, fs (Hz), n, modes (list of
///     dicts: f, f_sd in Hz; zeta, zeta_sd as ratios; stable_f, stable and mac against the model of
///     two states less; shape, one dict for each channel: re, im, magnitude, magnitude_sd,
///     phase_deg, phase_deg_sd, the largest channel being 1), orders (the modes of 2, 4 and so on
///     states, without shapes), singular_values.
///
/// Raises
/// ------
/// TypeError, ValueError
///     As `identify`.
#[pyfunction]
#[pyo3(signature = (x, sample_rate_hz, order, *, references=None, rows=20, stretches=100, band_hz=None, detrend="mean"))]
#[allow(clippy::too_many_arguments, reason = "they have names in Python")]
pub fn identify_channels<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    sample_rate_hz: f64,
    order: i64,
    references: Option<Vec<i64>>,
    rows: i64,
    stretches: i64,
    band_hz: Option<&Bound<'py, PyAny>>,
    detrend: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let mut recordings = columns(x, sample_rate_hz)?;
    let references = references.map(|list| {
        let words: Vec<String> = list.iter().map(i64::to_string).collect();
        words.join(",")
    });
    let line = Line::of_signal("identify", sample_rate_hz)
        .with("channels", "all")
        .with_order(Some((order, 0)))
        .with_some("references", references)
        .with("rows", rows)
        .with("stretches", stretches)
        .with_band(band_hz)?
        .with("detrend", detrend);
    let Command::Identify(args) = line.parse()? else {
        return Err(other_command());
    };
    let found = detached(py, move || {
        for recording in &mut recordings {
            input::check(recording)?;
            input::check_size(recording)?;
            // From here on messages say which channel.
            recording.path = SIGNAL.into();
        }
        commands::identify_channels(&recordings, &args)
    })?;
    to_python(py, &found)
}
