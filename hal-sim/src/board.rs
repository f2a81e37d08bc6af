//! A simulated board: microphone, link and clock behind the firmware's verbs.

use crate::microphone::Microphone;
use firmware::{Block, Board, BoardErrorKind, Clock};

/// A link that keeps what it is given, until it is taken, and that can be made to
/// refuse.
#[derive(Debug, Default)]
pub struct SimLink {
    bytes: Vec<u8>,
    /// Refuse every frame from now on: a cable that was pulled.
    pub broken: bool,
}

impl SimLink {
    /// Everything sent since the last call.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.bytes)
    }

    /// See [`Board::send`].
    ///
    /// # Errors
    /// It is broken.
    pub fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        if self.broken {
            return Err(BoardErrorKind::Disconnected);
        }
        self.bytes.extend_from_slice(frame);
        Ok(())
    }
}

/// The board.
#[derive(Debug)]
pub struct SimBoard {
    /// Its microphone.
    pub microphone: Microphone,
    /// Its link.
    pub link: SimLink,
}

impl SimBoard {
    /// A board that hears what the microphone hears.
    pub fn new(microphone: Microphone) -> Self {
        Self {
            microphone,
            link: SimLink::default(),
        }
    }
}

/// The time of the simulated world: the samples delivered so far, at the microphone's rate.
impl Clock for SimBoard {
    fn now_us(&mut self) -> u64 {
        (self.microphone.delivered() as f64 / self.microphone.fs_hz() * 1e6) as u64
    }
}

impl Board for SimBoard {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        self.microphone.samples(block)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        self.link.send(frame)
    }
}
