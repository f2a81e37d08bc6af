//! Numbers that nobody can foresee: the chip's random number generator (RM0440, 26).
//!
//! Its noise source is analogue and tested by the chip at every word. One that does not
//! answer, or whose test fails, leaves the chip's own number, the time and the last bits of
//! the converters: not the same in two runs, most likely, but a few bits at best to whoever
//! tries them all.

use super::clock;
use embassy_stm32::pac::{ADC4, ADC5, RCC, RNG, UID};

/// The generator's first word takes the longest, well below this, µs.
const MOST_US: u64 = 500;

/// Starts the generator. Its clock, HSI48, runs by now.
pub(super) fn start() {
    RCC.ahb2enr().modify(|w| w.set_rngen(true));
    // The register's clock must run before it is written.
    let _ = RCC.ahb2enr().read();
    RNG.cr().modify(|w| w.set_rngen(true));
}

/// A number for this moment.
pub(super) fn number() -> u32 {
    generated().unwrap_or_else(mixed)
}

/// A word of the generator; none if it does not answer in time or its test has failed.
fn generated() -> Option<u32> {
    let begun_us = clock::now_us();
    while clock::now_us() - begun_us < MOST_US {
        let state = RNG.sr().read();
        if state.seis() || state.ceis() {
            // Its words are no good any more; it starts anew, for the next number.
            RNG.sr().modify(|w| {
                w.set_seis(false);
                w.set_ceis(false);
            });
            RNG.cr().modify(|w| w.set_rngen(false));
            RNG.cr().modify(|w| w.set_rngen(true));
            return None;
        }
        if state.drdy() {
            // A word of 0 was read too late or is none.
            return Some(RNG.dr().read()).filter(|word| *word != 0);
        }
    }
    None
}

/// What there is without the generator.
fn mixed() -> u32 {
    let chip = (0..3).map(|n| UID.uid(n).read());
    let converters = (0..3).flat_map(|n| [ADC4.jdr(n).read().0, ADC5.jdr(n).read().0]);
    let time = clock::now();
    let words = chip
        .chain(converters)
        .chain([time as u32, (time >> 32) as u32]);
    // FNV-1a over words, and its high half folded in.
    let hash = words.fold(0xCBF2_9CE4_8422_2325u64, |hash, word| {
        (hash ^ u64::from(word)).wrapping_mul(0x100_0000_01B3)
    });
    (hash ^ (hash >> 32)) as u32
}
