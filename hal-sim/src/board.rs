//! A simulated board: microphone, link and clock behind the firmware's verbs.

use crate::microphone::Microphone;
use firmware::{Board, Clock, Parts};
use std::cell::Cell;
use std::rc::Rc;

/// A clock that shows the time of the simulated world: the samples delivered so
/// far, at the microphone's rate.
#[derive(Debug, Clone)]
pub struct SimClock {
    pub(crate) samples: Rc<Cell<u64>>,
    fs_hz: f64,
}

impl Clock for SimClock {
    fn now_us(&mut self) -> u64 {
        (self.samples.get() as f64 / self.fs_hz * 1e6) as u64
    }
}

/// A link that keeps what it is given, until it is taken, and that can be made to
/// refuse.
#[derive(Debug, Default)]
pub struct SimLink {
    bytes: Vec<u8>,
    /// Refuse every write from now on: a cable that was pulled.
    pub broken: bool,
}

impl SimLink {
    /// Everything written since the last call.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.bytes)
    }
}

impl embedded_io::ErrorType for SimLink {
    type Error = embedded_io::ErrorKind;
}

impl embedded_io::Write for SimLink {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        if self.broken {
            return Err(embedded_io::ErrorKind::NotConnected);
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
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
    clock: SimClock,
}

impl SimBoard {
    /// A board that hears what the microphone hears.
    pub fn new(microphone: Microphone) -> Self {
        let clock = SimClock {
            samples: microphone.delivered(),
            fs_hz: microphone.fs_hz(),
        };
        Self {
            microphone,
            link: SimLink::default(),
            clock,
        }
    }
}

impl Board for SimBoard {
    type Samples = Microphone;
    type Link = SimLink;
    type Clock = SimClock;

    fn parts(&mut self) -> Parts<'_, Self> {
        Parts {
            samples: &mut self.microphone,
            link: &mut self.link,
            clock: &mut self.clock,
        }
    }
}
