//! Settings in memory: a NOR flash that forgets when the emulator ends.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Smallest write and erase sector, bytes: those of the real board's chip.
const WORD: usize = 8;
pub(super) const SECTOR: usize = 2048;
/// Sectors for settings.
pub(super) const SECTORS: usize = 4;
const BYTES: usize = SECTOR * SECTORS;

/// Outside, or off the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfRange;

impl NorFlashError for OutOfRange {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

/// The memory.
#[derive(Debug)]
pub struct MemoryFlash([u8; BYTES]);

impl Default for MemoryFlash {
    fn default() -> Self {
        Self([0xFF; BYTES])
    }
}

impl MemoryFlash {
    fn part(&mut self, from: u32, length: usize, grid: usize) -> Result<&mut [u8], OutOfRange> {
        let from = from as usize;
        if !from.is_multiple_of(grid) || !length.is_multiple_of(grid) {
            return Err(OutOfRange);
        }
        self.0.get_mut(from..from + length).ok_or(OutOfRange)
    }
}

impl ErrorType for MemoryFlash {
    type Error = OutOfRange;
}

impl ReadNorFlash for MemoryFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfRange> {
        bytes.copy_from_slice(self.part(offset, bytes.len(), 1)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for MemoryFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfRange> {
        let length = to.checked_sub(from).ok_or(OutOfRange)? as usize;
        self.part(from, length, SECTOR)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfRange> {
        for (there, byte) in self.part(offset, bytes.len(), WORD)?.iter_mut().zip(bytes) {
            // What is programmed can only lose ones.
            *there &= byte;
        }
        Ok(())
    }
}
