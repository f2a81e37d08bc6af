//! A channel of a timer.

use super::Trouble;
use embedded_hal::pwm::{Error, ErrorKind, ErrorType, SetDutyCycle};
use std::cell::Cell;
use std::rc::Rc;

/// The timer refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PwmError;

impl Error for PwmError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A channel of 65535 steps; copies are the same one, so that a plant sees the duty that a board sets.
#[derive(Debug, Clone, Default)]
pub struct SimPwm {
    duty: Rc<Cell<u16>>,
    /// It refuses every order, and its output is low.
    pub refuses: Trouble,
}

impl SimPwm {
    /// Part of the time that the output is high, in parts of 65535.
    pub fn duty(&self) -> u16 {
        if self.refuses.stands() {
            0
        } else {
            self.duty.get()
        }
    }
}

impl ErrorType for SimPwm {
    type Error = PwmError;
}

impl SetDutyCycle for SimPwm {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), PwmError> {
        if self.refuses.stands() {
            self.duty.set(0);
            return Err(PwmError);
        }
        self.duty.set(duty);
        Ok(())
    }
}
