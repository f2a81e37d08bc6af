//! What was heard of a cut.

use super::config::AdviceError;
use crate::real::Real;

/// Chatter, and the speed it was heard at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeardChatter<T> {
    /// Its frequency, Hz, > 0: that of the strongest line, not of a sideband.
    pub f_hz: T,
    /// Standard deviation of it, Hz, ≥ 0.
    pub f_sd_hz: T,
    /// Speed of the spindle, turns a second, > 0.
    pub spindle_hz: T,
    /// Standard deviation of it, turns a second, ≥ 0.
    pub spindle_sd_hz: T,
    /// Teeth, 1 to 1000, taken for equally spaced.
    pub teeth: u32,
}

/// Of a list of known cuts so many count, the last: in single precision the weight of a case
/// that all of them contradict is still a number.
pub const MOST_KNOWN: usize = 16;

/// Another cut of the same depth that was heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownCut<T> {
    /// Speed of the spindle, turns a second, > 0.
    pub spindle_hz: T,
    /// It was stable; else it chattered.
    pub stable: bool,
}

impl<T: Real> HeardChatter<T> {
    /// Waves between two teeth, f/(n·N).
    pub fn waves(&self) -> T {
        self.f_hz / (self.spindle_hz * T::from_u32(self.teeth))
    }

    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), AdviceError> {
        let positive = |x: T| x > T::ZERO && x.is_finite();
        let deviation = |x: T| x >= T::ZERO && x.is_finite();
        if !positive(self.f_hz) {
            return Err(AdviceError::Frequency);
        }
        if !deviation(self.f_sd_hz) || !deviation(self.spindle_sd_hz) {
            return Err(AdviceError::Deviation);
        }
        if !positive(self.spindle_hz) {
            return Err(AdviceError::Speed);
        }
        if !(1..=1000).contains(&self.teeth) {
            return Err(AdviceError::Teeth);
        }
        Ok(())
    }
}
