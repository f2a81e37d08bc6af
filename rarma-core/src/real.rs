//! The number type of the whole core: `f32` on the box, `f64` as its oracle.
//!
//! One trait with exactly the operations the signal path needs, so that every
//! algorithm has one source. Functions come from `libm`, which works without std,
//! except two of `f32`: the root, which `libm` makes bit by bit, and sine and
//! cosine, which it makes in double precision, a software routine on the target.

use core::fmt::Debug;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number of the signal path, `f32` or `f64`.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Sum
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Circle constant.
    const PI: Self;

    /// Rounds a constant or a setting to this type. Slow path only: on the target
    /// an `f64` that is not a literal costs a software routine.
    fn from_f64(x: f64) -> Self;
    /// Widens a result for reporting. Slow path only.
    fn to_f64(self) -> f64;
    /// Converts a sample from the wire or the converter.
    fn from_f32(x: f32) -> Self;
    /// Narrows a result to what is sent on the wire.
    fn to_f32(self) -> f32;
    /// Converts a count.
    fn from_u32(x: u32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Natural logarithm of 1 + x, exact near x = 0.
    fn ln_1p(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Four-quadrant arc tangent of `self / x`.
    fn atan2(self, x: Self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Nearest integer, halves away from zero.
    fn round(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// The larger of two numbers; `self` if the other is NaN.
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    /// The smaller of two numbers; `self` if the other is NaN.
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// Limits to `lo..=hi`.
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }
}

macro_rules! real {
    ($t:ty, $consts:ident, $sqrt:path, $sincos:path, $ln_1p:ident, $ln:ident, $exp:ident, $atan2:ident, $round:ident) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = <$t>::EPSILON;
            const PI: Self = core::$consts::consts::PI;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                x as $t
            }
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn from_u32(x: u32) -> Self {
                x as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn ln_1p(self) -> Self {
                libm::$ln_1p(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                libm::$ln(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline(always)]
            fn round(self) -> Self {
                libm::$round(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
        }
    };
}

real!(
    f32,
    f32,
    sqrt_f32,
    sin_cos_f32,
    log1pf,
    logf,
    expf,
    atan2f,
    roundf
);
real!(
    f64,
    f64,
    libm::sqrt,
    libm::sincos,
    log1p,
    log,
    exp,
    atan2,
    round
);

/// Square root in single-precision multiplications: 1/√x by Newton from a bit
/// pattern, then one correction of the root itself. Within 1 unit in the last
/// place; a seventh of the instructions of the portable routine, and the same bits
/// on every machine. Negative numbers and NaN give NaN.
fn sqrt_f32(x: f32) -> f32 {
    // Zero, subnormal, negative, NaN, infinite: the rare ones go the slow way.
    if !(f32::MIN_POSITIVE..f32::INFINITY).contains(&x) {
        return libm::sqrtf(x);
    }
    let half = 0.5 * x;
    let mut r = f32::from_bits(0x5F37_5A86 - (x.to_bits() >> 1));
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    let root = x * r;
    root + 0.5 * r * (x - root * root)
}

/// Sine and cosine without double precision: reduction to ±π/4 in two parts, then
/// Taylor polynomials. Within 3e-7 for |x| < 10; made for angles per sample, 0 to π.
fn sin_cos_f32(x: f32) -> (f32, f32) {
    const QUARTER_TURN: (f32, f32) = (1.570_312_5, 4.838_268e-4);
    let turns = libm::roundf(x * core::f32::consts::FRAC_2_PI);
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn single_precision_root_is_within_one_unit(bits in 0x0080_0000u32..0x7F80_0000) {
            let x = f32::from_bits(bits);
            let (ours, exact) = (sqrt_f32(x), f64::from(x).sqrt());
            let unit = f64::from(f32::from_bits((exact as f32).to_bits() + 1)) - f64::from(exact as f32);
            prop_assert!((f64::from(ours) - exact).abs() <= unit);
        }

        #[test]
        fn single_precision_sine_and_cosine_are_close(x in -10.0f32..10.0) {
            let (s, c) = sin_cos_f32(x);
            prop_assert!((f64::from(s) - f64::from(x).sin()).abs() < 3e-7);
            prop_assert!((f64::from(c) - f64::from(x).cos()).abs() < 3e-7);
        }
    }

    #[test]
    fn roots_of_the_rare_numbers() {
        assert_eq!(sqrt_f32(0.0), 0.0);
        assert!(sqrt_f32(-1.0).is_nan() && sqrt_f32(f32::NAN).is_nan());
        assert_eq!(sqrt_f32(f32::INFINITY), f32::INFINITY);
        assert!((sqrt_f32(1e-40) / 1e-20 - 1.0).abs() < 1e-5);
    }
}
