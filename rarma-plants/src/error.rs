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
    /// Whether there is a limit is not known: the search used up its work.
    GivenUp,
    /// The eigenvalues of a delay equation did not settle: nothing is known of it.
    Unsettled,
    /// What would have to be worked out or stored is beyond any use.
    TooLarge {
        /// Field whose value makes it so.
        name: &'static str,
        /// Largest number of steps.
        most: usize,
    },
}

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::WrongLength { name } => write!(f, "{name} has the wrong number of entries"),
            Self::NoLimit => write!(f, "no stability limit in the searched range"),
            Self::GivenUp => write!(
                f,
                "the search for the stability limit was given up: too much work (a higher speed_rpm or a lower f_hz needs less)"
            ),
            Self::Unsettled => write!(f, "the eigenvalues of the cut did not settle"),
            Self::TooLarge { name, most } => write!(
                f,
                "{name} makes more than {most} steps (a higher speed or a lower f_hz needs fewer)"
            ),
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
