//! Why the exciter's arithmetic refuses.

use core::fmt;

/// Cause of a refusal; nothing is computed from such input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CersError {
    /// A setting is not finite or out of its documented range.
    OutOfRange {
        /// Its name.
        name: &'static str,
    },
    /// Lists that belong together differ in length.
    DifferentLengths,
    /// Fewer measurements than the unknowns need.
    TooFew {
        /// Least number.
        needed: usize,
    },
    /// A measurement is NaN or infinite.
    NotFinite {
        /// Its place, from 0.
        index: usize,
    },
    /// The measurements do not tell the unknowns apart: a calibration at one gap
    /// separates no gap offset from the gain.
    Singular,
    /// The rounds of a fit did not come to rest.
    NotSettled,
    /// Asks for more than the arrays hold.
    AboveCapacity,
    /// No line is left in the band once the spindle's orders are dodged.
    NoLines,
}

impl fmt::Display for CersError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::DifferentLengths => write!(f, "lists that belong together differ in length"),
            Self::TooFew { needed } => write!(f, "too few measurements: {needed} are needed"),
            Self::NotFinite { index } => write!(f, "measurement {index} is not a finite number"),
            Self::Singular => write!(f, "the measurements do not determine every constant"),
            Self::NotSettled => write!(f, "the fit does not come to rest"),
            Self::AboveCapacity => write!(f, "more than there is room for"),
            Self::NoLines => write!(f, "no line of the band is clear of the spindle's orders"),
        }
    }
}

impl core::error::Error for CersError {}

/// `Ok` when `low ≤ x ≤ high`; NaN is out of range.
pub(super) fn within<T: PartialOrd>(
    x: T,
    low: T,
    high: T,
    name: &'static str,
) -> Result<(), CersError> {
    if x >= low && x <= high {
        Ok(())
    } else {
        Err(CersError::OutOfRange { name })
    }
}
