//! The verbs a board supplies, each with its contract.
//!
//! The application names verbs; a board (real, emulated or simulated) supplies
//! them. There is no pin, register or HAL type in the application, and no
//! arithmetic in a board.
//!
//! Every board is a [`Board`]: samples in, frames out, a clock. A recording is no more, and a
//! [`Job`](crate::Job) listens to it. The whole box needs a [`BoxBoard`],
//! whose interrupt of the current converter runs a [`CurrentLoop`](crate::CurrentLoop)
//! over a [`CoilBridge`]. A board that only listens supplies a [`Listener`], which is half of that.

mod code;
mod coils;
mod listener;
mod order;
mod whole;

pub use code::{AdcCode, DacCode};
pub use coils::{COILS, CoilBridge, GAPS};
pub use listener::Listener;
pub use order::{CoilAction, CoilLimits, CoilOrder, CoilReport, CoilTrip, ForceScale};
pub use whole::{
    BoxBoard, Contacts, Emergency, FlashSeen, LEAST_BROWN_OUT_MV, Lights, Origin, Pulse,
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

/// A kind is an error as well, of a board that has nothing to add.
impl BoardError for BoardErrorKind {
    fn kind(&self) -> BoardErrorKind {
        *self
    }
}

/// What a look for samples brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Samples written to the front of the buffer.
    pub samples: usize,
    /// Samples lost since the last look: overrun, dropped transfer.
    pub missing: u32,
}

/// A clock that only goes forward.
pub trait Clock {
    /// Microseconds since start-up. Never goes back, does not wrap within the life
    /// of the device.
    fn now_us(&mut self) -> u64;
}

/// What every board supplies: samples in, frames out, a clock.
///
/// The board of a box does not wait for more than 50 µs in either verb. That of a recording
/// waits for samples, and for room for a frame.
pub trait Board: Clock {
    /// The board's error.
    type Error: BoardError;

    /// Takes the microphone samples there are, at most `block.len()`, in the order of time,
    /// full scale ±1. 0 samples when there are none yet; of a recording, when it has ended.
    /// `missing` counts what was lost since the last call, before the first sample given.
    ///
    /// # Errors
    /// The converter or its transfer failed; the next call may succeed again. Of a recording:
    /// it broke off.
    fn samples(&mut self, block: &mut [f32]) -> Result<Block, Self::Error>;

    /// Sends a frame, whole or not at all. What is accepted the board keeps until it is out.
    ///
    /// # Errors
    /// There is no room for it, or no link: nothing has been taken.
    fn send(&mut self, frame: &[u8]) -> Result<(), Self::Error>;
}
