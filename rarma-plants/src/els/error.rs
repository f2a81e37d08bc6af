//! What a model of a system cannot be built from, or asked.

use core::fmt;

/// What a model cannot be built from, or asked.
#[derive(Clone, Debug, PartialEq)]
pub enum ElsModelError {
    /// A value is not finite or out of its range.
    OutOfRange {
        /// Its name.
        name: String,
    },
    /// Nothing holds part of the structure: this many motions cost no force.
    Singular {
        /// Motions without stiffness.
        free: usize,
    },
    /// The mass matrix is not positive: a segment without mass.
    Massless,
    /// The eigenvalues did not settle, or leave the range of numbers.
    Unsettled,
}

impl fmt::Display for ElsModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::Singular { free } => write!(
                f,
                "singular assembly: {free} rigid motion(s) are held by no joint, bearing or link"
            ),
            Self::Massless => write!(f, "a segment has no mass"),
            Self::Unsettled => write!(
                f,
                "the natural frequencies cannot be worked out: stiffness or mass leaves the range of numbers"
            ),
        }
    }
}

impl std::error::Error for ElsModelError {}

pub(super) fn check(ok: bool, name: &str) -> Result<(), ElsModelError> {
    if ok {
        Ok(())
    } else {
        Err(ElsModelError::OutOfRange {
            name: name.to_owned(),
        })
    }
}
