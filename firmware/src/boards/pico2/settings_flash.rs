//! The flash of the settings: the last 32 KB of the Pico's 4 MB, which the map leaves out (memory/pico2.x).

use super::basics::feed_watchdog;
use crate::board::WATCHDOG_US;
use core::ops::Range;
use embassy_rp::flash::{Blocking, Error, Flash};
use embassy_rp::peripherals::FLASH;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// The flash, bytes.
pub(super) const FLASH_BYTES: usize = 4 << 20;
/// Eight sectors: four to each half of the store.
pub(super) const RANGE: Range<u32> = (4 << 20) - (32 << 10)..4 << 20;
/// What the erase of a sector may take at most, µs: 400 ms by the data sheet of the W25Q32 (45 ms as a
/// rule), and as much again. No program runs until it is over, so that nobody can feed.
const ERASE_US: u64 = 800_000;

type Driver = Flash<'static, FLASH, Blocking, FLASH_BYTES>;

/// The flash, for the store of settings.
#[allow(missing_debug_implementations)] // the HAL's driver has none
pub struct SettingsFlash(pub(super) Driver);

impl ErrorType for SettingsFlash {
    type Error = Error;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = <Driver as ReadNorFlash>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        FLASH_BYTES
    }
}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = <Driver as NorFlash>::WRITE_SIZE;
    const ERASE_SIZE: usize = <Driver as NorFlash>::ERASE_SIZE;

    /// Erases sector by sector, each with a time of its own from the watchdog.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        for sector in (from..to).step_by(Self::ERASE_SIZE) {
            feed_watchdog(ERASE_US);
            let done = self
                .0
                .blocking_erase(sector, to.min(sector + Self::ERASE_SIZE as u32));
            feed_watchdog(WATCHDOG_US);
            done?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.blocking_write(offset, bytes)
    }
}
