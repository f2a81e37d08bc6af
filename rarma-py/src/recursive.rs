//! `RecursiveArma`.

use crate::array::{Samples, Signal};
use crate::error::detached;
use crate::estimator::{Estimator, MAX_ORDER, Rows, estimator};
use crate::json::to_python;
use crate::results;
use crate::settings::{Settings, whole};
use crate::state::{Reader, Writer};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use rarma_cli::commands::modes_of;
use rarma_core::estimate::RarmaConfig;

/// Samples from here on the estimator leaves out.
const LARGEST_SAMPLE: f64 = 1e15;
/// Samples that are copied to where the model works, at a time.
const BLOCK: usize = 512;

/// Recursive ARMA(p, q) model of one channel: a new model at every sample.
///
/// Model: A(q)·y(t) = C(q)·e(t) with A(q) = 1 + Σ a_i q^-i and C(q) = 1 + Σ c_i q^-i, both with
/// plus signs. (A textbook's y(t) = Σ φ_i y(t-i) + … has a_i = -φ_i.) With θ = (a, c), σ² the
/// running innovation variance, λ the forgetting factor and ψ the gradient of the prediction:
///
///     e = y - φᵀθ,  α = λσ² + ψᵀPψ,  K = Pψ/α,  θ ← θ + K·e,  P ← (P - PψψᵀP/α)/λ
///
/// A pole pair z of A is a mode: with l = ln|z| and ϑ = arg z,
///
///     f = sample_rate_hz·√(l² + ϑ²)/2π  in Hz,   ζ = -l/√(l² + ϑ²)
///
/// f is the undamped natural frequency; ζ is the damping ratio (0.02 is 2 %), negative for a
/// vibration that grows. The standard deviations come from the covariance of θ.
///
/// The first samples (up to 1300 with the default start) only start the model: until then there
/// are no modes.
///
/// Parameters
/// ----------
/// p, q : int
///     Orders of A and C, 0 to 30 each. p/2 modes; q = p - 1 for a vibration without sensor
///     noise, q = p with it. The orders (2,1) (2,2) (4,3) (4,4) (6,5) (6,6) (8,7) (8,8) are
///     several times as fast as the others.
/// sample_rate_hz : float
///     Sampling rate, Hz.
/// forgetting : float
///     λ, weight of a sample relative to the next, 0.9 to 1. The memory is 1/(1 - λ) samples;
///     1, the default, forgets nothing.
/// random_walk : float
///     Variance per sample by which every parameter may wander, 0 to 0.01.
/// method : str
///     "rpem" (recursive prediction error), "rplr" (pseudo-linear regression) or "gradient"
///     (normalised gradient; its deviations are those of the start).
/// start_samples : int
///     Samples of the start's least squares, 0 to 400.
///
/// Pickling keeps the whole state: what is pushed after unpickling gives the same numbers, bit
/// by bit, as without.
///
/// Examples
/// --------
/// >>> model = rarma.RecursiveArma(4, 3, sample_rate_hz=8000.0, forgetting=0.9995)
/// >>> f_hz, zeta, sd_f_hz, sd_zeta = model.push(x)
/// >>> f_hz[-1], zeta[-1]
#[pyclass(module = "rarma._rarma")]
pub struct RecursiveArma {
    p: usize,
    q: usize,
    sample_rate_hz: f64,
    settings: Settings,
    model: Box<dyn Estimator>,
    samples: u64,
}

#[pymethods]
impl RecursiveArma {
    #[new]
    #[pyo3(signature = (p, q, sample_rate_hz, *, forgetting=1.0, random_walk=0.0, method="rpem", start_samples=None),
        text_signature = "(p, q, sample_rate_hz, *, forgetting=1.0, random_walk=0.0, method='rpem', start_samples=400)")]
    fn new(
        p: &Bound<'_, PyAny>,
        q: &Bound<'_, PyAny>,
        sample_rate_hz: f64,
        forgetting: f64,
        random_walk: f64,
        method: &str,
        start_samples: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (p, q) = (whole("p", p, MAX_ORDER)?, whole("q", q, MAX_ORDER)?);
        check_rate(sample_rate_hz)?;
        let default = RarmaConfig::<f64>::default().start_samples;
        let start_samples = match start_samples {
            Some(n) => whole("start_samples", n, default as usize)? as u32,
            None => default,
        };
        let settings = Settings {
            forgetting,
            random_walk,
            method: method.to_owned(),
            start_samples,
        };
        let model = estimator(p, q, settings.config()?).ok_or_else(|| {
            PyValueError::new_err("p, q: 0, 0: nothing to estimate (raise one of them)")
        })?;
        Ok(Self {
            p,
            q,
            sample_rate_hz,
            settings,
            model,
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
    /// x : numpy array of float64 or float32, shape (n,)
    ///     Samples, of any stride, in any unit; read where they lie.
    /// every : int
    ///     Read after every so many samples, counted from the first one ever pushed; 1, the
    ///     default, after each. The model is a new one at every sample all the same; its roots
    ///     and the deviations take most of the time, so that larger is faster.
    ///
    /// Returns
    /// -------
    /// Readings
    ///     (f_hz, zeta, sd_f_hz, sd_zeta), each of shape (rows, modes) with modes = ⌈p/2⌉ and
    ///     rows = n for every = 1. f_hz in Hz, zeta as a ratio, and their standard deviations.
    ///     A column follows one pair of roots; columns are in order of frequency at the moment
    ///     the roots are found. NaN where there is no mode: while the model starts, and where
    ///     both roots of a pair are real.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     x is no numpy array, or of another dtype.
    /// ValueError
    ///     x is empty, not one-dimensional, or holds NaN, infinity, or 1e15 and more. Nothing
    ///     has changed then.
    #[pyo3(signature = (x, *, every=None), text_signature = "($self, x, *, every=1)")]
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        every: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let every = every_of(every)?;
        let signal = Signal::of("x", x)?;
        let samples = signal.samples();
        check_size("x", &samples)?;
        let modes = self.p.div_ceil(2);
        let mut due = every - (self.samples % u64::from(every)) as u32;
        let count = samples.len();
        let (model, fs) = (&mut self.model, self.sample_rate_hz);
        let rows = detached(py, move || {
            let mut rows = Rows::with_room((count / every as usize + 1) * modes);
            blocks(&samples, |block| {
                model.push(block, every, &mut due, fs, &mut rows)
            });
            Ok(rows)
        })?;
        let height = rows_between(self.samples, count, every);
        self.samples += count as u64;
        readings(py, rows, [height, modes])
    }

    /// The modes of the model as it is now, by frequency.
    ///
    /// Returns a list of dicts with f and f_sd in Hz, zeta and zeta_sd as ratios, as
    /// `rarma identify --method rpem` gives them of the same samples. The roots are sought
    /// anew, which push does not do.
    fn modes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let fs = self.sample_rate_hz;
        let sd = |factor: &_| {
            let sd = self.model.deviation(factor, fs)?;
            Some((sd.frequency, sd.damping))
        };
        let modes = if self.model.a().is_empty() || !self.model.is_ready() {
            Vec::new()
        } else {
            modes_of(self.model.a(), fs, sd).unwrap_or_default()
        };
        to_python(py, &modes)
    }

    /// Does what is left of the start at once, with the samples there are: for a signal that is
    /// over. A signal too short for that, 4(p + q) + 8 samples, leaves the model without modes.
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

    /// Order of C.
    #[getter]
    fn q(&self) -> usize {
        self.q
    }

    /// Sampling rate, Hz.
    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// Samples taken so far.
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

    /// c_1 … c_q of C(q) = 1 + Σ c_i q^-i, shape (q,).
    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.model.c())
    }

    /// Innovation variance σ², units of x squared.
    #[getter]
    fn sigma2(&self) -> f64 {
        self.model.noise(0, 0)
    }

    /// Covariance of (a_1 … a_p, c_1 … c_q), shape (p + q, p + q).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.p + self.q;
        let values = (0..n * n).map(|k| self.model.covariance(k / n, k % n));
        PyArray1::from_iter(py, values).reshape([n, n])
    }

    fn __repr__(&self) -> String {
        format!(
            "RecursiveArma({}, {}, sample_rate_hz={:?}, forgetting={:?}, random_walk={:?}, method={:?}, start_samples={}) after {} samples",
            self.p,
            self.q,
            self.sample_rate_hz,
            self.settings.forgetting,
            self.settings.random_walk,
            self.settings.method,
            self.settings.start_samples,
            self.samples
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((usize, usize, f64), Bound<'py, PyDict>)> {
        let named = PyDict::new(py);
        named.set_item("forgetting", self.settings.forgetting)?;
        named.set_item("random_walk", self.settings.random_walk)?;
        named.set_item("method", &self.settings.method)?;
        named.set_item("start_samples", self.settings.start_samples)?;
        Ok(((self.p, self.q, self.sample_rate_hz), named))
    }

    fn __getstate__<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut out = Writer::new();
        for n in [self.p as u64, self.q as u64, self.samples] {
            out.whole(n);
        }
        self.model.write(&mut out);
        PyBytes::new(py, &out.finish())
    }

    fn __setstate__(&mut self, state: &[u8]) -> PyResult<()> {
        let refused = || {
            PyValueError::new_err(format!(
                "state: {} bytes are not the state of an ARMA({},{}) model of this version of rarma (unpickle with the version that pickled)",
                state.len(),
                self.p,
                self.q
            ))
        };
        let mut from = Reader::new(state).ok_or_else(refused)?;
        let order = [from.whole(), from.whole()];
        let samples = from.whole();
        // A model of its own: what is refused leaves this one as it was.
        let model = estimator(self.p, self.q, self.settings.config()?);
        let mut model = model.ok_or_else(refused)?;
        let sound = order == [self.p as u64, self.q as u64] && model.read(&mut from);
        if !sound || !from.is_used_up() {
            return Err(refused());
        }
        self.model = model;
        self.samples = samples;
        Ok(())
    }
}

/// The rate, in the range of recordings.
pub fn check_rate(sample_rate_hz: f64) -> PyResult<()> {
    let (least, most) = rarma_recordings::input::RATES_HZ.into_inner();
    if (least..=most).contains(&sample_rate_hz) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "sample_rate_hz: {sample_rate_hz}: must lie between {least} and {most}"
    )))
}

/// `every` of a push.
pub fn every_of(every: Option<&Bound<'_, PyAny>>) -> PyResult<u32> {
    let every = match every {
        Some(n) => whole("every", n, u32::MAX as usize)? as u32,
        None => 1,
    };
    if every == 0 {
        return Err(PyValueError::new_err("every: 0: must be 1 or more"));
    }
    Ok(every)
}

/// No sample is one that a model would leave out; messages call them `name`.
pub fn check_size(name: &str, samples: &Samples<'_>) -> PyResult<()> {
    match samples.first_that_is_not(|x| x.abs() < LARGEST_SAMPLE) {
        Some((at, value)) => Err(PyValueError::new_err(format!(
            "{name}[{at}]: {value:e}: must stay below {LARGEST_SAMPLE:e} (scale x to a larger unit)"
        ))),
        None => Ok(()),
    }
}

/// Rows that `count` samples after the first `before` give.
pub fn rows_between(before: u64, count: usize, every: u32) -> usize {
    let every = u64::from(every);
    ((before + count as u64) / every - before / every) as usize
}

/// Rows as a `Readings` of arrays of this shape.
pub fn readings<'py>(
    py: Python<'py>,
    rows: Rows,
    shape: [usize; 2],
) -> PyResult<Bound<'py, PyAny>> {
    let mut columns = Vec::new();
    for values in [rows.f_hz, rows.zeta, rows.sd_f_hz, rows.sd_zeta] {
        columns.push(PyArray1::from_vec(py, values).reshape(shape)?.into_any());
    }
    results::make(py, "Readings", PyTuple::new(py, columns)?)
}

/// All samples, a block at a time.
fn blocks(samples: &Samples<'_>, mut take: impl FnMut(&[f64])) {
    if let Samples::Double(x) = samples
        && let Some(x) = x.as_slice()
    {
        return take(x);
    }
    let mut block = [0.0; BLOCK];
    let mut filled = 0;
    samples.each(|x| {
        block[filled] = x;
        filled += 1;
        if filled == BLOCK {
            take(&block);
            filled = 0;
        }
    });
    take(&block[..filled]);
}
