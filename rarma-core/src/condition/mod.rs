//! Samples in: health, offset, band-pass, decimation.
//!
//! Words: *full scale*, the largest value the converter can give; *band*, the
//! frequencies that are analysed; *decimated rate*, the rate the estimator runs at.

mod band;
mod biquad;
mod comb;
mod fir;
mod health;
mod lines;
mod multiples;
mod phase_loop;
mod pulse;
mod sliced_fft;
mod speed;
mod spindle_lines;
#[cfg(test)]
mod spindle_tests;
mod tacho;
#[cfg(test)]
mod tacho_tests;

pub use band::{Band, BandError, BandFilter, TOP_FRACTION};
pub use biquad::{Biquad, BiquadState, Pass, ZERO_FRACTION};
pub use comb::{MOST_PEAKS, TOLERANCE_BINS};
pub use fir::{FirStage, MAX_TAPS, STOP_DB};
pub use health::{
    CLIP_MEMORY_S, CLIPPED_FRACTION, Fault, HOLD_S, Health, HealthCounts, LARGEST, STUCK_S,
};
pub use lines::{KnownLines, LinesError};
pub use pulse::{LEVEL_MEMORY_S, PulseDetector};
pub use sliced_fft::SlicedFft;
pub use speed::{
    CHANCE_BLIND, CHANCE_TOLD, Comb, FRAME, Finding, SPACING_HZ, SpeedFinder, SpeedFinderConfig,
    SpeedFinderError, TOLD_RANGE,
};
pub use spindle_lines::{
    LINES_TAU_S, Lock, SPEED_WANDER, SpindleLines, SpindleLinesConfig, SpindleLinesError,
};
pub use tacho::{Tacho, TachoConfig, TachoError, TachoFault, TachoReading};
