//! The output gate: one pin that closes it, one that reads back whether it did.

use super::PartFailed;
use crate::board::Contacts;
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// How long the read-back may take to follow the order, in steps of 1 µs.
const SETTLE_US: u32 = 20;

/// The gate of all outputs: high is closed, at reset it is open by a pull-down.
///
/// Its order must be a pin of the chip itself, whose writes cannot fail: [`Self::open`] always works. Handlers
/// of panics and exceptions cannot borrow it and write the same pin's register
/// ([`Emergency`](crate::board::Emergency)).
#[derive(Debug)]
pub struct Gate<O, R> {
    order: O,
    read_back: R,
    ordered: bool,
}

impl<O: OutputPin<Error = Infallible>, R: InputPin> Gate<O, R> {
    /// Of these two pins, opened.
    pub fn new(order: O, read_back: R) -> Self {
        let mut this = Self {
            order,
            read_back,
            ordered: false,
        };
        this.open();
        this
    }

    /// Closes it, and waits for its read-back for 20 µs at most.
    ///
    /// # Errors
    /// [`PartFailed::StopChain`] when the chain is open, [`PartFailed::Gate`] when the read-back does not follow
    /// or cannot be read; the gate is open then.
    pub fn close(
        &mut self,
        contacts: Contacts,
        delay: &mut impl DelayNs,
    ) -> Result<(), PartFailed> {
        if !contacts.stop_chain {
            self.open();
            return Err(PartFailed::StopChain);
        }
        let Ok(()) = self.order.set_high();
        self.ordered = true;
        for _ in 0..SETTLE_US {
            match self.read_back.is_high() {
                Ok(true) => return Ok(()),
                Ok(false) => delay.delay_us(1),
                Err(_) => break,
            }
        }
        self.open();
        Err(PartFailed::Gate)
    }

    /// Opens it. Always works, any number of times.
    pub fn open(&mut self) {
        let Ok(()) = self.order.set_low();
        self.ordered = false;
    }

    /// The read-back. One that cannot be read is the opposite of what was ordered: the gate is not known to
    /// have obeyed, and the box says so ([`FaultCode::Gate`](rarma_box::guard::FaultCode::Gate)).
    pub fn is_closed(&mut self) -> bool {
        self.read_back.is_high().unwrap_or(!self.ordered)
    }
}
