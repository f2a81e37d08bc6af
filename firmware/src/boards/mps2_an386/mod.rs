//! The emulated board: an MPS2 with a Cortex-M4F (AN386), in QEMU.
//!
//! The microphone is a WAV and the link a file, both on the host through
//! semihosting. Files lie in QEMU's working directory and are called
//! [`JOB_FILE`], [`INPUT_FILE`] and [`OUTPUT_FILE`]. The whole box is another board on the
//! same machine, [`Mps2Box`]: its link is the first UART.
#![allow(unsafe_code)] // semihosting calls, registers of timer and UART

mod memory;
mod resonance;
mod uart;
mod whole;

pub use whole::Mps2Box;

use super::wav::{ByteSource, WavError, WavSource};
use crate::board::{Block, Board, BoardErrorKind, Clock};
use cortex_m_semihosting::{nr, syscall};
use rarma_box::wire::MonitorJob;

/// The job, as postcard.
pub const JOB_FILE: &str = "job.bin\0";
/// The recording.
pub const INPUT_FILE: &str = "in.wav\0";
/// Wire frames.
pub const OUTPUT_FILE: &str = "out.bin\0";

const MODE_READ_BINARY: usize = 1;
const MODE_WRITE_BINARY: usize = 5;

/// A file on the host.
#[derive(Debug)]
pub struct HostFile {
    handle: usize,
}

impl HostFile {
    /// Opens a file by its zero-terminated name; none if the host refuses.
    fn open(name: &str, mode: usize) -> Option<Self> {
        let block = [name.as_ptr() as usize, mode, name.len() - 1];
        // SAFETY: SYS_OPEN reads the three words and the zero-terminated name,
        // both of which outlive the call.
        let handle = unsafe { syscall(nr::OPEN, &block) };
        (handle != usize::MAX).then_some(Self { handle })
    }

    fn read(&mut self, buffer: &mut [u8]) -> usize {
        let block = [self.handle, buffer.as_mut_ptr() as usize, buffer.len()];
        // SAFETY: SYS_READ writes at most the given length into the buffer, which
        // is borrowed for the call.
        let left = unsafe { syscall(nr::READ, &block) };
        buffer.len().saturating_sub(left)
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let block = [self.handle, bytes.as_ptr() as usize, bytes.len()];
        // SAFETY: SYS_WRITE only reads the bytes, which outlive the call.
        let left = unsafe { syscall(nr::WRITE, &block) };
        bytes.len().saturating_sub(left)
    }
}

impl ByteSource for HostFile {
    fn read_bytes(&mut self, buffer: &mut [u8]) -> usize {
        self.read(buffer)
    }
}

/// CMSDK timer 0, counting down at 25 MHz. In the emulator it counts
/// instructions, not time; see docs/emulated-chip.md.
#[derive(Debug)]
pub struct TimerClock {
    last: u32,
    ticks: u64,
}

const TIMER0_CTRL: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER0_VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const TIMER0_RELOAD: *mut u32 = 0x4000_0008 as *mut u32;
const TIMER_TICKS_PER_US: u64 = 25;

impl TimerClock {
    fn start() -> Self {
        // SAFETY: the timer's registers on this board; nothing else uses them.
        unsafe {
            TIMER0_RELOAD.write_volatile(u32::MAX);
            TIMER0_VALUE.write_volatile(u32::MAX);
            TIMER0_CTRL.write_volatile(1);
        }
        Self {
            last: u32::MAX,
            ticks: 0,
        }
    }
}

impl Clock for TimerClock {
    fn now_us(&mut self) -> u64 {
        // SAFETY: reading the timer's value has no side effect.
        let now = unsafe { TIMER0_VALUE.read_volatile() };
        self.ticks += u64::from(self.last.wrapping_sub(now));
        self.last = now;
        self.ticks / TIMER_TICKS_PER_US
    }
}

/// The board.
#[derive(Debug)]
pub struct Mps2 {
    samples: WavSource<HostFile>,
    /// The link: frames are appended.
    output: HostFile,
    clock: TimerClock,
}

/// Why the board cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SetUpError {
    /// The job is missing or not one.
    Job,
    /// The frames have nowhere to go.
    Output,
    /// The recording is missing.
    Input,
    /// The recording is not read.
    Wav(WavError),
}

impl Mps2 {
    /// Reads the job and opens the recording and the output.
    ///
    /// # Errors
    /// The file that is missing or not what it should be.
    pub fn set_up() -> Result<(Self, MonitorJob), SetUpError> {
        let mut bytes = [0u8; 256];
        let mut file = HostFile::open(JOB_FILE, MODE_READ_BINARY).ok_or(SetUpError::Job)?;
        let n = file.read(&mut bytes);
        let content = bytes.get(..n).ok_or(SetUpError::Job)?;
        let job: MonitorJob = postcard::from_bytes(content).map_err(|_| SetUpError::Job)?;
        let output = HostFile::open(OUTPUT_FILE, MODE_WRITE_BINARY).ok_or(SetUpError::Output)?;
        let input = HostFile::open(INPUT_FILE, MODE_READ_BINARY).ok_or(SetUpError::Input)?;
        let samples = WavSource::open(input, job.channel).map_err(SetUpError::Wav)?;
        let board = Self {
            samples,
            output,
            clock: TimerClock::start(),
        };
        Ok((board, job))
    }
}

impl Clock for Mps2 {
    fn now_us(&mut self) -> u64 {
        self.clock.now_us()
    }
}

impl Board for Mps2 {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        Ok(Block {
            samples: self.samples.read(block),
            missing: 0,
        })
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        // A host that takes a part of it has no room on its disk.
        let is_whole = self.output.write(frame) == frame.len();
        is_whole.then_some(()).ok_or(BoardErrorKind::Disconnected)
    }
}
