//! The flash of the settings, of which a spoilt word does not stop the box.
//!
//! Every double word has check bits. One whose programming a power cut ended may have two
//! bits wrong: reading it raises the exception that cannot be masked, breaks the bridges'
//! timer, and gives what is there (RM0440, error code correction of the flash). Here that is
//! counted and told; the store above checks what it was given and takes the other copy. The
//! same error anywhere else means that the program cannot be trusted; see [`memory_failed`].
//!
//! One wrong bit is mended by the flash and raises nothing: its flag is looked at after every
//! read, and told too, for where one bit has gone another may follow.

use crate::board::FlashSeen;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use embassy_stm32::flash::{Blocking, Error, Flash};
use embassy_stm32::pac::flash::regs::Eccr;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::pac::{FLASH, IWDG};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Bytes of a bank.
const BANK: u32 = 0x4_0000;

/// Settings are being read: an error now is theirs.
static READING: AtomicBool = AtomicBool::new(false);
static UNREADABLE: AtomicU32 = AtomicU32::new(0);
static CORRECTED: AtomicU32 = AtomicU32::new(0);

/// What the exception that cannot be masked is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryError {
    /// A word of the settings; it has been counted, and the program may go on.
    Settings,
    /// A word of the program, at this address from the start of the flash.
    Program(u32),
    /// None of the flash's.
    Other,
}

/// Why the exception that cannot be masked has come. To be asked by its handler, once, with
/// the outputs off.
///
/// An error while settings are read is taken for theirs, whatever address the chip gives: to
/// take it for the program's would turn one spoilt word into a box that resets for ever.
pub fn memory_failed() -> MemoryError {
    let errors = FLASH.eccr().read();
    if !(errors.eccd() || errors.eccd2()) {
        return MemoryError::Other;
    }
    // Writing 1 takes the flags back.
    FLASH.eccr().write_value(errors);
    if READING.load(Ordering::Relaxed) {
        UNREADABLE.fetch_add(1, Ordering::Relaxed);
        return MemoryError::Settings;
    }
    MemoryError::Program(word_of(&errors))
}

/// Words of the settings that could not be read, or not without help, since the last call.
pub(super) fn seen() -> FlashSeen {
    FlashSeen {
        unreadable_words: UNREADABLE.swap(0, Ordering::Relaxed),
        corrected_words: CORRECTED.swap(0, Ordering::Relaxed),
    }
}

/// Takes the flag of a mended bit back, and says in which word it was, from the start of the
/// flash. The flag holds the first such word since it was last taken back.
fn take_corrected() -> Option<u32> {
    let seen = FLASH.eccr().read();
    if !seen.eccc() {
        return None;
    }
    // Writing 1 takes a flag back; the one of a double error is the exception's.
    let mut taken = seen;
    taken.set_eccd(false);
    taken.set_eccd2(false);
    FLASH.eccr().write_value(taken);
    Some(word_of(&seen))
}

/// The word of an error, from the start of the flash.
fn word_of(errors: &Eccr) -> u32 {
    let bank = if errors.bk_ecc() { BANK } else { 0 };
    bank + errors.addr_ecc()
}

/// The flash, for the store of settings.
#[allow(missing_debug_implementations)] // the HAL's driver has none
pub struct SettingsFlash(pub(super) Flash<'static, Blocking>);

impl ErrorType for SettingsFlash {
    type Error = Error;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = <Flash<'static, Blocking> as ReadNorFlash>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        // An older one of the program's would hide this read's.
        take_corrected();
        READING.store(true, Ordering::SeqCst);
        let result = self.0.read(offset, bytes);
        // The exception of the last load comes before what follows.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        READING.store(false, Ordering::SeqCst);
        let read = offset..offset + bytes.len() as u32;
        if take_corrected().is_some_and(|word| read.contains(&word)) {
            CORRECTED.fetch_add(1, Ordering::Relaxed);
        }
        result
    }

    fn capacity(&self) -> usize {
        ReadNorFlash::capacity(&self.0)
    }
}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = <Flash<'static, Blocking> as NorFlash>::WRITE_SIZE;
    const ERASE_SIZE: usize = <Flash<'static, Blocking> as NorFlash>::ERASE_SIZE;

    /// Erases page by page, up to 25 ms each, and feeds the watchdog before every one: a start
    /// that mends worn pages erases four of them in one step, which by itself would be as long as
    /// the watchdog waits. A program that goes round in erases is ended by its callers' limits.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        for page in (from..to).step_by(Self::ERASE_SIZE) {
            IWDG.kr().write(|w| w.set_key(Key::RESET));
            self.0.erase(page, to.min(page + Self::ERASE_SIZE as u32))?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.write(offset, bytes)
    }
}
