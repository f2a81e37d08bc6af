//! What every part of the board needs: interrupts, clock, watchdog.

use embassy_rp::pac::{TIMER0, WATCHDOG};
use embassy_rp::peripherals::{PIO0, TRNG, USB};
use embassy_rp::{bind_interrupts, pio, trng, usb};

bind_interrupts!(pub(super) struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    TRNG_IRQ => trng::InterruptHandler<TRNG>;
    USBCTRL_IRQ => usb::InterruptHandler<USB>;
});

/// Microseconds since start-up.
pub(super) fn now_us() -> u64 {
    loop {
        let high = TIMER0.timerawh().read();
        let low = TIMER0.timerawl().read();
        if TIMER0.timerawh().read() == high {
            return u64::from(high) << 32 | u64::from(low);
        }
    }
}

/// Gives the watchdog so long from now on, µs.
pub(super) fn feed_watchdog(us: u64) {
    WATCHDOG.load().write(|w| w.set_load(us as u32));
}
