//! NUCLEO-G474RE: STM32G474RE, Cortex-M4F.
//!
//! Numbers and the pin table are here for every machine; registers, the HAL and unsafe
//! code only in an image for this board.

pub mod scaling;
pub mod timing;
#[macro_use]
pub mod wiring;

// Unsafe, for they reach the chip's registers and its flash, and memory that interrupts or a reset share
// with them. One attribute each: the formatter does not look into a macro.
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod bridges;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod chip;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod clock;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
mod clock_tree;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod injected;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod link;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod memory;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod outputs;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
mod random;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod samples;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod settings_flash;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod slow;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod supply;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
#[allow(unsafe_code)]
mod tacho;

#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
pub use chip::Nucleo;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
pub use clock::crystal_has_failed;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
pub use outputs::LastResort;
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
pub use settings_flash::{MemoryError, memory_failed};
#[cfg(all(target_os = "none", feature = "board-nucleo-g474re"))]
pub use slow::NucleoError;
