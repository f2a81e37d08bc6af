//! A board's verbs made of embedded-hal parts: a port hands over pins, and gets the verb.
//!
//! | verb | traits | part |
//! |---|---|---|
//! | [`BoxBoard::contacts`](crate::BoxBoard::contacts) | two `InputPin` | [`ContactPins`] |
//! | [`BoxBoard::energise`](crate::BoxBoard::energise), `energised`, `drop_outputs` | `OutputPin`, `InputPin`, `DelayNs` | [`Gate`] |
//! | [`BoxBoard::valve`](crate::BoxBoard::valve) | `SetDutyCycle` | [`PwmValve`] |
//! | [`BoxBoard::sensors`](crate::BoxBoard::sensors) | `SpiDevice` | [`SpiConverter`], a channel at a time |
//! | [`BoxBoard::lights`](crate::BoxBoard::lights), [`Listener::lights`](crate::board::Listener::lights) | `OutputPin` | [`LightPins`], [`OneLight`] |
//! | [`Board::Samples`](crate::Board::Samples) | `DelayNs`, and any driver | [`Polled`] |
//! | `receive`, `send` | `embedded_io::{Read, ReadReady, Write, WriteReady}` | [`PortLink`] |
//!
//! embedded-hal has no trait for what these need, so that they stay the board's own: a converter with DMA
//! (`samples` at 48 kHz), the bridges and their trip, the tacho's capture, the watchdog.
//!
//! No part panics. One that fails says which it is ([`PartFailed`]), and where something could be energised
//! it is read as what is safe: a contact that cannot be read is open, a gate whose read-back cannot be read is
//! not as ordered, which the box calls a fault of the gate.
//!
//! ```
//! use embedded_hal::{delay::DelayNs, digital::{InputPin, OutputPin}, pwm::SetDutyCycle};
//! use firmware::board::{Contacts, DacCode, Lights};
//! use firmware::parts::{ContactPins, Gate, LightPins, NoPin, PartFailed, PwmValve};
//! # use core::convert::Infallible;
//!
//! fn verbs<I: InputPin, O: OutputPin<Error = Infallible>>(
//!     [enable, stop, read_back]: [I; 3], [gate, led]: [O; 2], pwm: impl SetDutyCycle, mut delay: impl DelayNs,
//! ) -> Result<Contacts, PartFailed> {
//!     let mut contacts = ContactPins::new(enable, stop);
//!     let mut gate = Gate::new(gate, read_back);
//!     let mut valve = PwmValve::new(pwm);
//!     let mut lights = LightPins::new(NoPin, led, NoPin);
//!     let closed = contacts.read();
//!     gate.close(closed, &mut delay)?;
//!     valve.set(DacCode::from_fraction(0.5), gate.is_closed())?;
//!     lights.show(Lights { energised: gate.is_closed(), ..Lights::default() });
//!     Ok(closed)
//! }
//! ```

mod contacts;
mod converter;
mod gate;
mod lights;
mod link;
mod polled;
mod valve;

pub use contacts::ContactPins;
pub use converter::SpiConverter;
pub use gate::Gate;
pub use lights::{LightPins, NoPin, OneLight};
pub use link::PortLink;
pub use polled::Polled;
pub use valve::PwmValve;

use crate::board::{BoardError, BoardErrorKind};

/// Which part failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartFailed {
    /// The stop chain is open, so that the gate may not close.
    StopChain,
    /// The gate's read-back does not say that it closed, or could not be read.
    Gate,
    /// The valve's PWM refused.
    Valve,
    /// The bus of a converter or gauge refused, or its driver did.
    Converter,
    /// The port of the link is down.
    Link,
    /// There is no room for the frame.
    Busy,
}

impl BoardError for PartFailed {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::StopChain | Self::Gate | Self::Valve => BoardErrorKind::Refused,
            Self::Converter => BoardErrorKind::Converter,
            Self::Link => BoardErrorKind::Disconnected,
            Self::Busy => BoardErrorKind::Busy,
        }
    }
}

#[cfg(test)]
mod tests;
