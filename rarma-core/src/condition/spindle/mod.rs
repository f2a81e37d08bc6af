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
    CHANCE_BLIND, CHANCE_TOLD, Comb, FRAME, Finding, MOST_PEAKS, SPACING_HZ, SlicedFft,
    SpeedFinder, SpeedFinderConfig, SpeedFinderError, TOLD_RANGE, TOLERANCE_BINS,
};
pub use lines::{
    FLIP_TAU_S, HIGHEST_FLIP_HALVES, LINES_TAU_S, Lock, SPEED_WANDER, SpindleLines,
    SpindleLinesConfig, SpindleLinesError, is_home_of_flip,
};
pub use tacho::{
    LEVEL_MEMORY_S, PulseDetector, Tacho, TachoConfig, TachoError, TachoFault, TachoReading,
};
