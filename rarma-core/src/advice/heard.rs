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

/// What came of a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<T> {
    /// It was stable.
    Stable,
    /// It chattered.
    Chatter {
        /// The frequency and its standard deviation, Hz, where it was heard.
        f_hz: Option<(T, T)>,
    },
}

/// Another cut with the same tool and structure: it may have been of another depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownCut<T> {
    /// Speed of the spindle, turns a second, > 0.
    pub spindle_hz: T,
    /// Depth of cut over that of the cut that is asked about, > 0; 1: as deep.
    pub depth: T,
    /// What came of it.
    pub outcome: Outcome<T>,
}

impl<T: Real> KnownCut<T> {
    /// One as deep that was stable.
    pub fn stable(spindle_hz: T) -> Self {
        Self {
            spindle_hz,
            depth: T::ONE,
            outcome: Outcome::Stable,
        }
    }

    /// One as deep that chattered, at a frequency and its standard deviation, Hz, if it was heard.
    pub fn chattered(spindle_hz: T, f_hz: Option<(T, T)>) -> Self {
        Self {
            outcome: Outcome::Chatter { f_hz },
            ..Self::stable(spindle_hz)
        }
    }

    /// The same at another depth, over that of the cut that is asked about.
    #[must_use]
    pub fn of_depth(self, depth: T) -> Self {
        Self { depth, ..self }
    }

    /// Whether it was stable.
    pub fn is_stable(&self) -> bool {
        self.outcome == Outcome::Stable
    }

    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), AdviceError> {
        let positive = |x: T| x > T::ZERO && x.is_finite();
        if !positive(self.spindle_hz) {
            return Err(AdviceError::Speed);
        }
        if !positive(self.depth) {
            return Err(AdviceError::Depth);
        }
        if let Outcome::Chatter {
            f_hz: Some((f_hz, sd)),
        } = self.outcome
        {
            if !positive(f_hz) {
                return Err(AdviceError::Frequency);
            }
            if !(sd >= T::ZERO && sd.is_finite()) {
                return Err(AdviceError::Deviation);
            }
        }
        Ok(())
    }
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
