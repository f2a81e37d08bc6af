//! Signals from numpy, read where they lie.

use numpy::ndarray::ArrayView1;
use numpy::{PyArrayDescrMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// One channel, borrowed.
pub enum Signal<'py> {
    Double(PyReadonlyArray1<'py, f64>),
    Single(PyReadonlyArray1<'py, f32>),
}

/// The samples of a [`Signal`]: of any stride, and free to go to another thread.
pub enum Samples<'a> {
    Double(ArrayView1<'a, f64>),
    Single(ArrayView1<'a, f32>),
}

impl<'py> Signal<'py> {
    /// Borrows `x`, which messages call `name`.
    ///
    /// # Errors
    /// TypeError for what is no array of float64 or float32; ValueError where it has no samples,
    /// more than one dimension, or a sample that is no number.
    pub fn of(name: &str, x: &Bound<'py, PyAny>) -> PyResult<Self> {
        let Ok(array) = x.cast::<PyUntypedArray>() else {
            return Err(PyTypeError::new_err(format!(
                "{name}: {} is no numpy array (pass numpy.asarray({name}, dtype=float))",
                x.get_type().name()?
            )));
        };
        if array.ndim() != 1 {
            return Err(PyValueError::new_err(format!(
                "{name}: shape {} is not that of one channel, (n,) (pass one column, such as {name}[:, 0], or {name}.ravel())",
                array.getattr("shape")?
            )));
        }
        let dtype = array.dtype();
        let number = dtype.kind() == b'f' && [4, 8].contains(&dtype.itemsize());
        if !number || dtype.is_native_byteorder() == Some(false) {
            let remedy = match dtype.kind() {
                b'i' | b'u' => format!(
                    "of integers full scale is not known: divide by it, such as {name} / 32768.0 for 16 bit"
                ),
                _ => format!("pass {name}.astype(float)"),
            };
            return Err(PyTypeError::new_err(format!(
                "{name}: dtype {dtype} is neither float64 nor float32 in the byte order of this machine ({remedy})"
            )));
        }
        if array.is_empty() {
            return Err(PyValueError::new_err(format!(
                "{name}: shape (0,) holds no sample (pass one at least)"
            )));
        }
        if !array.is_aligned() {
            return Err(PyValueError::new_err(format!(
                "{name}: its samples do not lie at multiples of their size (pass {name}.copy())"
            )));
        }
        let signal = match x.extract::<PyReadonlyArray1<'py, f64>>() {
            Ok(double) => Self::Double(double),
            Err(_) => Self::Single(x.extract::<PyReadonlyArray1<'py, f32>>()?),
        };
        match signal.samples().not_finite() {
            Some((at, value)) => Err(PyValueError::new_err(format!(
                "{name}[{at}]: {value} is no sample (cut it out or put a number in its place)"
            ))),
            None => Ok(signal),
        }
    }

    /// The samples.
    pub fn samples(&self) -> Samples<'_> {
        match self {
            Self::Double(x) => Samples::Double(x.as_array()),
            Self::Single(x) => Samples::Single(x.as_array()),
        }
    }
}

impl Samples<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Double(x) => x.len(),
            Self::Single(x) => x.len(),
        }
    }

    /// Hands every sample to `take`.
    #[inline(always)]
    pub fn each(&self, take: impl FnMut(f64)) {
        match self {
            Self::Double(x) => x.iter().copied().for_each(take),
            Self::Single(x) => x.iter().map(|x| f64::from(*x)).for_each(take),
        }
    }

    /// A copy, for work that needs all of it at once.
    pub fn to_vec(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.len());
        self.each(|x| out.push(x));
        out
    }

    /// Place and value of the first sample that `is` not.
    pub fn first_that_is_not(&self, is: impl Fn(f64) -> bool) -> Option<(usize, f64)> {
        match self {
            Self::Double(x) => x.iter().copied().enumerate().find(|(_, x)| !is(*x)),
            Self::Single(x) => {
                let mut wide = x.iter().map(|x| f64::from(*x)).enumerate();
                wide.find(|(_, x)| !is(*x))
            }
        }
    }

    fn not_finite(&self) -> Option<(usize, f64)> {
        self.first_that_is_not(f64::is_finite)
    }
}
