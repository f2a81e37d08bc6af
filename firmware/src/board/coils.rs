//! The fast side: four coils on half-bridges with current sense.
//!
//! Rate: once a PWM period, from the interrupt of the current converter. The board
//! owns a [`CurrentLoop`](crate::CurrentLoop) and a [`CoilBridge`] there; the main
//! side talks to the loop through [`BoxBoard::coils`](super::BoxBoard::coils) only.

use super::{AdcCode, BoardError};

/// Coils of the exciter: +X, −X, +Y, −Y, in this order.
pub const COILS: usize = 4;
/// Displacement sensors: X and Y.
pub const GAPS: usize = 2;

/// Four coils as the current loop sees them.
///
/// Contract for failure: whatever goes wrong, [`Self::off`] works, and a bridge that
/// has been off stays off until `set_duty` is called again **and** the output gate
/// ([`BoxBoard::energise`](super::BoxBoard::energise)) is on. A coil carries current in
/// one direction only.
pub trait CoilBridge {
    /// The board's error.
    type Error: BoardError;

    /// Currents of this PWM period, in the order of the coils, sampled where the PWM
    /// ripple passes through its mean. A sensor that is disconnected reads an end of the
    /// range, never a plausible value: the board pulls its input there.
    ///
    /// # Errors
    /// The conversion of this period did not happen or was late: the values of the
    /// period before are not given again.
    fn currents(&mut self) -> Result<[AdcCode; COILS], Self::Error>;

    /// Displacement sensors X and Y of this PWM period, sampled with the currents: the gap of
    /// the + magnet, as in [`SensorCodes::gap`](super::SensorCodes::gap). Called after
    /// [`Self::currents`] has succeeded.
    fn gaps(&mut self) -> [AdcCode; GAPS];

    /// Mean voltage for the next period as a fraction of the supply, −1..=1: above 0
    /// drives the current up, below 0 drives it down against the supply. All four are
    /// taken over together at the next period's start.
    ///
    /// # Errors
    /// The timer refused; the outputs are then as after [`Self::off`].
    fn set_duty(&mut self, duty: [f32; COILS]) -> Result<(), Self::Error>;

    /// All switches open, at once, in the middle of a period too. The current of each
    /// coil runs down against the supply through the diodes. Always works.
    fn off(&mut self);

    /// The coil whose comparator has broken the timers since the last call, without any
    /// software. The break itself lasts until [`Self::rearm`].
    fn broken(&mut self) -> Option<u8>;

    /// Lets the timers run again after a break. Does not switch anything on.
    fn rearm(&mut self);
}
