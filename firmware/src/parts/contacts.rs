//! The contacts of people and machines, as two pins.

use crate::board::Contacts;
use embedded_hal::digital::InputPin;

/// Enable input and emergency-stop chain: high is closed.
///
/// Both pins need a pull-down, so that a broken wire reads low. The chain has to open the gate by itself as
/// well, without a program: see [`Contacts`].
#[derive(Debug)]
pub struct ContactPins<E, S> {
    enable: E,
    stop_chain: S,
}

impl<E: InputPin, S: InputPin> ContactPins<E, S> {
    /// Of these two pins.
    pub fn new(enable: E, stop_chain: S) -> Self {
        Self { enable, stop_chain }
    }

    /// The contacts as they are now; one that cannot be read is open.
    pub fn read(&mut self) -> Contacts {
        Contacts {
            enable: self.enable.is_high().unwrap_or(false),
            stop_chain: self.stop_chain.is_high().unwrap_or(false),
        }
    }
}
