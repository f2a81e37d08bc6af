//! The complex arithmetic of receptances.

use core::ops::{Add, Mul, Neg, Sub};
use rarma_core::real::Real;

/// A complex number; receptances carry m/N in both parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Complex<T> {
    /// Real part.
    pub re: T,
    /// Imaginary part; negative for a receptance of positive damping.
    pub im: T,
}

impl<T: Real> Complex<T> {
    /// Zero.
    pub const ZERO: Self = Self {
        re: T::ZERO,
        im: T::ZERO,
    };

    /// From its parts.
    pub const fn new(re: T, im: T) -> Self {
        Self { re, im }
    }

    /// Times a real number.
    pub fn scale(self, by: T) -> Self {
        Self::new(self.re * by, self.im * by)
    }

    /// |z|².
    pub fn norm_sqr(self) -> T {
        self.re * self.re + self.im * self.im
    }

    /// |z|. The larger part is taken out first, so that receptances of 1e-9 m/N keep
    /// their square in `f32`.
    pub fn abs(self) -> T {
        let most = self.re.abs().max(self.im.abs());
        if !(most > T::ZERO) {
            return most;
        }
        self.scale(T::ONE / most).norm_sqr().sqrt() * most
    }

    /// 1/z; not finite at zero.
    pub fn inverse(self) -> Self {
        let d = self.norm_sqr();
        Self::new(self.re / d, -self.im / d)
    }

    /// Both parts are finite.
    pub fn is_finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}

impl<T: Real> Add for Complex<T> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
}

impl<T: Real> Sub for Complex<T> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
}

impl<T: Real> Mul for Complex<T> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(
            self.re * o.re - self.im * o.im,
            self.re * o.im + self.im * o.re,
        )
    }
}

impl<T: Real> Neg for Complex<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}
