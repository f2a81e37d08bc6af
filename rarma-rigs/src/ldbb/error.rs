//! Why a ball bar test cannot be evaluated.

use core::fmt;

/// Cause of a refusal; nothing is computed from such input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LdbbError {
    /// Fewer readings than the computation needs.
    TooFew {
        /// Least number.
        needed: usize,
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
    /// The readings cover less than half a circle.
    ShortArc {
        /// Degrees covered.
        covered_deg: f32,
    },
    /// The forces are all equal, or too few differ.
    EqualForces,
    /// The readings do not determine what is asked of them.
    Singular,
    /// A pressure beyond what the regulator gives.
    OutOfReach {
        /// Force along the bar that is needed, N.
        force_n: f32,
        /// Pressure that gives it, Pa.
        needed_pa: f32,
        /// Greatest pressure, Pa.
        most_pa: f32,
    },
    /// Less force than holds the bar while the machine moves.
    BelowHolding {
        /// Force along the bar, N.
        force_n: f32,
    },
}

impl fmt::Display for LdbbError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { needed } => write!(f, "too few readings: {needed} are needed"),
            Self::NotFinite { index } => write!(f, "reading {index} is not a finite number"),
            Self::OutOfRange { name } => write!(f, "{name} is out of its range"),
            Self::ShortArc { covered_deg } => write!(
                f,
                "the readings cover {covered_deg:.0}° of the circle: 180° are needed"
            ),
            Self::EqualForces => write!(f, "the forces are all equal"),
            Self::Singular => write!(f, "the readings do not determine what is asked"),
            Self::OutOfReach {
                force_n,
                needed_pa,
                most_pa,
            } => write!(
                f,
                "{force_n:.0} N along the bar need {:.2} bar, the regulator gives {:.2} bar",
                needed_pa * 1e-5,
                most_pa * 1e-5
            ),
            Self::BelowHolding { force_n } => write!(
                f,
                "{force_n:.1} N do not hold the bar while the machine moves: 36 N are needed"
            ),
        }
    }
}

impl core::error::Error for LdbbError {}
