//! A NOR flash that can lose its power at any byte.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::store;
use rarma_core::settings::{SETTINGS, Setting};
use std::collections::BTreeSet;
use std::ops::Range;

/// Smallest write, bytes: a double word with its check bits, as on the G4.
pub const WORD: usize = 8;
/// Erase sector, bytes.
pub const SECTOR: usize = 2048;
/// Sectors for settings.
pub const SECTORS: usize = 4;

/// Numbers that no setting has.
const FOREIGN: Range<u16> = 1000..3000;

/// Why the flash did not do it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlashError {
    /// The power went away.
    PowerLost,
    /// Outside the flash or off the grid.
    Range,
    /// The word is not erased: its check bits cannot be written twice, except by zeros.
    NotErased,
    /// It is worn out.
    Worn,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Range => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The flash.
#[derive(Debug, Clone)]
pub struct SimFlash {
    bytes: Vec<u8>,
    /// Bytes that can still be written or erased before the power goes away.
    pub power_for: Option<usize>,
    /// Every write and erase fails from now on.
    pub worn: bool,
    touched: usize,
    dead: bool,
    /// Words whose writing was cut short: their check bits do not fit.
    spoilt: BTreeSet<usize>,
    unreadable: u32,
}

impl Default for SimFlash {
    fn default() -> Self {
        Self {
            bytes: vec![0xFF; SECTOR * SECTORS],
            power_for: None,
            worn: false,
            touched: 0,
            dead: false,
            spoilt: BTreeSet::new(),
            unreadable: 0,
        }
    }
}

impl SimFlash {
    /// Power is back; what was written is what is there.
    pub fn power_up(&mut self) {
        self.dead = false;
        self.power_for = None;
    }

    /// Whether the power went away during an operation.
    pub fn lost_power(&self) -> bool {
        self.dead
    }

    /// Records of numbers that no setting has, until there is no room: a later firmware's.
    /// Once; the second call finds no room.
    pub fn fill(&mut self) {
        let range = 0..(SECTOR * SECTORS) as u32;
        for number in FOREIGN {
            let foreign = Setting {
                number,
                ..SETTINGS[0]
            };
            let value = Some(foreign.default_value());
            if store::write(self, range.clone(), &foreign, value).is_err() {
                return;
            }
        }
    }

    /// Spoilt words that were read since the last call.
    pub fn take_unreadable(&mut self) -> u32 {
        std::mem::take(&mut self.unreadable)
    }

    /// Bytes written and erased so far.
    pub fn touched(&self) -> usize {
        self.touched
    }

    /// The content.
    pub fn content(&mut self) -> &mut [u8] {
        &mut self.bytes
    }

    /// One byte of a write or an erase; false once the power is gone.
    fn touch(&mut self, at: usize, value: u8) -> bool {
        if let Some(left) = &mut self.power_for {
            if *left == 0 {
                self.dead = true;
                return false;
            }
            *left -= 1;
        }
        self.touched += 1;
        self.bytes[at] = value;
        true
    }

    fn check(&self, from: u32, to: u32, grid: usize) -> Result<(), FlashError> {
        if self.dead {
            return Err(FlashError::PowerLost);
        }
        let (from, to) = (from as usize, to as usize);
        if from > to
            || to > self.bytes.len()
            || !from.is_multiple_of(grid)
            || !to.is_multiple_of(grid)
        {
            return Err(FlashError::Range);
        }
        Ok(())
    }
}

impl ErrorType for SimFlash {
    type Error = FlashError;
}

impl ReadNorFlash for SimFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.check(offset, offset + bytes.len() as u32, 1)?;
        let from = offset as usize;
        let words = from / WORD..(from + bytes.len()).div_ceil(WORD);
        self.unreadable += self.spoilt.range(words).count() as u32;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for SimFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.check(from, to, SECTOR)?;
        if self.worn {
            return Err(FlashError::Worn);
        }
        for at in from as usize..to as usize {
            if !self.touch(at, 0xFF) {
                return Err(FlashError::PowerLost);
            }
            self.spoilt.remove(&(at / WORD));
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.check(offset, offset + bytes.len() as u32, WORD)?;
        if self.worn {
            return Err(FlashError::Worn);
        }
        let from = offset as usize;
        let (words, _) = bytes.as_chunks::<WORD>();
        for (k, word) in words.iter().enumerate() {
            let at = from + k * WORD;
            let erased = self.bytes[at..at + WORD].iter().all(|b| *b == 0xFF);
            if !erased && *word != [0; WORD] {
                return Err(FlashError::NotErased);
            }
        }
        for (k, &byte) in bytes.iter().enumerate() {
            let word = (from + k) / WORD;
            if !self.touch(from + k, byte) {
                if k % WORD > 0 {
                    self.spoilt.insert(word);
                }
                return Err(FlashError::PowerLost);
            }
            if k % WORD == WORD - 1 {
                self.spoilt.remove(&word);
            }
        }
        Ok(())
    }
}
