//! Do host and target compute the same bits? One word that tells.

use rarma_core::Real;

/// What [`function_bits`] gave on the host when this was written.
pub const FUNCTION_BITS: u32 = 0x1DB4_514B;

/// The functions of the signal path over a fixed sequence, folded into one word.
/// Host and target tests both compare it with [`FUNCTION_BITS`].
pub fn function_bits() -> u32 {
    let (mut hash, mut seed) = (0u32, 7u32);
    for _ in 0..1000 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let x = core::hint::black_box((seed >> 8) as f32 / 8_388_608.0 - 1.0);
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
    hash
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_host_computes_the_bits_it_did() {
        assert_eq!(super::function_bits(), super::FUNCTION_BITS);
    }
}
