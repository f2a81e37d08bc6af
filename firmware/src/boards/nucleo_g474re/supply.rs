//! The controller's own supply: what happens when it falls.
//!
//! Below 2.9 V the supply's monitor breaks the bridges' timer by itself, and its interrupt
//! opens the rest: power stage, valve. Should the brown-out reset follow, which happens below
//! the option byte's level, the record of this moment is there after it.

use super::outputs::LastResort;
use crate::last_words::last_words;
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::pac::{EXTI, PWR};
use rarma_box::guard::FaultCode;

/// The monitor's line of the interrupt controller.
const LINE: usize = 16;
/// Its threshold, 2.9 V (RM0440, PWR_CR2).
const LEVEL: u8 = 6;

/// The supply has fallen.
#[derive(Debug)]
pub(super) struct SupplyInterrupt;

impl Handler<typelevel::PVD_PVM> for SupplyInterrupt {
    unsafe fn on_interrupt() {
        last_words(&mut LastResort, FaultCode::BrownOut, 0.0);
        // Writing 1 takes the request back.
        EXTI.pr(0).write(|w| w.set_line(LINE, true));
    }
}

/// Starts the monitor. A supply that is low already is found when the gate is to be closed.
pub(super) fn start() {
    PWR.cr2().modify(|w| {
        w.set_pls(LEVEL);
        w.set_pvde(true);
    });
    EXTI.rtsr(0).modify(|w| w.set_line(LINE, true));
    EXTI.imr(0).modify(|w| w.set_line(LINE, true));
    // SAFETY: the handler is bound in this board and needs registers only.
    unsafe { typelevel::PVD_PVM::enable() };
}

/// The supply is below the monitor's threshold.
pub(super) fn is_low() -> bool {
    PWR.sr2().read().pvdo()
}
