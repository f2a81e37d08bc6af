//! The microphone's wire: the program that clocks it, the rates, and what a word of it means.
//! Pure; the test beside it runs the program against the microphone's data sheet.
//!
//! INMP441 (data sheet DS-INMP441-00, I²S data interface): 64 bits of SCK to a frame, WS low for the
//! left channel, WS changes where SCK falls. A bit is put out where SCK falls and taken where it rises. The
//! first of 24 comes one bit late; after the last the microphone lets the wire go.

use pio_core::{Assembler, InSource, JmpCondition, Program, SetDestination, SideSet};

/// Core, and with it the state machine, Hz: the HAL's default of a 12 MHz crystal.
pub const TICK_HZ: u32 = 150_000_000;
/// Samples per second, Hz.
pub const SAMPLE_HZ: u32 = 48_000;
/// Bits of SCK in a frame of two channels.
pub const BITS_PER_FRAME: u32 = 64;
/// Instructions to a bit: one with SCK low, one with SCK high.
pub const STEPS_PER_BIT: u32 = 2;
/// Bits of a sample.
pub const SAMPLE_BITS: u32 = 24;
/// Ticks of a frame. A whole number, so that the rate is the crystal's to the last digit, and each edge
/// of WS comes after the same number of ticks.
pub const TICKS_PER_SAMPLE: u32 = TICK_HZ / SAMPLE_HZ;
/// Ticks of an instruction in parts of 256, as the divider counts: 24 + 106/256. The part behind the
/// point adds up to 53 ticks in a frame, and no rest: SCK's edges are up to one tick (6.7 ns) late, the
/// same ones in every frame.
pub const DIVIDER_256: u32 = 256 * TICKS_PER_SAMPLE / (BITS_PER_FRAME * STEPS_PER_BIT);

const _: () = {
    assert!(TICKS_PER_SAMPLE * SAMPLE_HZ == TICK_HZ);
    assert!(DIVIDER_256 * BITS_PER_FRAME * STEPS_PER_BIT == 256 * TICKS_PER_SAMPLE);
    assert!(DIVIDER_256 == 24 * 256 + 106);
};

/// The microphone gives sound so many SCK cycles after it has got its supply and its clock (data sheet,
/// start-up), µs: 2^18 / 3.072 MHz, rounded up.
pub const START_UP_US: u64 = (1 << 18) * 1_000_000 / (SAMPLE_HZ * BITS_PER_FRAME) as u64 + 1;

/// Levels of the side-set pins: SCK is bit 0, WS bit 1.
const SCK: u8 = 0b01;
const WS: u8 = 0b10;

/// The program of the state machine: a frame a round, SCK and WS as side-set, the left sample shifted in
/// from the right end and pushed by itself when it has 24 bits. `set` goes one below the number of rounds.
#[must_use]
pub fn program() -> Program<32> {
    let mut code = Assembler::new_with_side_set(SideSet::new(false, 2, false));
    let (mut left, mut unused, mut right) = (code.label(), code.label(), code.label());
    // Bit 0, WS falls with SCK.
    code.set_with_side_set(SetDestination::X, SAMPLE_BITS as u8 - 1, 0);
    code.nop_with_side_set(SCK);
    // Bits 1 to 24, each taken where SCK rises.
    code.nop_with_side_set(0);
    code.bind(&mut left);
    code.in_with_side_set(InSource::PINS, 1, SCK);
    code.jmp_with_side_set(JmpCondition::XDecNonZero, &mut left, 0);
    // The last of these made bit 25 low. Bits 26 to 31.
    code.set_with_side_set(SetDestination::X, 5, SCK);
    code.bind(&mut unused);
    code.nop_with_side_set(0);
    code.jmp_with_side_set(JmpCondition::XDecNonZero, &mut unused, SCK);
    // Bit 32, WS rises. Bits 33 to 63.
    code.set_with_side_set(SetDestination::X, 30, WS);
    code.nop_with_side_set(SCK | WS);
    code.bind(&mut right);
    code.nop_with_side_set(WS);
    code.jmp_with_side_set(JmpCondition::XDecNonZero, &mut right, SCK | WS);
    code.assemble_program()
}

/// Samples that the clock expects after a time, µs: `us · 0.048`, rounded down, without overflow for as
/// long as a counter of microseconds lasts.
#[must_use]
pub fn expected(us: u64) -> u64 {
    // 48 kHz is 6 samples in 125 µs.
    us / 125 * 6 + us % 125 * 6 / 125
}

/// What a pushed word says, of full scale ±1: 24 bits, the sign first, at the right end. A sine of 94 dB SPL
/// is 26 dB below a sine of full scale (data sheet, sensitivity).
#[inline]
#[must_use]
pub fn sample(word: u32) -> f32 {
    const SPARE: u32 = u32::BITS - SAMPLE_BITS;
    const STEP: f32 = 1.0 / (1u32 << (SAMPLE_BITS - 1)) as f32;
    // The sign goes to the left end, and is spread on the way back.
    let code = (word << SPARE).cast_signed() >> SPARE;
    code as f32 * STEP
}

#[cfg(test)]
#[path = "i2s_test.rs"]
mod tests;
