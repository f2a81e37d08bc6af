//! The verbs a board supplies, each with its contract.
//!
//! The application names verbs; a board (real, emulated or simulated) supplies
//! them. There is no pin, register or HAL type in the application, and no
//! arithmetic in a board.
//!
//! Two applications use them: [`App`](crate::App) runs one job over a recording and needs
//! a [`Board`]; the whole box needs a [`BoxBoard`],
//! whose interrupt of the current converter runs a [`CurrentLoop`](crate::CurrentLoop)
//! over a [`CoilBridge`]. A board that only listens supplies a [`Listener`], which is half of that.

mod code;
mod coils;
mod listener;
mod order;
mod whole;

pub use code::{AdcCode, DacCode};
pub use coils::{COILS, CoilBridge};
pub use listener::Listener;
pub use order::{CoilAction, CoilLimits, CoilOrder, CoilReport, CoilTrip, ForceScale};
pub use whole::{
    BoxBoard, Contacts, Emergency, FlashSeen, GAPS, LEAST_BROWN_OUT_MV, Lights, Origin, Pulse,
    ResetCause, SensorCodes, WATCHDOG_US,
};

use core::fmt::Debug;

/// What kind of failure a board reports, so that the application can act without
/// knowing the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardErrorKind {
    /// The source could not be opened or is of a kind the board does not read.
    Source,
    /// The source has no such channel.
    Channel,
    /// The source broke off.
    SourceLost,
    /// The host's job could not be read.
    Job,
    /// A converter did not convert in time.
    Converter,
    /// A part refused an order: timer, converter, gate.
    Refused,
    /// A buffer is full; the same call may succeed later.
    Busy,
    /// The other end of a link is not there.
    Disconnected,
}

/// A board's error.
pub trait BoardError: Debug {
    /// Its kind.
    fn kind(&self) -> BoardErrorKind;
}

/// What a read brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Samples written to the front of the buffer; 0 when the source has ended
    /// (a recording), never 0 from a converter.
    pub samples: usize,
    /// Samples lost since the last read: overrun, dropped transfer.
    pub missing: u32,
}

/// Where samples come from: a converter with DMA, a recording, a simulation.
pub trait SampleSource {
    /// The board's error.
    type Error: BoardError;

    /// Waits for samples and writes at most `block.len()` of them, in the order of
    /// time, scaled so that full scale is the `full_scale` of the job.
    ///
    /// # Errors
    /// Once an error is returned, so is every later read.
    fn read(&mut self, block: &mut [f32]) -> Result<Block, Self::Error>;
}

/// A clock that only goes forward.
pub trait Clock {
    /// Microseconds since start-up. Never goes back, does not wrap within the life
    /// of the device.
    fn now_us(&mut self) -> u64;
}

/// A board that can run a monitor.
///
/// The link is an `embedded-io` writer: a write may block for as long as a frame
/// takes; one that returns an error has taken nothing.
pub trait Board {
    /// Its samples.
    type Samples: SampleSource;
    /// Its link to the host.
    type Link: embedded_io::Write;
    /// Its clock.
    type Clock: Clock;

    /// The parts, all at once, because the application uses them side by side.
    fn parts(&mut self) -> Parts<'_, Self>;
}

/// The parts of a board, borrowed.
#[derive(Debug)]
pub struct Parts<'a, B: Board + ?Sized> {
    /// Its samples.
    pub samples: &'a mut B::Samples,
    /// Its link to the host.
    pub link: &'a mut B::Link,
    /// Its clock.
    pub clock: &'a mut B::Clock,
}
