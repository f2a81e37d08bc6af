//! Why receptances cannot be used.

use core::fmt;

/// Cause of a refusal; nothing is computed from such input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElsError {
    /// Frequencies and receptances, or two lists of them, differ in length.
    DifferentLengths,
    /// Fewer lines than the computation needs.
    TooFewLines {
        /// Least number of lines.
        needed: usize,
    },
    /// Frequencies do not rise from line to line, or one is negative.
    Grid {
        /// Its place, from 0.
        index: usize,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// Its place, from 0.
        index: usize,
    },
    /// A setting is out of its range.
    OutOfRange {
        /// Its name.
        name: &'static str,
    },
    /// The lines do not determine what is asked of them.
    Singular,
    /// More modes than the arrays hold.
    OrderAboveCapacity,
}

impl fmt::Display for ElsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DifferentLengths => {
                write!(f, "lists of frequencies or receptances differ in length")
            }
            Self::TooFewLines { needed } => write!(f, "too few lines: {needed} are needed"),
            Self::Grid { index } => write!(f, "the frequency of line {index} does not rise"),
            Self::NotFinite { index } => write!(f, "line {index} is not a finite number"),
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::Singular => write!(f, "the lines do not determine a model of this order"),
            Self::OrderAboveCapacity => write!(f, "more modes than there is room for"),
        }
    }
}

impl core::error::Error for ElsError {}
