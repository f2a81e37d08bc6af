//! NUCLEO-G474RE: STM32G474RE, Cortex-M4F.
//!
//! Numbers and the pin table are here for every machine; registers, the HAL and unsafe
//! code only in an image for this board.

pub mod scaling;
pub mod timing;
#[macro_use]
pub mod wiring;

/// What needs the chip.
macro_rules! on_the_chip {
    ($($item:item)*) => { $(
        #[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
        #[allow(unsafe_code)]
        $item
    )* };
}

on_the_chip! {
    mod bridges;
    mod chip;
    mod clock;
    mod injected;
    mod link;
    mod samples;
    mod settings_flash;
    mod slow;
    mod supply;
    mod tacho;
    pub use chip::Nucleo;
    pub use settings_flash::{MemoryError, memory_failed};
    pub use slow::{LastResort, NucleoError};
}
