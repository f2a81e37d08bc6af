//! The whole box on the emulated board, a listener: link on the first UART, settings in memory, a
//! sound made here. Time is the host's, so what is heard in how long says nothing about a chip.

use super::TimerClock;
use super::memory::{MemoryFlash, SECTOR, SECTORS};
use super::resonance::{RATE_HZ, Resonance};
use super::uart::Uart;
use crate::board::{Block, Board, Clock, Listener, ResetCause};
use crate::parts::{PartFailed, PortLink};
use core::ops::Range;
use cortex_m_semihosting::{nr, syscall1};
use rarma_box::guard::KEPT_BYTES;

/// Samples that may lie untaken before they count as lost.
const RING: u64 = 2048;
/// Bytes of frames that wait to be sent.
const WAITING: usize = 8192;

/// The board.
#[derive(Debug)]
pub struct Mps2Box {
    clock: TimerClock,
    link: PortLink<Uart, WAITING>,
    sound: Resonance,
    flash: MemoryFlash,
    kept: [u8; KEPT_BYTES],
    /// Samples given or lost.
    taken: u64,
}

impl Mps2Box {
    /// Starts timer and UART.
    pub fn set_up() -> Self {
        Self {
            clock: TimerClock::start(),
            link: PortLink::new(Uart::start()),
            sound: Resonance::new(),
            flash: MemoryFlash::default(),
            kept: [0; KEPT_BYTES],
            taken: 0,
        }
    }
}

impl Clock for Mps2Box {
    fn now_us(&mut self) -> u64 {
        self.clock.now_us()
    }
}

impl Board for Mps2Box {
    type Error = PartFailed;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, PartFailed> {
        let due = self.now_us() * RATE_HZ as u64 / 1_000_000;
        let missing = (due - self.taken).saturating_sub(RING);
        self.taken += missing;
        let samples = block.len().min((due - self.taken) as usize);
        for place in block.iter_mut().take(samples) {
            *place = self.sound.next();
        }
        self.taken += samples as u64;
        Ok(Block {
            samples,
            missing: missing as u32,
        })
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), PartFailed> {
        self.link.send(frame)
    }
}

impl Listener for Mps2Box {
    type Flash = MemoryFlash;

    const NAME: &'static str = "mps2-an386";
    const SAMPLE_RATE_HZ: f64 = RATE_HZ as f64;

    fn wait(&mut self) {
        // A UART does not fail.
        let _ = self.link.pump();
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, PartFailed> {
        self.link.receive(bytes)
    }

    fn flash(&mut self) -> (&mut MemoryFlash, Range<u32>) {
        (&mut self.flash, 0..(SECTOR * SECTORS) as u32)
    }

    /// The host's clock in whole seconds, and this board's: not the same in two runs that
    /// start in different seconds, and anybody can foresee it. There is nothing here to
    /// energise.
    fn entropy(&mut self) -> u32 {
        // SAFETY: SYS_TIME takes no parameter and only returns a number.
        let seconds = unsafe { syscall1(nr::TIME, 0) } as u32;
        (seconds << 8) ^ self.now_us() as u32
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.kept = *bytes;
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.kept
    }

    fn reset_cause(&mut self) -> ResetCause {
        ResetCause::PowerOn
    }

    fn feed_watchdog(&mut self) {}
}
