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
pub use health::{CLIPPED_FRACTION, Fault, HOLD_S, Health, HealthCounts, LARGEST, STUCK_S};
pub use lines::{KnownLines, LinesError};
pub(crate) use spindle::is_home_of_flip;
pub use spindle::{
    Comb, FLIP_TAU_S, Finding, LEVEL_MEMORY_S, Lock, PulseDetector, SPEED_WANDER, SlicedFft,
    SpeedFinder, SpeedFinderConfig, SpeedFinderError, SpindleLines, SpindleLinesConfig,
    SpindleLinesError, TOLD_RANGE, Tacho, TachoConfig, TachoError, TachoFault, TachoReading,
};
