//! Whole signals: `identify`, `order`, `psd`.

use crate::array::Signal;
use crate::error::detached;
use crate::json::to_python;
use crate::options::{Line, SIGNAL, other_command};
use numpy::PyArray1;
use pyo3::prelude::*;
use rarma_cli::Failure;
use rarma_cli::args::Command;
use rarma_cli::commands::{identify_recording, order_recording, psd_recording};
use rarma_recordings::input::{self, Recording};
use serde::Serialize;

/// Does `work` with a signal that is fit to be analysed, while other threads run.
fn of_signal<V: Send>(
    py: Python<'_>,
    x: &Bound<'_, PyAny>,
    sample_rate_hz: f64,
    work: impl FnOnce(&Recording) -> Result<V, Failure> + Send,
) -> PyResult<V> {
    let samples = Signal::of(SIGNAL, x)?.samples().to_vec();
    detached(py, move || {
        let recording = Recording::in_memory(SIGNAL, samples, sample_rate_hz);
        input::check(&recording)?;
        work(&recording)
    })
}

/// A record with some of its fields as arrays.
fn with_arrays<'py>(
    py: Python<'py>,
    record: &impl Serialize,
    arrays: &[(&str, &[f64])],
) -> PyResult<Bound<'py, PyAny>> {
    let dict = to_python(py, record)?;
    for (name, values) in arrays {
        dict.set_item(name, PyArray1::from_slice(py, values))?;
    }
    Ok(dict)
}

/// Fits one ARMA model to a whole signal: `rarma identify`.
///
/// Model: A(q)·y(t) = C(q)·e(t) with A(q) = 1 + Σ a_i q^-i and C(q) = 1 + Σ c_i q^-i, both with
/// plus signs.
///
/// Parameters
/// ----------
/// x : numpy array of float64 or float32, shape (n,)
///     Samples, in any unit.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// order : (int, int)
///     Orders p and q of A and C, 0 to 30 each; p to 60 for autoregressive methods.
/// method : str
///     "pem" (prediction error, the default), "ml" (exact likelihood), "rpem", "rplr",
///     "gradient", "riv", "iv", "burg", "yule-walker", "least-squares", "lattice", "esprit" or
///     "tones".
/// band_hz : (float, float) or "full", optional
///     Band that is looked at, decimated as the monitor does; "full" is the signal as it is.
///     Default: the monitor's band above 6 kHz, else "full".
/// detrend : str
///     What is removed before the fit: "none", "mean" (the default) or "linear".
/// forgetting, random_walk : float
///     Memory of the recursive methods.
///
/// Returns
/// -------
/// dict
///     method, order, band, fs (Hz, of the samples that were fitted), n, a and c (arrays without
///     the leading 1), sigma2 (units of x squared), mean, modes (list of dicts: f, f_sd in Hz;
///     zeta, zeta_sd as ratios; None where no deviation can be given), aic, bic, fpe,
///     whiteness_p.
///
/// Raises
/// ------
/// TypeError, ValueError
///     The signal or an argument is not what is described here, or no model can be fitted: what,
///     where, why and what to do.
#[pyfunction]
#[pyo3(signature = (x, sample_rate_hz, order, *, method="pem", band_hz=None, detrend="mean", forgetting=1.0, random_walk=0.0))]
#[allow(clippy::too_many_arguments, reason = "they have names in Python")]
pub fn identify<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    sample_rate_hz: f64,
    order: (i64, i64),
    method: &str,
    band_hz: Option<&Bound<'py, PyAny>>,
    detrend: &str,
    forgetting: f64,
    random_walk: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let line = Line::of_signal("identify", sample_rate_hz)
        .with_order(Some(order))
        .with("method", method)
        .with_band(band_hz)?
        .with("detrend", detrend)
        .with("forgetting", forgetting)
        .with("random-walk", random_walk);
    let Command::Identify(args) = line.parse()? else {
        return Err(other_command());
    };
    let found = of_signal(py, x, sample_rate_hz, move |x| identify_recording(x, &args))?;
    with_arrays(py, &found, &[("a", &found.a), ("c", &found.c)])
}

/// Fits candidate orders (p, p-1) and (p, p) and says which a criterion chooses: `rarma order`.
///
/// Parameters
/// ----------
/// x : numpy array of float64 or float32, shape (n,)
///     Samples, in any unit.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// max_p : int
///     Largest p, 1 to 30.
/// band_hz : (float, float) or "full", optional
///     As for `identify`.
/// criterion : str
///     "aic", "aicc", "bic" (the default) or "fpe".
///
/// Returns
/// -------
/// dict
///     band, candidates (list of dicts: order, sigma2, aic, aicc, bic, fpe, modes with f in Hz,
///     zeta, stable_f and stable against the candidate one step below), choice ([p, q]),
///     criterion, fs, n.
#[pyfunction]
#[pyo3(signature = (x, sample_rate_hz, *, max_p=10, band_hz=None, criterion="bic"))]
pub fn order<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    sample_rate_hz: f64,
    max_p: i64,
    band_hz: Option<&Bound<'py, PyAny>>,
    criterion: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let line = Line::of_signal("order", sample_rate_hz)
        .with("max", max_p)
        .with_band(band_hz)?
        .with("criterion", criterion);
    let Command::Order(args) = line.parse()? else {
        return Err(other_command());
    };
    let choice = of_signal(py, x, sample_rate_hz, move |x| order_recording(x, &args))?;
    to_python(py, &choice)
}

/// Power spectral density: `rarma psd`.
///
/// Parameters
/// ----------
/// x : numpy array of float64 or float32, shape (n,)
///     Samples, in any unit.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// method : str
///     "welch" (the default; half-overlapping stretches of at most 4096 samples under a Hann
///     window), "periodogram", "ar" (Burg, order (p, 0)) or "arma" (prediction error).
/// order : (int, int), optional
///     Order of the model, for "ar" and "arma".
/// band_hz : (float, float) or "full", optional
///     As for `identify`; the density is that of the signal before the band's filters.
/// at_hz : float, optional
///     At this one frequency instead of on a grid.
///
/// Returns
/// -------
/// dict
///     band, fs, n, f (array, Hz) and psd (array, one-sided, units of x squared per Hz).
#[pyfunction]
#[pyo3(signature = (x, sample_rate_hz, *, method="welch", order=None, band_hz=None, at_hz=None))]
pub fn psd<'py>(
    py: Python<'py>,
    x: &Bound<'py, PyAny>,
    sample_rate_hz: f64,
    method: &str,
    order: Option<(i64, i64)>,
    band_hz: Option<&Bound<'py, PyAny>>,
    at_hz: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let line = Line::of_signal("psd", sample_rate_hz)
        .with("method", method)
        .with_order(order)
        .with_band(band_hz)?
        .with_some("at", at_hz);
    let Command::Psd(args) = line.parse()? else {
        return Err(other_command());
    };
    let density = of_signal(py, x, sample_rate_hz, move |x| psd_recording(x, &args))?;
    with_arrays(py, &density, &[("f", &density.f), ("psd", &density.psd)])
}
