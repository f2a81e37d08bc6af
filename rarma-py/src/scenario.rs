//! The virtual machine tool: `scenarios`, `simulate`, `lobes`.

use crate::error::{detached, exception};
use crate::json::to_python;
use crate::options::{Line, other_command};
use crate::results;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rarma_cli::args::Command;
use rarma_cli::commands::{LobePoint, lobe_chart};
use rarma_scenarios::scenario;
use rarma_scenarios::truth::TruthRecord;
use std::path::PathBuf;

/// The shipped scenarios: what each shows, by name.
#[pyfunction]
pub fn scenarios(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for (name, _) in scenario::SHIPPED {
        out.set_item(name, scenario::load(name, None).map_err(exception)?.about)?;
    }
    Ok(out)
}

/// Cuts virtually: `rarma simulate`.
///
/// Parameters
/// ----------
/// scenario : str or path
///     Name of a shipped scenario (see `scenarios`), or a TOML file.
/// seed : int, optional
///     Seed of everything random; wins over the file's.
///
/// Returns
/// -------
/// Simulation
///     (samples, sample_rate_hz, truth, clipped): samples as parts of full scale, what
///     `rarma.read` gives of the WAV that `rarma simulate` writes; truth as its JSON: modes (f in
///     Hz, zeta), speed_rpm, teeth, limit, onset_s, operational damping ratios and so on; clipped,
///     the number of samples at the end of the range.
#[pyfunction]
#[pyo3(signature = (scenario, *, seed=None))]
pub fn simulate<'py>(
    py: Python<'py>,
    scenario: PathBuf,
    seed: Option<i64>,
) -> PyResult<Bound<'py, PyAny>> {
    let seed = seed
        .map(|n| {
            u64::try_from(n)
                .map_err(|_| PyValueError::new_err(format!("seed: {n}: must be 0 or more")))
        })
        .transpose()?;
    let (sound, truth) = detached(py, move || {
        let loaded = scenario::load(&scenario.to_string_lossy(), seed)?;
        let truth = TruthRecord::of(&loaded)?;
        Ok((rarma_cli::commands::simulate(&loaded)?, truth))
    })?;
    let fields = (
        PyArray1::from_vec(py, sound.samples),
        sound.fs,
        to_python(py, &truth)?,
        sound.clipped,
    );
    results::make(
        py,
        "Simulation",
        PyTuple::new(
            py,
            [
                fields.0.into_any(),
                fields.1.into_pyobject(py)?.into_any(),
                fields.2,
                fields.3.into_pyobject(py)?.into_any(),
            ],
        )?,
    )
}

/// Stability lobes: limit depth and chatter frequency over spindle speed, `rarma lobes`.
///
/// Parameters
/// ----------
/// scenario : str or path
///     Name of a shipped scenario (see `scenarios`), or a TOML file.
/// rpm : (float, float), optional
///     Spindle speeds from and to, 1/min. Default: half to one and a half times the scenario's.
/// speeds : int
///     How many of them, 1 to 20000.
/// max_depth_mm : float, optional
///     Largest depth, mm. Default: twice the scenario's.
///
/// Returns
/// -------
/// dict
///     scenario, most_mm (largest depth that was looked at), and arrays of one value a speed:
///     speed_rpm (1/min), depth_mm (lowest limit by semi-discretisation, mm; NaN where there is
///     none up to most_mm), chatter_hz (Hz), zero_order_mm (NaN where it is not valid), and
///     crossing, a list of "hopf", "flip", "fold" or None.
#[pyfunction]
#[pyo3(signature = (scenario, *, rpm=None, speeds=121, max_depth_mm=None))]
pub fn lobes<'py>(
    py: Python<'py>,
    scenario: PathBuf,
    rpm: Option<(f64, f64)>,
    speeds: i64,
    max_depth_mm: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let name = scenario.to_string_lossy().into_owned();
    let line = Line::new("lobes", "scenario")
        .with_pair("rpm", rpm)
        .with("speeds", speeds)
        .with_some("max-depth-mm", max_depth_mm);
    let Command::Lobes(args) = line.parse()? else {
        return Err(other_command());
    };
    let chart = detached(py, move || {
        lobe_chart(&name, scenario::load(&name, None)?, &args, || {})
    })?;
    let array = |of: fn(&LobePoint) -> Option<f64>| {
        let values = chart.points.iter().map(|p| of(p).unwrap_or(f64::NAN));
        PyArray1::from_iter(py, values)
    };
    let crossing: Vec<Option<&str>> = chart.points.iter().map(|p| p.crossing).collect();
    let out = PyDict::new(py);
    out.set_item("scenario", &chart.scenario)?;
    out.set_item("most_mm", chart.most_mm)?;
    out.set_item("speed_rpm", array(|p| Some(p.speed_rpm)))?;
    out.set_item("depth_mm", array(|p| p.depth_mm))?;
    out.set_item("chatter_hz", array(|p| p.chatter_hz))?;
    out.set_item("crossing", crossing)?;
    out.set_item("zero_order_mm", array(|p| p.zero_order_mm))?;
    Ok(out)
}
