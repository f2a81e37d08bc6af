//! Raspberry Pi Pico 2: RP2350, Cortex-M33, with one INMP441 microphone. It only listens.
//!
//! The wire of the microphone is here for every machine; registers, the HAL and unsafe code only in an
//! image for this board. Pins: [`PINS`].

pub mod i2s;

// One attribute each: the formatter does not look into a macro.
#[cfg(all(target_os = "none", feature = "board-pico2"))]
#[allow(unsafe_code)]
mod basics;
#[cfg(all(target_os = "none", feature = "board-pico2"))]
#[allow(unsafe_code)]
mod chip;
#[cfg(all(target_os = "none", feature = "board-pico2"))]
mod link;
#[cfg(all(target_os = "none", feature = "board-pico2"))]
#[allow(unsafe_code)]
mod microphone;
#[cfg(all(target_os = "none", feature = "board-pico2"))]
mod settings_flash;

#[cfg(all(target_os = "none", feature = "board-pico2"))]
pub use chip::{LastResort, Pico2, Stalled, reset};
#[cfg(all(target_os = "none", feature = "board-pico2"))]
pub use link::serve;

/// What is wired to what: the microphone's pin, the Pico's name for its own, and its number on the board.
pub const PINS: [(&str, &str, &str); 6] = [
    ("SCK", "GP10", "14"),
    ("WS", "GP11", "15"),
    ("SD", "GP12", "16"),
    ("L/R", "GND", "13"),
    ("GND", "GND", "18"),
    ("VDD", "3V3(OUT)", "36"),
];

#[cfg(test)]
mod tests {
    use super::PINS;

    #[test]
    fn the_page_shows_this_wiring() {
        let page = include_str!("../../../../docs/porting.md");
        for (microphone, pin, number) in PINS {
            let row = format!("| {microphone} | {pin} | {number} |");
            assert!(page.contains(&row), "docs/porting.md must hold: {row}");
        }
    }
}
