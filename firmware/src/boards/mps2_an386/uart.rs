//! The first UART of the emulated board (CMSDK APB UART), polled.

use core::convert::Infallible;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *mut u32 = 0x4000_4004 as *mut u32;
const CONTROL: *mut u32 = 0x4000_4008 as *mut u32;
const DIVIDER: *mut u32 = 0x4000_4010 as *mut u32;

const SEND_FULL: u32 = 1;
const RECEIVED: u32 = 2;
const ENABLE_BOTH: u32 = 3;
/// The least divider there is; the emulator sends at the pace of its other end.
const LEAST_DIVIDER: u32 = 16;

/// The UART: a byte each way.
#[derive(Debug)]
pub(super) struct Uart(());

impl Uart {
    /// Switches it on.
    pub(super) fn start() -> Self {
        // SAFETY: registers of this UART; nothing else uses them.
        unsafe {
            DIVIDER.write_volatile(LEAST_DIVIDER);
            CONTROL.write_volatile(ENABLE_BOTH);
        }
        Self(())
    }

    fn state(&self) -> u32 {
        // SAFETY: reading the state has no side effect.
        unsafe { STATE.read_volatile() }
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl ReadReady for Uart {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.state() & RECEIVED != 0)
    }
}

impl Read for Uart {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let mut taken = 0;
        for place in bytes {
            // The first one is waited for.
            while self.state() & RECEIVED == 0 {
                if taken > 0 {
                    return Ok(taken);
                }
            }
            // SAFETY: the data register is read only where a byte has come.
            *place = unsafe { DATA.read_volatile() } as u8;
            taken += 1;
        }
        Ok(taken)
    }
}

impl WriteReady for Uart {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.state() & SEND_FULL == 0)
    }
}

impl Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let Some(byte) = bytes.first() else {
            return Ok(0);
        };
        while self.state() & SEND_FULL != 0 {}
        // SAFETY: a write to the data register sends a byte.
        unsafe { DATA.write_volatile(u32::from(*byte)) };
        Ok(1)
    }

    /// What was written is on its way.
    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
