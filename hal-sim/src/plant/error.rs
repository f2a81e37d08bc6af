//! Errors of the plant models: raised by constructors, never by a step.

use core::fmt;

/// A parameter a plant cannot be built from.
///
/// The name is that of the field of the configuration struct, so that a
/// caller can point at the line of its own input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantError {
    /// The value is not finite or lies outside its documented range.
    OutOfRange {
        /// Field at fault.
        name: &'static str,
    },
    /// A list has the wrong number of entries.
    WrongLength {
        /// Field at fault.
        name: &'static str,
    },
    /// A search for a stability limit found none in the range it was given.
    NoLimit,
}

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::WrongLength { name } => write!(f, "{name} has the wrong number of entries"),
            Self::NoLimit => write!(f, "no stability limit in the searched range"),
        }
    }
}

impl std::error::Error for PlantError {}

/// `Ok` when `ok`, else `OutOfRange` naming the field.
pub(crate) fn require(ok: bool, name: &'static str) -> Result<(), PlantError> {
    if ok {
        Ok(())
    } else {
        Err(PlantError::OutOfRange { name })
    }
}

/// Finite and greater than zero.
pub(crate) fn positive(value: f64, name: &'static str) -> Result<(), PlantError> {
    require(value.is_finite() && value > 0.0, name)
}

/// Finite and not negative.
pub(crate) fn non_negative(value: f64, name: &'static str) -> Result<(), PlantError> {
    require(value.is_finite() && value >= 0.0, name)
}
