//! Settings of the removal of the spindle's lines.

use crate::condition::Band;
use crate::visit::choice;

/// Default memory of the amplitudes, s.
const LINES_TAU_S: f64 = 0.3;
/// Memory of the amplitude of a line where flip chatter may grow, s: what runout leaves
/// there is steady.
pub const FLIP_TAU_S: f64 = 3.0;
/// Default for how fast the speed may wander: relative change in √s.
pub const SPEED_WANDER: f64 = 2e-3;

/// Settings of [`SpindleLines`](super::SpindleLines).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleLinesConfig {
    /// Rate of the (decimated) samples, Hz.
    pub fs_hz: f64,
    /// Lines outside are left alone.
    pub band: Band,
    /// Teeth, where known; 1 where the frequency told is that of the teeth.
    pub teeth: Option<u32>,
    /// Memory of the amplitudes, s, 0.02..=10: notch half-width 1/(2π·τ).
    pub tau_s: f64,
    /// How fast the speed may wander: standard deviation of its relative change over
    /// √(1 s), 1e-6..=0.1. Ramps are faster: [`SPEED_WANDER`] follows 10 %/s.
    pub wander: f64,
}

impl SpindleLinesConfig {
    /// Defaults at a rate, in a band.
    pub fn new(fs_hz: f64, band: Band) -> Self {
        Self {
            fs_hz,
            band,
            teeth: None,
            tau_s: LINES_TAU_S,
            wander: SPEED_WANDER,
        }
    }
}

/// Why there are no lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpindleLinesError {
    /// The sampling rate must be finite and at least 200 Hz.
    Rate,
    /// Band edges must be positive, in order, and below half the rate.
    Band,
    /// 1 to 1000 teeth.
    Teeth,
    /// Memory out of range.
    Memory,
    /// Wander out of range.
    Wander,
}

/// What the lines hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lock {
    /// No speed was given, or its lines are not yet there: nothing is removed.
    #[default]
    Searching,
    /// The lines are there and are removed.
    Locked,
    /// They were there, or were expected for 1 s, and are not: nothing is removed
    /// until a speed is given again.
    Lost,
}

choice!(Lock: Searching, Locked, Lost);
