//! A proportional valve driven by PWM.

use super::PartFailed;
use crate::board::DacCode;
use embedded_hal::pwm::SetDutyCycle;

/// The valve, or the filter and amplifier before it: pressure is asked for by the duty, 0 vents.
#[derive(Debug)]
pub struct PwmValve<P>(P);

impl<P: SetDutyCycle> PwmValve<P> {
    /// On this channel, shut.
    pub fn new(pwm: P) -> Self {
        let mut this = Self(pwm);
        this.shut();
        this
    }

    /// Sets it: duty = code/65535 of the channel's range, rounded down; 0 while the gate is open.
    ///
    /// # Errors
    /// [`PartFailed::Valve`]: the channel refused; it has been asked for 0 then.
    pub fn set(&mut self, code: DacCode, gate_closed: bool) -> Result<(), PartFailed> {
        let code = if gate_closed { code.0 } else { 0 };
        self.0.set_duty_cycle_fraction(code, u16::MAX).map_err(|_| {
            self.shut();
            PartFailed::Valve
        })
    }

    /// Asks for 0. What a channel that refuses goes on doing ends with the gate, which supplies the valve.
    pub fn shut(&mut self) {
        let _ = self.0.set_duty_cycle(0);
    }
}
