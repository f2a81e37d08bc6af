//! Why a series cannot be fitted, or a model has no bound.

use core::fmt;

/// Cause of a refusal; nothing is computed from such input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FitError {
    /// The order exceeds the array it is to be stored in.
    OrderAboveCapacity,
    /// Order 0: there is nothing to estimate.
    NothingToEstimate,
    /// The series is shorter than this order needs.
    TooFewSamples {
        /// Least number of samples.
        needed: usize,
    },
    /// A sample is NaN or infinite.
    NotFinite {
        /// Its place, from 0.
        index: usize,
    },
    /// All samples are equal.
    Constant,
    /// The equations have no unique solution: the series is a sum of fewer
    /// undamped tones than the order could hold, or A and C share a root.
    Singular,
    /// A polynomial has a root on or outside the unit circle.
    NotStable,
    /// Input and output have not the same number of samples.
    DifferentLengths,
    /// A sample of the input is NaN or infinite.
    InputNotFinite {
        /// Its place, from 0.
        index: usize,
    },
    /// The input is constant, or has fewer lines than the model needs.
    NoExcitation,
    /// A number given besides the series is out of its range.
    OutOfRange,
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OrderAboveCapacity => write!(f, "the order is above the capacity"),
            Self::NothingToEstimate => write!(f, "an order of 0 has nothing to estimate"),
            Self::TooFewSamples { needed } => {
                write!(f, "too few samples: this order needs {needed}")
            }
            Self::NotFinite { index } => write!(f, "sample {index} is not a finite number"),
            Self::Constant => write!(f, "the series is constant"),
            Self::Singular => write!(f, "the series does not determine a model of this order"),
            Self::NotStable => write!(f, "a root lies on or outside the unit circle"),
            Self::DifferentLengths => write!(f, "input and output differ in length"),
            Self::InputNotFinite { index } => {
                write!(f, "sample {index} of the input is not a finite number")
            }
            Self::NoExcitation => write!(f, "the input does not excite a model of this order"),
            Self::OutOfRange => write!(f, "a setting is out of its range"),
        }
    }
}

impl core::error::Error for FitError {}
