//! Lights, signal lamps, relays of lamps. One that fails is only dark: nothing depends on it.

use crate::board::Lights;
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin, PinState};

/// A pin that is not there.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A light each, high is lit.
#[derive(Debug)]
pub struct LightPins<A, E, W> {
    alive: A,
    energised: E,
    warning: W,
}

impl<A: OutputPin, E: OutputPin, W: OutputPin> LightPins<A, E, W> {
    /// Of these pins; [`NoPin`] where there is none.
    pub fn new(alive: A, energised: E, warning: W) -> Self {
        Self {
            alive,
            energised,
            warning,
        }
    }

    /// Shows them.
    pub fn show(&mut self, lights: Lights) {
        let _ = self.alive.set_state(PinState::from(lights.alive));
        let _ = self.energised.set_state(PinState::from(lights.energised));
        let _ = self.warning.set_state(PinState::from(lights.warning));
    }
}

/// One light for all: it blinks while the program runs, and stands while there is a warning.
#[derive(Debug)]
pub struct OneLight<P>(pub P);

impl<P: OutputPin> OneLight<P> {
    /// Shows them.
    pub fn show(&mut self, lights: Lights) {
        let _ = self
            .0
            .set_state(PinState::from(lights.alive || lights.warning));
    }
}
