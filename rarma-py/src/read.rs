//! `read`: recordings of every format the command reads.

use crate::error::detached;
use crate::options::{Line, other_command};
use crate::results;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rarma_cli::args::Command;
use rarma_recordings::input::{self, ReadOptions};
use std::path::PathBuf;

/// Reads one channel of a recording.
///
/// Parameters
/// ----------
/// path : str or path
///     WAV (PCM 8 to 32 bit, float), CSV, .uff (universal file), .tdms (LabVIEW), .f32 or .f64
///     (little endian), or .frames, the record of a sensor box. The formats of phones (.m4a, .mp3, .flac, .ogg) are read by the command,
///     not by this package.
/// channel : int
///     Channel, counted from 0.
/// sample_rate_hz : float, optional
///     Sampling rate, Hz, where the file does not say it.
///
/// Returns
/// -------
/// Recording
///     (samples, sample_rate_hz, full_scale, channels, notices): samples as float64, whole
///     numbers scaled to ±1; full_scale 1.0 for those and None where there is no limit; channels
///     in the file; notices, what is odd about it, a sentence each.
///
/// Raises
/// ------
/// ValueError
///     The file cannot be read or is not fit to be analysed: file, place, reason, what to do.
#[pyfunction]
#[pyo3(signature = (path, *, channel=0, sample_rate_hz=None))]
pub fn read<'py>(
    py: Python<'py>,
    path: PathBuf,
    channel: i64,
    sample_rate_hz: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let line = Line::new("psd", "file")
        .with("method", "welch")
        .with("channel", channel)
        .with_some("fs", sample_rate_hz);
    let Command::Psd(args) = line.parse()? else {
        return Err(other_command());
    };
    let recording = detached(py, move || {
        let options = ReadOptions {
            channel: args.input.channel,
            fs: args.input.fs,
            ..ReadOptions::default()
        };
        Ok(input::read(&path, &options)?)
    })?;
    let fields = [
        PyArray1::from_vec(py, recording.samples).into_any(),
        recording.fs.into_pyobject(py)?.into_any(),
        recording.full_scale.into_pyobject(py)?.into_any(),
        recording.channels.into_pyobject(py)?.into_any(),
        recording.notices.into_pyobject(py)?.into_any(),
    ];
    results::make(py, "Recording", PyTuple::new(py, fields)?)
}
