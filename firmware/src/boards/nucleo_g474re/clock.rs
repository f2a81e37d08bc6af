//! The clock: TIM2 counts every tick of the core in 32 bits, its overflows are counted on.
//!
//! The same timer captures the tacho and wakes the core when samples are due, so that
//! everything that is ever compared is in the same ticks.

use super::timing;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::pac::{RCC, TIM2};
use embassy_stm32::peripherals;
use embassy_stm32::{Peri, rcc};

/// Overflows of the counter, each 26.3 s.
static OVERFLOWS: AtomicU32 = AtomicU32::new(0);

/// Every flag of TIM2 (RM0440, TIMx_SR): one that is written 1 stays as it is. What is no flag
/// is reserved, and stays 0.
const EVERY_FLAG: u32 = 0x00F0_1E5F;

/// Counts overflows, and ends a wait.
#[derive(Debug)]
pub(super) struct ClockInterrupt;

impl Handler<typelevel::TIM2> for ClockInterrupt {
    unsafe fn on_interrupt() {
        let flags = TIM2.sr().read();
        // Writing 1 leaves a flag as it is.
        TIM2.sr().write(|w| {
            w.0 = EVERY_FLAG;
            w.set_uif(!flags.uif());
            w.set_ccif(0, false);
        });
        if flags.uif() {
            let overflows = OVERFLOWS.load(Ordering::Relaxed);
            OVERFLOWS.store(overflows.wrapping_add(1), Ordering::Relaxed);
        }
    }
}

/// Starts the counter.
pub(super) fn start(timer: Peri<'static, peripherals::TIM2>) {
    rcc::enable_and_reset::<peripherals::TIM2>();
    // The counter runs for ever; nothing gives the timer back.
    core::mem::forget(timer);
    TIM2.arr().write_value(u32::MAX);
    TIM2.egr().write(|w| w.set_ug(true));
    TIM2.sr().write(|w| w.0 = 0);
    TIM2.dier().modify(|w| w.set_uie(true));
    TIM2.cr1().modify(|w| w.set_cen(true));
    // SAFETY: the handler is bound below in this board and needs nothing set up.
    unsafe { typelevel::TIM2::enable() };
}

/// Ticks since start-up.
pub(super) fn now() -> u64 {
    critical_section::with(|_| {
        let overflows = OVERFLOWS.load(Ordering::Relaxed);
        let count = TIM2.cnt().read();
        let (overflows, count) = if TIM2.sr().read().uif() {
            // Overflowed and not yet counted: a second look is surely after it.
            (overflows.wrapping_add(1), TIM2.cnt().read())
        } else {
            (overflows, count)
        };
        u64::from(overflows) << 32 | u64::from(count)
    })
}

/// Sleeps until a moment at most 13 s away. Interrupts before it are served, and the core sleeps on: the
/// current loop's comes every period and is nothing for the main side.
pub(super) fn sleep_until(moment: u64) {
    let moment = moment as u32;
    critical_section::with(|_| {
        TIM2.ccr(0).write_value(moment);
        TIM2.sr().write(|w| {
            w.0 = EVERY_FLAG;
            w.set_ccif(0, false);
        });
        TIM2.dier().modify(|w| w.set_ccie(0, true));
    });
    // Between the look and the sleep nothing is served: an interrupt that comes there is pending, and
    // ends the sleep at once.
    while critical_section::with(|_| {
        let ahead = moment.wrapping_sub(TIM2.cnt().read()) as i32 > 0;
        if ahead {
            cortex_m::asm::wfi();
        }
        ahead
    }) {}
    critical_section::with(|_| TIM2.dier().modify(|w| w.set_ccie(0, false)));
}

/// Microseconds since start-up.
pub(super) fn now_us() -> u64 {
    timing::microseconds(now())
}

/// From here on a crystal that stops raises the exception that cannot be masked and breaks the
/// bridges' timer, and the core goes on from its inner oscillator (RM0440, clock security system).
/// Without that it would stand still, with every switch as it is.
pub(super) fn watch_crystal() {
    RCC.cr().modify(|w| w.set_csson(true));
}

/// The crystal has stopped. To be asked by the handler of that exception; takes the flag back.
pub fn crystal_has_failed() -> bool {
    let failed = RCC.cifr().read().cssf();
    if failed {
        RCC.cicr().write(|w| w.set_cssc(true));
    }
    failed
}
