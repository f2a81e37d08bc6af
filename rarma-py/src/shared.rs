//! `RecursiveChannels`.

use crate::array::Signal;
use crate::channels::{column, width};
use crate::error::detached;
use crate::estimator::{Estimator, Followed, MAX_ORDER, Rows};
use crate::json::to_python;
use crate::recursive::{check_rate, check_size, every_of, readings, rows_between};
use crate::settings::{Settings, whole};
use crate::state::{Reader, Writer};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rarma_core::estimate::RarmaConfig;
use rarma_fit::{ChannelError, MOST_CHANNELS, MOST_PARAMETERS, Weights};
use serde_json::{Value, json};

/// p, q, channels, rate in Hz.
type Shape = (usize, usize, usize, f64);
type Model = Followed<rarma_fit::RecursiveChannels, MAX_ORDER>;

/// Recursive ARMA model of several channels that share their poles: a new model at every sample.
///
/// Model: A(q)·y_k(t) = C_k(q)·e_k(t) for channel k, with A(q) = 1 + Σ a_i q^-i and
/// C_k(q) = 1 + Σ c_ki q^-i, plus signs as in `RecursiveArma`, and E e·eᵀ = Λ. The poles of a
/// structure are the same wherever it is listened to: a mode in whose node one sensor sits is
/// read by the others. The recursion is that of `RecursiveArma` with one scalar equation a
/// channel, one after the other; with one channel it is `RecursiveArma` but for rounding.
///
/// f, ζ and their units as there. The standard deviations account for channels that hear the same
/// (weights="own"): several sensors of one mode tell of its damping hardly more than one, for it
/// is the vibration that is random, not the sensors; what they give is the modes that single ones
/// do not see, and less noise.
///
/// The first samples (400 with the default start) only start the model: until then there are no
/// modes.
///
/// Parameters
/// ----------
/// p, q : int
///     Orders of A and of each C, 0 to 30 each. p/2 modes; q = p with sensor noise.
/// channels : int
///     Channels, 1 to 16; p + channels·q at most 128.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// forgetting : float
///     λ, weight of a sample relative to the next, 0.9 to 1. The memory is 1/(1 - λ) samples;
///     1, the default, forgets nothing.
/// random_walk : float
///     Variance per sample by which every parameter may wander, 0 to 0.01.
/// weights : str
///     "own" weighs each channel by its own innovation variance, right whatever shakes the
///     structure. "joint" weighs by the inverse of Λ: more accurate where the innovations of a
///     channel cannot be predicted from the past of the others, biased and too sure of itself
///     where they can, as of two noisy sensors of one mode.
/// start_samples : int
///     Samples of the start's least squares, 4·(p + q) + 8 to 400.
///
/// Pickling keeps the whole state: what is pushed after unpickling gives the same numbers, bit
/// by bit, as without.
///
/// Examples
/// --------
/// >>> model = rarma.RecursiveChannels(4, 4, 2, sample_rate_hz=8000.0, forgetting=0.9995)
/// >>> f_hz, zeta, sd_f_hz, sd_zeta = model.push(x)  # x of shape (n, 2)
#[pyclass(module = "rarma._rarma")]
pub struct RecursiveChannels {
    p: usize,
    q: usize,
    channels: usize,
    sample_rate_hz: f64,
    settings: Settings,
    weights: Weights,
    model: Box<Model>,
    samples: u64,
}

fn weights_of(name: &str) -> PyResult<Weights> {
    match name {
        "own" => Ok(Weights::Own),
        "joint" => Ok(Weights::Joint),
        other => Err(PyValueError::new_err(format!(
            "weights: {other:?} is none of own, joint"
        ))),
    }
}

fn name_of(weights: Weights) -> &'static str {
    match weights {
        Weights::Own => "own",
        Weights::Joint => "joint",
    }
}

/// A model that has seen nothing.
fn model_of(
    [p, q, channels]: [usize; 3],
    weights: Weights,
    settings: &Settings,
) -> PyResult<Box<Model>> {
    let n = p + channels * q;
    if n == 0 || n > MOST_PARAMETERS {
        return Err(PyValueError::new_err(format!(
            "p, q, channels: {p}, {q}, {channels}: p + channels·q is {n}, and must lie between 1 and {MOST_PARAMETERS}"
        )));
    }
    let model = rarma_fit::RecursiveChannels::new(p, q, channels, weights, settings.config()?);
    let model = model.map_err(|why| {
        PyValueError::new_err(match why {
            ChannelError::OutOfRange {
                setting: "start_samples",
            } => format!(
                "start_samples: {}: must lie between {} and {}, for this order",
                settings.start_samples,
                4 * (p + q) + 8,
                RarmaConfig::<f64>::default().start_samples
            ),
            other => other.to_string(),
        })
    })?;
    Ok(Box::new(Followed::new(model)))
}

#[pymethods]
impl RecursiveChannels {
    #[new]
    #[pyo3(signature = (p, q, channels, sample_rate_hz, *, forgetting=1.0, random_walk=0.0, weights="own", start_samples=None),
        text_signature = "(p, q, channels, sample_rate_hz, *, forgetting=1.0, random_walk=0.0, weights='own', start_samples=400)")]
    #[allow(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        p: &Bound<'_, PyAny>,
        q: &Bound<'_, PyAny>,
        channels: &Bound<'_, PyAny>,
        sample_rate_hz: f64,
        forgetting: f64,
        random_walk: f64,
        weights: &str,
        start_samples: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (p, q) = (whole("p", p, MAX_ORDER)?, whole("q", q, MAX_ORDER)?);
        let channels = whole("channels", channels, MOST_CHANNELS)?;
        if channels == 0 {
            return Err(PyValueError::new_err(format!(
                "channels: 0: must lie between 1 and {MOST_CHANNELS}"
            )));
        }
        check_rate(sample_rate_hz)?;
        let default = RarmaConfig::<f64>::default().start_samples;
        let start_samples = match start_samples {
            Some(n) => whole("start_samples", n, default as usize)? as u32,
            None => default,
        };
        let settings = Settings {
            forgetting,
            random_walk,
            method: "rpem".to_owned(),
            start_samples,
        };
        let weights = weights_of(weights)?;
        Ok(Self {
            p,
            q,
            channels,
            sample_rate_hz,
            model: model_of([p, q, channels], weights, &settings)?,
            settings,
            weights,
            samples: 0,
        })
    }

    /// Takes samples, and reads the modes off the model after them.
    ///
    /// The state is kept: two pushes of halves give what one push of the whole gives. Other
    /// threads of Python run meanwhile.
    ///
    /// Parameters
    /// ----------
    /// x : numpy array of float64 or float32, shape (n, channels)
    ///     Samples, of any stride, each channel in any unit.
    /// every : int
    ///     Read after every so many samples, counted from the first one ever pushed; 1, the
    ///     default, after each.
    ///
    /// Returns
    /// -------
    /// Readings
    ///     (f_hz, zeta, sd_f_hz, sd_zeta), as of `RecursiveArma.push`: the modes are those of all
    ///     channels together.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     x is no numpy array, or of another dtype.
    /// ValueError
    ///     x is empty, not of shape (n, channels), or holds NaN, infinity, or 1e15 and more.
    ///     Nothing has changed then.
    #[pyo3(signature = (x, *, every=None), text_signature = "($self, x, *, every=1)")]
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        every: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let every = every_of(every)?;
        let found = width(x)?;
        if found != self.channels {
            return Err(PyValueError::new_err(format!(
                "x: shape (n, {found}) is not that of this model's channels, (n, {})",
                self.channels
            )));
        }
        let mut signals = Vec::new();
        for k in 0..found {
            let (name, signal) = column(x, k)?;
            check_size(&name, &signal.samples())?;
            signals.push(signal);
        }
        let columns: Vec<_> = signals.iter().map(Signal::samples).collect();
        let count = columns[0].len();
        let modes = self.p.div_ceil(2);
        let mut due = every - (self.samples % u64::from(every)) as u32;
        let (model, fs) = (&mut self.model, self.sample_rate_hz);
        let rows = detached(py, move || {
            let mut rows = Rows::with_room((count / every as usize + 1) * modes);
            let mut together = vec![0.0; count * found];
            for (k, column) in columns.iter().enumerate() {
                let mut places = together.iter_mut().skip(k).step_by(found);
                column.each(|x| {
                    if let Some(place) = places.next() {
                        *place = x;
                    }
                });
            }
            model.push(&together, every, &mut due, fs, &mut rows);
            Ok(rows)
        })?;
        let height = rows_between(self.samples, count, every);
        self.samples += count as u64;
        readings(py, rows, [height, modes])
    }

    /// The modes of the model as it is now, by frequency, with what each channel shows of them.
    ///
    /// Returns a list of dicts: f and f_sd in Hz, zeta and zeta_sd as ratios, and shape, one dict
    /// for each channel: channel, re, im, magnitude and phase_deg over the channel that shows the
    /// most, and amplitude, the root mean square of the mode in that channel, units of x. Shapes
    /// and amplitudes are what each mode has of the covariances between the channels, by least
    /// squares over the first lags; they have no deviations (those of `identify_channels` have).
    fn modes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let number = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
        let modes: Vec<Value> = self
            .model
            .model
            .modes(self.sample_rate_hz)
            .iter()
            .map(|mode| {
                let shape = mode.parts.iter().enumerate().map(|(channel, part)| {
                    json!({
                        "channel": channel,
                        "re": number(part.re),
                        "im": number(part.im),
                        "magnitude": number(part.re.hypot(part.im)),
                        "phase_deg": number(part.im.atan2(part.re).to_degrees()),
                        "amplitude": number(part.amplitude),
                    })
                });
                json!({
                    "f": mode.frequency,
                    "f_sd": mode.frequency_sd,
                    "zeta": mode.damping,
                    "zeta_sd": mode.damping_sd,
                    "shape": shape.collect::<Vec<_>>(),
                })
            })
            .collect();
        to_python(py, &modes)
    }

    /// Does the start at once, with the samples there are: for a signal that is over. A signal too
    /// short for that, 4·(p + q) + 8 samples, leaves the model without modes.
    fn finish_start(&mut self, py: Python<'_>) -> PyResult<()> {
        let model = &mut self.model;
        detached(py, move || {
            model.finish_start();
            Ok(())
        })
    }

    /// Order of A.
    #[getter]
    fn p(&self) -> usize {
        self.p
    }

    /// Order of each C.
    #[getter]
    fn q(&self) -> usize {
        self.q
    }

    /// Channels.
    #[getter]
    fn channels(&self) -> usize {
        self.channels
    }

    /// Sampling rate, Hz.
    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// Samples taken so far, of each channel.
    #[getter]
    fn samples(&self) -> u64 {
        self.samples
    }

    /// The start is over: there is a model.
    #[getter]
    fn ready(&self) -> bool {
        self.model.is_ready()
    }

    /// a_1 … a_p of A(q) = 1 + Σ a_i q^-i, shape (p,).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.model.a())
    }

    /// c_k1 … c_kq of C_k(q) = 1 + Σ c_ki q^-i, shape (channels, q).
    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        PyArray1::from_slice(py, self.model.c()).reshape([self.channels, self.q])
    }

    /// Covariance Λ of the innovations, shape (channels, channels), units of both channels.
    #[getter]
    fn innovation_covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let k = self.channels;
        let values = (0..k * k).map(|i| self.model.noise(i / k, i % k));
        PyArray1::from_iter(py, values).reshape([k, k])
    }

    fn __repr__(&self) -> String {
        format!(
            "RecursiveChannels({}, {}, {}, sample_rate_hz={:?}, forgetting={:?}, random_walk={:?}, weights={}, start_samples={}) after {} samples",
            self.p,
            self.q,
            self.channels,
            self.sample_rate_hz,
            self.settings.forgetting,
            self.settings.random_walk,
            name_of(self.weights),
            self.settings.start_samples,
            self.samples
        )
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Shape, Bound<'py, PyDict>)> {
        let named = PyDict::new(py);
        named.set_item("forgetting", self.settings.forgetting)?;
        named.set_item("random_walk", self.settings.random_walk)?;
        named.set_item("weights", name_of(self.weights))?;
        named.set_item("start_samples", self.settings.start_samples)?;
        Ok(((self.p, self.q, self.channels, self.sample_rate_hz), named))
    }

    fn __getstate__<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut out = Writer::new();
        let order = [self.p, self.q, self.channels].map(|n| n as u64);
        for n in order.into_iter().chain([self.samples]) {
            out.whole(n);
        }
        self.model.write(&mut out);
        PyBytes::new(py, &out.finish())
    }

    fn __setstate__(&mut self, state: &[u8]) -> PyResult<()> {
        let order = [self.p, self.q, self.channels];
        let refused = || {
            PyValueError::new_err(format!(
                "state: {} bytes are not the state of an ARMA({},{}) model of {} channels of this version of rarma (unpickle with the version that pickled)",
                state.len(),
                order[0],
                order[1],
                order[2]
            ))
        };
        let mut from = Reader::new(state).ok_or_else(refused)?;
        let written = [from.whole(), from.whole(), from.whole()];
        let samples = from.whole();
        // A model of its own: what is refused leaves this one as it was.
        let mut model = model_of(order, self.weights, &self.settings)?;
        let sound = written == order.map(|n| n as u64) && model.read(&mut from);
        if !sound || !from.is_used_up() {
            return Err(refused());
        }
        self.model = model;
        self.samples = samples;
        Ok(())
    }
}
