//! Boards: hardware, registers and unsafe code live here and nowhere else.

#[cfg(all(target_os = "none", feature = "board-mps2-an386"))]
pub mod mps2_an386;
pub mod nucleo_g474re;
pub mod pico2;
pub mod ring;
pub mod wav;
