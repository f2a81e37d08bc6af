//! The first UART of the emulated board (CMSDK APB UART), polled.

use heapless::Deque;

const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *mut u32 = 0x4000_4004 as *mut u32;
const CONTROL: *mut u32 = 0x4000_4008 as *mut u32;
const DIVIDER: *mut u32 = 0x4000_4010 as *mut u32;

const SEND_FULL: u32 = 1;
const RECEIVED: u32 = 2;
const ENABLE_BOTH: u32 = 3;
/// The least divider there is; the emulator sends at the pace of its other end.
const LEAST_DIVIDER: u32 = 16;

/// Bytes of frames that wait to be sent.
const WAITING: usize = 8192;

/// The UART with what waits to be sent.
#[derive(Debug, Default)]
pub(super) struct Uart {
    waiting: Deque<u8, WAITING>,
}

impl Uart {
    /// Switches it on.
    pub(super) fn start() -> Self {
        // SAFETY: registers of this UART; nothing else uses them.
        unsafe {
            DIVIDER.write_volatile(LEAST_DIVIDER);
            CONTROL.write_volatile(ENABLE_BOTH);
        }
        Self::default()
    }

    /// Takes a frame whole, or not at all.
    pub(super) fn send(&mut self, frame: &[u8]) -> bool {
        if self.waiting.capacity() - self.waiting.len() < frame.len() {
            return false;
        }
        for byte in frame {
            let _ = self.waiting.push_back(*byte);
        }
        self.drain();
        true
    }

    /// Gives the UART what it takes.
    pub(super) fn drain(&mut self) {
        // SAFETY: reading the state has no side effect; a write to the data register sends
        // a byte.
        while unsafe { STATE.read_volatile() } & SEND_FULL == 0 {
            let Some(byte) = self.waiting.pop_front() else {
                return;
            };
            unsafe { DATA.write_volatile(u32::from(byte)) };
        }
    }

    /// Takes the bytes that have come.
    pub(super) fn receive(&mut self, bytes: &mut [u8]) -> usize {
        let mut taken = 0;
        for place in bytes {
            // SAFETY: the data register is read only where a byte has come.
            if unsafe { STATE.read_volatile() } & RECEIVED == 0 {
                break;
            }
            *place = unsafe { DATA.read_volatile() } as u8;
            taken += 1;
        }
        taken
    }
}
