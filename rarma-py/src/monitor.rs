//! `Monitor`.

use crate::array::Signal;
use crate::error::{detached, exception};
use crate::json::to_python;
use crate::monitor_state::{self, Made};
use crate::options::{Line, SIGNAL, other_command};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rarma_cli::advice::Reach;
use rarma_cli::args::Command;
use rarma_cli::collect::News;
use rarma_cli::commands::{About, Feed};
use rarma_core::decide::Structure;
use rarma_recordings::input;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Listens to one channel of a cut and says when it chatters: `rarma monitor` block by block.
///
/// It takes samples as single precision, as the sensor box does; records and summary are those
/// that `rarma monitor --json` prints of the same samples in a file.
///
/// Parameters
/// ----------
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// order : (int, int)
///     Order of the model: (2,1) (2,2) (4,3) (4,4) (6,5) (6,6) (8,7) or (8,8).
/// rpm : float, optional
///     Spindle speed, 1/min: lines on its multiples count as forced.
/// teeth : int, optional
///     Teeth on the cutter.
/// band_hz : (float, float), optional
///     Band that is analysed, Hz. Default 300 to 2500, lower for slow recordings.
/// threshold : float
///     Damping ratio below which a mode counts as undamped.
/// idle_s : (float, float), optional
///     Seconds that are known to be idle; without it idle is found.
/// every_s : float
///     Seconds between two records.
/// aliased : bool
///     The sampler has no anti-alias filter.
/// structure : path, optional
///     Modes of the structure at rest (JSON of `rarma identify`, or CSV): what the process adds
///     to their damping is told.
/// full_scale : float, optional
///     Largest value the converter gives, in the unit of x: 1 for a WAV of whole numbers as
///     `rarma.read` gives it. Without it clipping is not looked for.
/// set : dict of str to float, optional
///     Other values for numbers of the verdict, by name (docs/verdict.md).
/// reach_percent : (float, float), optional
///     For the advice in the summary: speeds that may be turned, percent of that at the alarm.
///     Default 50 to 150.
/// power : float, optional
///     Power that the spindle can give over what the cut takes.
/// same_feed : bool
///     The feed is not changed with the speed.
/// swing_percent : float, optional
///     Where no speed is stable a speed that swings is proposed: how far it may about its mean,
///     percent, 1 to 50. Default 20.
/// swing_acceleration_rad_s2 : float, optional
///     How fast the spindle may speed up in such a swing, rad/s²: 0.105 times its largest speed,
///     1/min, over its time to run up, s. Default 300.
/// swing_hz : float, optional
///     How often it may swing, times a second. Default 4.
///
/// Examples
/// --------
/// >>> x, sample_rate_hz, full_scale, *_ = rarma.read("cut.wav")
/// >>> monitor = rarma.Monitor(sample_rate_hz, full_scale=full_scale, rpm=1656, teeth=6)
/// >>> records = monitor.push(x)
/// >>> monitor.summary()["alarms"]
///
/// Notes
/// -----
/// `copy.copy`, `copy.deepcopy` and `pickle` give a monitor of its own that goes on bit by bit as
/// this one would. A pickle is some 60 kB, holds the modes of the structure and not its file, and is
/// taken back by the version of the package that wrote it; another one refuses it with a ValueError.
#[pyclass(module = "rarma._rarma")]
#[derive(Clone)]
pub struct Monitor {
    feed: Feed,
    made: Made,
}

#[pymethods]
impl Monitor {
    #[new]
    #[pyo3(signature = (sample_rate_hz, *, order=(8, 7), rpm=None, teeth=None, band_hz=None,
        threshold=0.01, idle_s=None, every_s=0.01, aliased=false, structure=None,
        full_scale=None, set=None, reach_percent=None, power=None, same_feed=false,
        swing_percent=None, swing_acceleration_rad_s2=None, swing_hz=None),
        text_signature = "(sample_rate_hz, *, order=(8, 7), rpm=None, teeth=None, band_hz=None, threshold=0.01, idle_s=None, every_s=0.01, aliased=False, structure=None, full_scale=None, set=None, reach_percent=None, power=None, same_feed=False, swing_percent=None, swing_acceleration_rad_s2=None, swing_hz=None)")]
    #[allow(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        sample_rate_hz: f64,
        order: (i64, i64),
        rpm: Option<f64>,
        teeth: Option<i64>,
        band_hz: Option<(f64, f64)>,
        threshold: f64,
        idle_s: Option<(f64, f64)>,
        every_s: f64,
        aliased: bool,
        structure: Option<PathBuf>,
        full_scale: Option<f64>,
        set: Option<BTreeMap<String, f64>>,
        reach_percent: Option<(f64, f64)>,
        power: Option<f64>,
        same_feed: bool,
        swing_percent: Option<f64>,
        swing_acceleration_rad_s2: Option<f64>,
        swing_hz: Option<f64>,
    ) -> PyResult<Self> {
        if full_scale.is_some_and(|x| !(x.is_finite() && x > 0.0)) {
            return Err(PyValueError::new_err(format!(
                "full_scale: {}: must be above 0 and finite",
                full_scale.unwrap_or_default()
            )));
        }
        let mut line = Line::of_signal("advise", sample_rate_hz)
            .with_order(Some(order))
            .with_some("rpm", rpm)
            .with_some("teeth", teeth)
            .with_pair("band", band_hz)
            .with("threshold", threshold)
            .with_pair("idle", idle_s)
            .with("every", every_s)
            .with_flag("aliased", aliased)
            .with_pair("reach", reach_percent)
            .with_some("power", power)
            .with_flag("same-feed", same_feed)
            .with_some("swing", swing_percent)
            .with_some("swing-acceleration", swing_acceleration_rad_s2)
            .with_some("swing-hz", swing_hz);
        for (name, value) in set.unwrap_or_default() {
            line = line.with("set", format!("{name}={value}"));
        }
        let structure = structure.as_deref().map(input::read_structure).transpose();
        let structure = structure.map_err(exception)?;
        let made = Made {
            arguments: line.words().to_vec(),
            sample_rate_hz,
            full_scale,
            structure: None,
        };
        let made = made.with_structure(structure.as_ref());
        let feed = feed(&made, structure)?;
        Ok(Self { feed, made })
    }

    /// Takes samples, and returns the records that were due meanwhile.
    ///
    /// The state is kept from push to push. Other threads of Python run meanwhile.
    ///
    /// Parameters
    /// ----------
    /// x : numpy array of float64 or float32, shape (n,)
    ///     Samples of any stride, in any unit.
    ///
    /// Returns
    /// -------
    /// list of dict
    ///     A record each `every_s` seconds: t in s, state ("starting", "idle", "stable",
    ///     "warning", "chatter" or "invalid"), reason, modes (f, f_sd in Hz,
    ///     zeta, zeta_sd as ratios, amplitude in units of x, label, …), spindle, and what else
    ///     the lines of `rarma monitor --json` hold (docs/interfaces.md). `rarma.to_numpy` and
    ///     `rarma.to_pandas` make tables of them.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     x is no numpy array, or of another dtype.
    /// ValueError
    ///     x is empty, not one-dimensional, or holds NaN or infinity (say with `missing` how
    ///     many samples were lost) or what single precision does not hold, beyond 3.4e38. Nothing
    ///     has changed then.
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let signal = Signal::of("x", x)?;
        let samples = signal.samples();
        if let Some((at, value)) = samples.first_that_is_not(|x| (x as f32).is_finite()) {
            return Err(PyValueError::new_err(format!(
                "x[{at}]: {value:e}: a monitor takes samples as single precision, which ends at {:e} (scale x to a larger unit)",
                f32::MAX
            )));
        }
        let feed = &mut self.feed;
        let lines = detached(py, move || {
            let mut lines = Vec::new();
            let mut hear = |news| {
                if let News::Line(line) = news {
                    lines.push(line);
                }
            };
            samples.each(|x| feed.sample(x as f32, &mut hear));
            Ok(lines)
        })?;
        lines.iter().map(|line| to_python(py, line)).collect()
    }

    /// So many samples were lost before the next one: time goes on without them.
    fn missing(&mut self, samples: u64) {
        self.feed.missing(samples);
    }

    /// The control tells the speed of the spindle, 1/min: from now on it is that.
    fn tell_speed(&mut self, rpm: f64) -> PyResult<()> {
        self.feed.tell_speed(rpm / 60.0).map_err(|_| {
            PyValueError::new_err(format!("rpm: {rpm}: must lie between 0.06 and 300000"))
        })
    }

    /// What there is to say of all that was heard so far, as the last line of
    /// `rarma monitor --json`: fs, samples, order, alarms (on and off in s, f in Hz, zeta,
    /// zeta_median and zeta_deviation, and advice where speed and teeth were told), state_seconds,
    /// notices, spindle.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let feed = self.feed.clone();
        let summary = detached(py, move || feed.finish())?;
        to_python(py, &summary)
    }

    /// What would have to be told to give advice: "speed", "teeth", or neither.
    #[getter]
    fn missing_for_advice<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.feed.missing_for_advice())
    }

    /// Sampling rate, Hz.
    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        self.made.sample_rate_hz
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Pickled<'py>> {
        // The state is shown by a monitor that may be changed meanwhile.
        let bytes = monitor_state::write(&self.made, &mut self.feed.clone());
        let bytes = bytes.map_err(PyRuntimeError::new_err)?;
        let module = py.import("rarma._rarma")?;
        Ok((
            module.getattr("monitor_of_state")?,
            (PyBytes::new(py, &bytes),),
        ))
    }
}

/// What unpickles, and of what.
type Pickled<'py> = (Bound<'py, PyAny>, (Bound<'py, PyBytes>,));

/// The monitor that was pickled: not to be called by hand.
#[pyfunction]
pub fn monitor_of_state(py: Python<'_>, state: &[u8]) -> PyResult<Monitor> {
    let make = |made: &Made| {
        let structure = made.structure().map_err(PyValueError::new_err)?;
        feed(made, structure)
    };
    let read = detached(py, || Ok(monitor_state::read(state, make)))?;
    let (made, feed) = read.map_err(|why| PyValueError::new_err(format!("state: {why}")))?;
    Ok(Monitor { feed, made })
}

/// One that has heard nothing.
fn feed(made: &Made, structure: Option<Structure<f64>>) -> PyResult<Feed> {
    let Command::Advise(args) = made.line().parse()? else {
        return Err(other_command());
    };
    let about = About {
        path: SIGNAL.into(),
        fs: made.sample_rate_hz,
        full_scale: made.full_scale,
        samples: None,
    };
    let reach = Reach::from(&args);
    Feed::of_structure(&args.monitor, &about, reach, structure).map_err(exception)
}
