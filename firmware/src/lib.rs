//! The sensor box: an application that is generic over a board.
//!
//! `board` names the verbs, `app` and the duties use them, `boards` supplies them
//! for one board each and is the only place with registers and unsafe code.
#![cfg_attr(not(test), no_std)]
#![deny(unsafe_code)]

/// What the functions of the signal path give over a fixed sequence, folded into one
/// word, on the host. The on-target test expects the same bits.
pub const HOST_FUNCTION_HASH: u32 = 0xE7DF_BCCB;

pub mod app;
pub mod board;
pub mod boards;
pub mod link;
pub mod monitor;

pub use app::{App, Outcome};
pub use board::{Block, Board, BoardError, BoardErrorKind, Clock, Parts, SampleSource};

#[cfg(test)]
mod tests {
    use rarma_core::Real;

    #[test]
    fn the_functions_fold_into_the_constant_the_target_expects() {
        let (mut hash, mut seed) = (0u32, 7u32);
        for _ in 0..1000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let x = (seed >> 8) as f32 / 8_388_608.0 - 1.0;
            let (s, c) = Real::sin_cos(x * 3.0);
            let values = [
                Real::sqrt(x.abs() + 1e-3),
                Real::ln_1p(x * 0.5),
                Real::atan2(x, 0.3),
                s,
                c,
            ];
            for v in values {
                hash = hash.rotate_left(5) ^ v.to_bits();
            }
        }
        assert_eq!(hash, super::HOST_FUNCTION_HASH);
    }
}
