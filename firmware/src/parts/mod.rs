//! A board's verbs made of embedded-hal parts: a port hands over pins, and gets the verb.
//!
//! Which trait gives which verb, and an example: docs/porting.md.
//!
//! No part panics. One that fails says which it is ([`PartFailed`]), and where something could be energised
//! it is read as what is safe: a contact that cannot be read is open, a gate whose read-back cannot be read is
//! not as ordered, which the box calls a fault of the gate.

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

impl From<PartFailed> for BoardErrorKind {
    fn from(part: PartFailed) -> Self {
        part.kind()
    }
}

/// The example of the page.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/porting.md")]
struct Porting;

#[cfg(test)]
mod tests;
