//! The number type of the whole core: `f32` on the box, `f64` as its oracle.
//!
//! One trait with exactly the operations the signal path needs, so that every
//! algorithm has one source. Functions come from `libm`, which works without std,
//! except those of `f32` that every sample or every mode needs, which are our own (`single.rs`).

mod single;

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

/// Product of two complex numbers as (real, imaginary).
#[inline(always)]
pub(crate) fn times<T: Real>(a: (T, T), b: (T, T)) -> (T, T) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

macro_rules! real {
    ($t:ty, $consts:ident, $sqrt:path, $sincos:path, $ln_1p:path, $ln:path, $exp:path, $atan2:path, $round:path) => {
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
                $ln_1p(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline(always)]
            fn round(self) -> Self {
                $round(self)
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
    single::sqrt,
    single::sin_cos,
    single::ln_1p,
    single::ln,
    single::exp,
    single::atan2,
    single::round
);
real!(
    f64,
    f64,
    libm::sqrt,
    libm::sincos,
    libm::log1p,
    libm::log,
    libm::exp,
    libm::atan2,
    libm::round
);
