//! What the turning spindle leaves in the samples: its speed by the sound or by a tacho,
//! and the lines it forces, found and taken out.
//!
//! Words: *line*, a steady tone; *comb*, lines at multiples of one spacing; *tacho*, a
//! sensor that gives pulses at each turn.

mod finder;
mod lines;
#[cfg(test)]
mod spindle_tests;
mod tacho;

pub use finder::{
    Comb, Finding, SlicedFft, SpeedFinder, SpeedFinderConfig, SpeedFinderError, TOLD_RANGE,
};
pub(crate) use lines::is_home_of_flip;
pub use lines::{
    FLIP_TAU_S, Lock, SPEED_WANDER, SpindleLines, SpindleLinesConfig, SpindleLinesError,
};
pub use tacho::{
    LEVEL_MEMORY_S, PulseDetector, Tacho, TachoConfig, TachoError, TachoFault, TachoReading,
};
