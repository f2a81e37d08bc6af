//! Functions in single precision alone, with the same bits on every machine.
//!
//! `libm` makes the root bit by bit, sine and cosine in double precision (a software
//! routine on the target), and logarithm and arc tangent for arguments that never
//! come here. Polynomials: least largest error over the interval named.

/// Square root in single-precision multiplications: 1/√x by Newton from a bit
/// pattern, then one correction of the root itself. Within 1 unit in the last
/// place; a seventh of the instructions of the portable routine, and the same bits
/// on every machine. Negative numbers and NaN give NaN.
pub fn sqrt(x: f32) -> f32 {
    // Zero, subnormal, negative, NaN, infinite: the rare ones go the slow way. Normal
    // positive numbers have consecutive patterns.
    let (bits, first) = (x.to_bits(), f32::MIN_POSITIVE.to_bits());
    if bits.wrapping_sub(first) >= f32::INFINITY.to_bits() - first {
        return libm::sqrtf(x);
    }
    let half = 0.5 * x;
    let mut r = f32::from_bits(0x5F37_5A86 - (bits >> 1));
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    let root = x * r;
    root + 0.5 * r * (x - root * root)
}

/// Sine and cosine without double precision: reduction to ±π/4 in two parts, then
/// Taylor polynomials. Within 3e-7 for |x| < 10; made for angles per sample, 0 to π.
pub fn sin_cos(x: f32) -> (f32, f32) {
    const QUARTER_TURN: (f32, f32) = (1.570_312_5, 4.838_268e-4);
    let turns = round(x * core::f32::consts::FRAC_2_PI);
    let r = (x - turns * QUARTER_TURN.0) - turns * QUARTER_TURN.1;
    let z = r * r;
    let sin =
        r + r * z * (-1.0 / 6.0 + z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362_880.0))));
    let cos = 1.0 - 0.5 * z + z * z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z * (1.0 / 40_320.0)));
    match (turns as i32) & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Logarithm: the exponent, and of the rest m in [√½, √2) ln m = 2(s + s³/3 + …) with
/// s = (m − 1)/(m + 1). Within 2e-7 relative for normal positive numbers; elsewhere the
/// portable routine.
pub fn ln(x: f32) -> f32 {
    use core::f32::consts::{FRAC_1_SQRT_2, LN_2};
    let (bits, first) = (x.to_bits(), f32::MIN_POSITIVE.to_bits());
    if bits.wrapping_sub(first) >= f32::INFINITY.to_bits() - first {
        return libm::logf(x);
    }
    // Counted from √½, so that the exponent changes there.
    let from = bits.wrapping_sub(FRAC_1_SQRT_2.to_bits());
    let exponent = (from as i32) >> 23;
    let m = f32::from_bits((from & 0x007F_FFFF) + FRAC_1_SQRT_2.to_bits());
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = 0.333_333_34 + z * (0.199_999_4 + z * (0.142_930_55 + z * 0.114_7));
    exponent as f32 * LN_2 + 2.0 * (s + s * z * p)
}

/// e^x: 2ⁿ times e^r, r in ±½ln 2. Within 2e-7 relative for |x| < 87; elsewhere the portable
/// routine.
pub fn exp(x: f32) -> f32 {
    use core::f32::consts::LOG2_E;
    const LN_2: (f32, f32) = (0.693_145_75, 1.428_606_8e-6);
    /// Added and taken away it rounds to a whole number.
    const ROUNDS: f32 = 12_582_912.0;
    if !(x.abs() < 87.0) {
        return libm::expf(x);
    }
    let shifted = x * LOG2_E + ROUNDS;
    let n = shifted - ROUNDS;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    let high = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0)));
    let e = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * high)));
    // n stands in the last bits.
    let exponent = shifted.to_bits().wrapping_sub(ROUNDS.to_bits()) << 23;
    f32::from_bits(e.to_bits().wrapping_add(exponent))
}

/// The nearest whole number, halves away from zero; a quarter of the instructions of the
/// portable routine.
#[inline]
pub fn round(x: f32) -> f32 {
    /// The greatest number below one half: half of it would make a whole of itself.
    const HALF: f32 = 0.499_999_97;
    /// From here on every number is a whole one.
    const WHOLE: f32 = 8_388_608.0;
    if !(x.abs() < WHOLE) {
        return x;
    }
    let rounded = (x.abs() + HALF) as i32 as f32;
    if x < 0.0 { -rounded } else { rounded }
}

/// ln(1 + x) by ln((1 + s)/(1 − s)) = 2(s + s³/3 + …) with s = x/(2 + x), exact near
/// x = 0. Within 2e-7 relative for |x| ≤ 0.5, where every pole pair of use lies;
/// elsewhere the portable routine.
pub fn ln_1p(x: f32) -> f32 {
    if !(x.abs() <= 0.5) {
        return libm::log1pf(x);
    }
    let s = x / (2.0 + x);
    let z = s * s;
    let p = 0.333_332_07 + z * (0.200_108_5 + z * (0.139_995_71 + z * 0.140_122_3));
    2.0 * (s + s * z * p)
}

/// Arc tangent of y/x in (−π, π]. Within 2e-7 relative; 0 for (0, 0), NaN for NaN.
pub fn atan2(y: f32, x: f32) -> f32 {
    use core::f32::consts::{FRAC_PI_2, PI};
    let (t, base) = if y.abs() > x.abs() {
        (-x / y, if y < 0.0 { -FRAC_PI_2 } else { FRAC_PI_2 })
    } else if x > 0.0 {
        (y / x, 0.0)
    } else {
        (y / x, if y < 0.0 { -PI } else { PI })
    };
    // Neither for both 0, nor both infinite, nor NaN.
    if !(t.abs() <= 1.0) {
        return libm::atan2f(y, x);
    }
    let z = t * t;
    let low = -0.333_331_67 + z * (0.199_941_37 + z * (-0.142_142_09 + z * 0.106_789_4));
    let high = -0.075_805_77 + z * (0.043_553_53 + z * (-0.016_581_18 + z * 0.002_974_59));
    let z2 = z * z;
    base + (t + t * z * (low + z2 * z2 * high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn single_precision_root_is_within_one_unit(bits in 0x0080_0000u32..0x7F80_0000) {
            let x = f32::from_bits(bits);
            let (ours, exact) = (sqrt(x), f64::from(x).sqrt());
            let unit = f64::from(f32::from_bits((exact as f32).to_bits() + 1)) - f64::from(exact as f32);
            prop_assert!((f64::from(ours) - exact).abs() <= unit);
        }

        #[test]
        fn logarithm_near_one_is_close(x in -0.9f32..3.0) {
            let exact = f64::from(x).ln_1p();
            let off = (f64::from(ln_1p(x)) - exact).abs();
            prop_assert!(off <= 2e-7 * exact.abs(), "{off} at {x}");
        }

        #[test]
        fn logarithm_of_next_to_one_is_as_close(exponent in -30i32..-1, sign in prop::bool::ANY) {
            let x = if sign { 1.3 } else { -1.3 } * 2f32.powi(exponent);
            let exact = f64::from(x).ln_1p();
            prop_assert!((f64::from(ln_1p(x)) - exact).abs() <= 2e-7 * exact.abs());
        }

        #[test]
        fn logarithm_is_close(bits in 0x0080_0000u32..0x7F80_0000) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).ln();
            prop_assert!((f64::from(ln(x)) - exact).abs() <= 2e-7 * exact.abs(), "{} at {x}", ln(x));
        }

        #[test]
        fn logarithm_next_to_one_is_close(x in 0.5f32..2.0) {
            let exact = f64::from(x).ln();
            prop_assert!((f64::from(ln(x)) - exact).abs() <= 2e-7 * exact.abs(), "{} at {x}", ln(x));
        }

        #[test]
        fn power_of_e_is_close(x in -86.9f32..86.9) {
            let exact = f64::from(x).exp();
            prop_assert!((f64::from(exp(x)) - exact).abs() <= 2e-7 * exact, "{} at {x}", exp(x));
        }

        #[test]
        fn rounded_as_anywhere(bits in 0u32..) {
            let x = f32::from_bits(bits);
            prop_assert!(round(x) == x.round() || x.is_nan() && round(x).is_nan(), "{x}");
        }

        #[test]
        fn halves_and_their_neighbours_are_rounded_as_anywhere(n in -9_000_000i32..9_000_000, by in -1i32..=1) {
            let half = n as f32 / 2.0;
            let x = f32::from_bits((half.to_bits() as i32 + by).max(0) as u32);
            prop_assert!(round(x) == x.round() || x.is_nan(), "{x}");
        }

        #[test]
        fn arc_tangent_is_close(y in -1.0f32..1.0, x in -1.0f32..1.0) {
            let exact = f64::from(y).atan2(f64::from(x));
            let off = (f64::from(atan2(y, x)) - exact).abs();
            prop_assert!(off <= 2e-7 * exact.abs() + 1e-9, "{off} at {y}/{x}");
        }

        #[test]
        fn single_precision_sine_and_cosine_are_close(x in -10.0f32..10.0) {
            let (s, c) = sin_cos(x);
            prop_assert!((f64::from(s) - f64::from(x).sin()).abs() < 3e-7);
            prop_assert!((f64::from(c) - f64::from(x).cos()).abs() < 3e-7);
        }
    }

    #[test]
    fn angles_and_logarithms_of_the_rare_numbers() {
        let pi = core::f32::consts::PI;
        assert_eq!(atan2(0.0, 1.0), 0.0);
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert!((atan2(0.0, -1.0) - pi).abs() < 1e-6);
        assert!((atan2(1.0, 0.0) - pi / 2.0).abs() < 1e-6);
        assert!((atan2(-1.0, 0.0) + pi / 2.0).abs() < 1e-6);
        assert!((atan2(f32::INFINITY, 1.0) - pi / 2.0).abs() < 1e-6);
        assert!(atan2(f32::NAN, 1.0).is_nan() && ln_1p(f32::NAN).is_nan());
        assert_eq!(ln_1p(0.0), 0.0);
        assert_eq!(ln_1p(-1.0), f32::NEG_INFINITY);
        assert!(ln_1p(-2.0).is_nan());
    }

    #[test]
    fn powers_and_logarithms_of_the_rare_numbers() {
        assert_eq!((ln(1.0), exp(0.0)), (0.0, 1.0));
        assert_eq!(
            (ln(0.0), ln(f32::INFINITY)),
            (f32::NEG_INFINITY, f32::INFINITY)
        );
        assert!(ln(-1.0).is_nan() && ln(f32::NAN).is_nan() && exp(f32::NAN).is_nan());
        assert!((ln(1e-40) + 92.1034).abs() < 1e-3);
        assert_eq!((exp(-200.0), exp(200.0)), (0.0, f32::INFINITY));
        assert!((exp(-90.0) / 8.194e-40 - 1.0).abs() < 1e-2);
        assert!((exp(88.0) / 1.6516e38 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn roots_of_the_rare_numbers() {
        assert_eq!(sqrt(0.0), 0.0);
        assert!(sqrt(-1.0).is_nan() && sqrt(f32::NAN).is_nan());
        assert_eq!(sqrt(f32::INFINITY), f32::INFINITY);
        assert!((sqrt(1e-40) / 1e-20 - 1.0).abs() < 1e-5);
    }
}
