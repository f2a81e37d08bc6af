//! Samples in: health, offset, band-pass, decimation.
//!
//! Words: *full scale*, the largest value the converter can give; *band*, the
//! frequencies that are analysed; *decimated rate*, the rate the estimator runs at.

mod band;
mod biquad;
mod fir;
mod health;
mod lines;

pub use band::{Band, BandError, BandFilter, TOP_FRACTION};
pub use biquad::{Biquad, BiquadState, Pass, ZERO_FRACTION};
pub use fir::{FirStage, MAX_TAPS, STOP_DB};
pub use health::{
    CLIP_MEMORY_S, CLIPPED_FRACTION, Fault, HOLD_S, Health, HealthCounts, LARGEST, STUCK_S,
};
pub use lines::{KnownLines, LinesError};
