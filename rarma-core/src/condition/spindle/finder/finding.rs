//! What the speed finder is asked, and what it answers.

use crate::condition::Band;
use crate::real::Real;
use crate::visit::{State, StateVisitor, state};

/// What [`SpeedFinder`](super::SpeedFinder) is to look for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedFinderConfig {
    /// Rate of the (decimated) samples, Hz.
    pub fs_hz: f64,
    /// Where lines are looked for.
    pub band: Band,
    /// Told speed of the spindle, Hz; none: any spacing.
    pub told_hz: Option<f64>,
    /// Teeth, where known: their lines alone may prove a told speed.
    pub teeth: Option<u32>,
}

/// Lines at multiples of one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Comb<T> {
    /// Spacing, Hz: the spindle's frequency where it was told; else that of the
    /// spindle or of its teeth, whichever the sound shows.
    pub spacing_hz: T,
    /// Standard deviation of it, Hz.
    pub sd_hz: T,
    /// Lines found on multiples.
    pub lines: u32,
    /// Upper bound on the chance that random lines look like it.
    pub chance: T,
}

state! { Comb<T> { spacing_hz, sd_hz, lines, chance } }

/// Answer of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding<T> {
    /// The lines, if any, tell no speed.
    NotEstimable,
    /// A comb; at the told speed, if one was told.
    Found(Comb<T>),
    /// A comb, found twice in a row, and it is not that of the told speed.
    Contradiction {
        /// What was told, Hz.
        told_hz: T,
        /// Spacing of the comb that is there, Hz.
        found_hz: T,
    },
}

impl<T: Real> State<T> for Finding<T> {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let (mut found, mut contradiction) = match *self {
            Self::NotEstimable => (None, None),
            Self::Found(comb) => (Some(comb), None),
            Self::Contradiction { told_hz, found_hz } => (None, Some((told_hz, found_hz))),
        };
        let fits = found.visit_state(visitor) && contradiction.visit_state(visitor);
        *self = match (found, contradiction) {
            (Some(comb), _) => Self::Found(comb),
            (None, Some((told_hz, found_hz))) => Self::Contradiction { told_hz, found_hz },
            (None, None) => Self::NotEstimable,
        };
        fits
    }
}

/// Why there is no finder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpeedFinderError {
    /// The sampling rate must be positive and finite.
    Rate,
    /// Band edges must be positive, in order, and below half the rate.
    Band,
    /// The told speed must be positive, at least 5 bins of the spectrum
    /// (5·fs/2048) and below the upper band edge.
    Told,
}
