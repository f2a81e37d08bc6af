//! Parts that speak embedded-hal, over simulated plants: any driver can be tried against them, and each
//! fails on demand.
//!
//! | part | trait | what |
//! |---|---|---|
//! | [`SimInput`], [`SimOutput`] | `InputPin`, `OutputPin` | the ends of a [`Wire`] |
//! | [`SimRelay`] | `OutputPin` | a gate with a contact to read back |
//! | [`SimPwm`] | `SetDutyCycle` | what drives a valve; a plant takes its duty |
//! | [`SpiAdc`] | `SpiDevice` | eight channels of 12 bits, as the MCP3208 |
//! | [`I2cAdc`] | `I2c` | four channels of 12 or 16 bits, as the ADS1015 and ADS1115 |
//! | [`SimTime`] | `DelayNs`, [`Clock`](firmware::Clock) | time that goes on where something takes some |
//!
//! [`SimRig`](crate::SimRig) has its contacts, gate and valve made of them by way of
//! [`firmware::parts`].

mod i2c_adc;
mod pin;
mod pwm;
mod spi_adc;
mod time;

pub use i2c_adc::{AdcBits, I2cAdc};
pub use pin::{PinError, SimInput, SimOutput, SimRelay, Wire};
pub use pwm::SimPwm;
pub use spi_adc::SpiAdc;
pub use time::{NoTime, SimTime};

use std::cell::Cell;
use std::rc::Rc;

/// Something that is wrong as long as it is so; copies are the same one.
#[derive(Debug, Clone, Default)]
pub struct Trouble(Rc<Cell<bool>>);

impl Trouble {
    /// From now on it is so, or not.
    pub fn set(&self, stands: bool) {
        self.0.set(stands);
    }

    /// Whether it is so.
    pub fn stands(&self) -> bool {
        self.0.get()
    }
}
