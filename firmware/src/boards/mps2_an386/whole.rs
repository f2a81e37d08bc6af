//! The whole box on the emulated board: link on the first UART, settings in memory, a sound
//! made here, and nothing that could be energised.
//!
//! There is no enable input, no power stage and no sensor: arming is refused, by name. Time
//! is the host's, so what is heard in how long says nothing about a chip.

use super::TimerClock;
use super::memory::{MemoryFlash, SECTOR, SECTORS};
use super::resonance::{RATE_HZ, Resonance};
use super::uart::Uart;
use crate::board::{
    AdcCode, Block, BoardError, BoardErrorKind, BoxBoard, COILS, Clock, CoilBridge, Contacts,
    DacCode, Emergency, GAPS, Lights, Origin, Pulse, ResetCause, SensorCodes,
};
use crate::current_loop::{CoilOrder, CoilReport, CurrentLoop, MainSide};
use core::ops::Range;
use cortex_m_semihosting::{nr, syscall1};
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;

/// Samples that may lie untaken before they count as lost.
const RING: u64 = 2048;

/// What this board does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absent {
    /// A power stage, valve or gate.
    Output,
    /// A converter.
    Converter,
    /// Room in the link.
    Link,
}

impl BoardError for Absent {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::Output => BoardErrorKind::Refused,
            Self::Converter => BoardErrorKind::Converter,
            Self::Link => BoardErrorKind::Busy,
        }
    }
}

/// No bridges.
#[derive(Debug)]
struct NoBridges;

impl CoilBridge for NoBridges {
    type Error = Absent;

    fn currents(&mut self) -> Result<[AdcCode; COILS], Absent> {
        Err(Absent::Converter)
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        [AdcCode(0); GAPS]
    }

    fn set_duty(&mut self, _: [f32; COILS]) -> Result<(), Absent> {
        Err(Absent::Output)
    }

    fn off(&mut self) {}

    fn broken(&mut self) -> Option<u8> {
        None
    }

    fn rearm(&mut self) {}
}

/// The board.
#[derive(Debug)]
pub struct Mps2Box {
    clock: TimerClock,
    uart: Uart,
    sound: Resonance,
    coils: CurrentLoop,
    main_side: MainSide,
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
            uart: Uart::start(),
            sound: Resonance::new(),
            coils: CurrentLoop::new(),
            main_side: MainSide::default(),
            flash: MemoryFlash::default(),
            kept: [0; KEPT_BYTES],
            taken: 0,
        }
    }
}

impl Emergency for Mps2Box {
    fn drop_outputs(&mut self) {}

    fn now_us(&mut self) -> u64 {
        self.clock.now_us()
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.kept = *bytes;
    }
}

impl BoxBoard for Mps2Box {
    type Error = Absent;
    type Flash = MemoryFlash;

    const NAME: &'static str = "mps2-an386";
    const SAMPLE_RATE_HZ: f64 = RATE_HZ as f64;
    const LOOP_RATE_HZ: f64 = 1000.0;

    fn wait(&mut self) {
        self.uart.drain();
    }

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, Absent> {
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

    fn pulse(&mut self) -> Option<Pulse> {
        None
    }

    fn coils(&mut self, order: &CoilOrder) -> CoilReport {
        let report = self.main_side.exchange(&mut self.coils, order);
        self.coils.period(&mut NoBridges);
        report.unwrap_or_default()
    }

    fn excite(&mut self, signal: &Source) {
        self.coils.excite(signal);
    }

    fn sensors(&mut self) -> Result<SensorCodes, Absent> {
        Err(Absent::Converter)
    }

    fn valve(&mut self, _: DacCode) -> Result<(), Absent> {
        Err(Absent::Output)
    }

    fn contacts(&mut self) -> Contacts {
        Contacts {
            enable: false,
            stop_chain: true,
        }
    }

    fn energise(&mut self) -> Result<(), Absent> {
        Err(Absent::Output)
    }

    fn energised(&mut self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {}

    fn reset_cause(&mut self) -> ResetCause {
        ResetCause::PowerOn
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.kept
    }

    /// The host's clock in whole seconds, and this board's: not the same in two runs that
    /// start in different seconds, and anybody can foresee it. There is nothing here to
    /// energise.
    fn entropy(&mut self) -> u32 {
        // SAFETY: SYS_TIME takes no parameter and only returns a number.
        let seconds = unsafe { syscall1(nr::TIME, 0) } as u32;
        (seconds << 8) ^ self.now_us() as u32
    }

    fn flash(&mut self) -> (&mut MemoryFlash, Range<u32>) {
        (&mut self.flash, 0..(SECTOR * SECTORS) as u32)
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Absent> {
        Ok(self.uart.receive(bytes))
    }

    /// The emulator's UART, wherever that is led to: nothing can be energised.
    fn origin(&mut self) -> Origin {
        Origin::OwnPort
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), Absent> {
        if self.uart.send(frame) {
            Ok(())
        } else {
            Err(Absent::Link)
        }
    }

    fn lights(&mut self, _: Lights) {}
}
