//! Pins, and what is at the other end of the wire.

use super::Trouble;
use embedded_hal::digital::{Error, ErrorKind, ErrorType, InputPin, OutputPin};
use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;

/// A pin that cannot be read: its expander does not answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PinError;

impl Error for PinError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A wire that is high or low; copies are the same one.
#[derive(Debug, Clone, Default)]
pub struct Wire {
    high: Rc<Cell<bool>>,
    /// Its inputs cannot be read.
    pub unreadable: Trouble,
}

impl Wire {
    /// Whether it is high.
    pub fn is_high(&self) -> bool {
        self.high.get()
    }

    /// Somebody holds it there.
    pub fn hold(&self, high: bool) {
        self.high.set(high);
    }

    /// An input at this wire.
    pub fn input(&self) -> SimInput {
        SimInput(self.clone())
    }

    /// An output that drives this wire.
    pub fn output(&self) -> SimOutput {
        SimOutput(self.clone())
    }
}

/// An input of the board.
#[derive(Debug)]
pub struct SimInput(Wire);

impl ErrorType for SimInput {
    type Error = PinError;
}

impl InputPin for SimInput {
    fn is_high(&mut self) -> Result<bool, PinError> {
        if self.0.unreadable.stands() {
            return Err(PinError);
        }
        Ok(self.0.is_high())
    }

    fn is_low(&mut self) -> Result<bool, PinError> {
        self.is_high().map(|high| !high)
    }
}

/// An output of the chip itself: it cannot fail.
#[derive(Debug)]
pub struct SimOutput(Wire);

impl ErrorType for SimOutput {
    type Error = Infallible;
}

impl OutputPin for SimOutput {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.hold(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.hold(true);
        Ok(())
    }
}

/// A relay, or the enable of a power stage, with a contact that follows its order at once; copies are the
/// same one.
#[derive(Debug, Clone, Default)]
pub struct SimRelay {
    /// High while it is closed.
    pub contact: Wire,
    /// It does not open any more.
    pub welded: Trouble,
    /// It does not close.
    pub refuses: Trouble,
}

impl SimRelay {
    /// Whether it is closed.
    pub fn is_closed(&self) -> bool {
        self.contact.is_high()
    }
}

impl ErrorType for SimRelay {
    type Error = Infallible;
}

impl OutputPin for SimRelay {
    fn set_low(&mut self) -> Result<(), Infallible> {
        if !self.welded.stands() {
            self.contact.hold(false);
        }
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        if !self.refuses.stands() {
            self.contact.hold(true);
        }
        Ok(())
    }
}
