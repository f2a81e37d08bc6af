//! Settings of a pair.

use crate::condition::Band;
use crate::monitor::{MonitorConfig, MonitorError};

/// Settings of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairConfig {
    /// Settings of each channel; the rates must be equal. The first one's threshold
    /// is the pair's.
    pub channels: [MonitorConfig; 2],
    /// Where each sensor can hear at all, Hz. Default: the band of its monitor. A
    /// sensor is deaf outside: there the other does not wait for it.
    pub hears: [Option<Band>; 2],
    /// A mode that only one of two sensors calls must have been suspect for this many
    /// confirmation times before the pair calls it, 1 and more, default
    /// [`ALONE_CONFIRMATIONS`]. Infinite: both must call it (8 instead of 20 calls of a
    /// mode of 1.5 % in 6.4 min), and what only one hears is missed.
    pub alone_confirmations: f64,
}

/// Default of [`PairConfig::alone_confirmations`].
pub const ALONE_CONFIRMATIONS: f64 = 2.0;

impl PairConfig {
    /// Two sensors with the same settings.
    pub fn new(monitor: MonitorConfig) -> Self {
        Self {
            channels: [monitor; 2],
            hears: [None; 2],
            alone_confirmations: ALONE_CONFIRMATIONS,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn check(&self) -> Result<(), PairError> {
        for (i, config) in self.channels.iter().enumerate() {
            config
                .check()
                .map_err(|error| PairError::Channel(i as u8, error))?;
        }
        if self.channels[0].fs_hz != self.channels[1].fs_hz {
            return Err(PairError::Rates);
        }
        let ordered = |b: &Band| b.low_hz >= 0.0 && b.high_hz > b.low_hz;
        if !self.hears.iter().flatten().all(ordered) {
            return Err(PairError::Hears);
        }
        match self.alone_confirmations >= 1.0 {
            true => Ok(()),
            false => Err(PairError::Alone),
        }
    }
}

/// Why a pair cannot be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PairError {
    /// The settings of channel `0`.
    Channel(u8, MonitorError),
    /// The two channels must have one sampling rate.
    Rates,
    /// Where a sensor hears must start at 0 Hz or above and end above that.
    Hears,
    /// The confirmations of a sensor alone must be 1 or more.
    Alone,
}
