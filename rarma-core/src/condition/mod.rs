//! Samples in: health, offset, band-pass, decimation, removal of forced lines.
//!
//! Words: *full scale*, the largest value the converter can give; *band*, the
//! frequencies that are analysed; *decimated rate*, the rate the estimator runs at.

mod band;
mod biquad;
mod fir;
mod health;
mod lines;
mod spindle;

pub use band::{Band, BandError, BandFilter, TOP_FRACTION};
pub use biquad::{Biquad, BiquadState, Pass, ZERO_FRACTION};
pub use fir::{FirStage, MAX_TAPS, STOP_DB};
pub use health::{
    CLIP_MEMORY_S, CLIPPED_FRACTION, Fault, HOLD_S, Health, HealthCounts, LARGEST, STUCK_S,
};
pub use lines::{KnownLines, LinesError};
pub use spindle::{
    CHANCE_BLIND, CHANCE_TOLD, Comb, FLIP_TAU_S, FRAME, Finding, HIGHEST_FLIP_HALVES,
    LEVEL_MEMORY_S, LINES_TAU_S, Lock, MOST_PEAKS, PulseDetector, SPACING_HZ, SPEED_WANDER,
    SlicedFft, SpeedFinder, SpeedFinderConfig, SpeedFinderError, SpindleLines, SpindleLinesConfig,
    SpindleLinesError, TOLD_RANGE, TOLERANCE_BINS, Tacho, TachoConfig, TachoError, TachoFault,
    TachoReading, is_home_of_flip,
};
