//! Poles to frequency and damping ratio, with their uncertainty.

use super::factors::{Quadratic, Roots};
use crate::estimate::UdFactors;
use crate::real::Real;

/// Natural frequency and damping ratio of a conjugate pole pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modal<T> {
    /// Undamped natural frequency, Hz.
    pub frequency: T,
    /// Damping ratio ζ, 1; negative for a growing vibration. Read off a machine
    /// that cuts it is the operational damping ratio (ODR).
    pub damping: T,
}

/// Frequency and damping ratio of a pole pair sampled at `fs` Hz, none for real
/// roots.
///
/// ```text
/// l = ln|z|,  θ = atan2(Im z, Re z),  f = fs·√(l² + θ²)/2π,  ζ = −l/√(l² + θ²)
/// ```
///
/// This is eq. 73 of the thesis with its sign and its arc tangent put right: as
/// printed, a 1 kHz mode at 8 kHz reads 4409 Hz, and a plain arc tangent folds
/// every mode above fs/4. ln|z| comes from ln(1 + (v − 1))/2, exact in `f32` for
/// lightly damped modes, where v = |z|² is next to 1.
///
/// ```
/// use rarma_core::spectrum::{modal, Quadratic};
/// let (f, zeta, fs) = (3000.0f64, 0.05, 8000.0);
/// let w = 2.0 * core::f64::consts::PI * f / fs;
/// let radius = (-zeta * w).exp();
/// let angle = w * (1.0 - zeta * zeta).sqrt();
/// let q = Quadratic { u: 2.0 * radius * angle.cos(), v: radius * radius };
/// let mode = modal(&q, fs).unwrap();
/// assert!((mode.frequency - f).abs() < 1e-9 && (mode.damping - zeta).abs() < 1e-12);
/// ```
#[inline(always)]
pub fn modal<T: Real>(factor: &Quadratic<T>, fs: T) -> Option<Modal<T>> {
    let Roots::Pair { re, im } = factor.roots() else {
        return None;
    };
    let l = (factor.v - T::ONE).ln_1p() * T::from_f64(0.5);
    let theta = im.atan2(re);
    let r = (l * l + theta * theta).sqrt();
    Some(Modal {
        frequency: fs * r / (T::from_f64(2.0) * T::PI),
        damping: -l / r,
    })
}

/// Standard deviations of a mode's frequency (Hz) and damping ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModalDeviation<T> {
    /// Of the natural frequency, Hz.
    pub frequency: T,
    /// Of the damping ratio, 1.
    pub damping: T,
}

/// Uncertainty of a mode by the delta method, from the covariance of (a, c).
///
/// ```text
/// ∂z/∂a_i = −z^(p−i)/A′(z),   d(l + jθ) = dz/z
/// dζ = θ(l·dθ − θ·dl)/r³,     df = fs/2π·(l·dl + θ·dθ)/r
/// ```
///
/// `a` without the leading 1, `factor` a pole pair of it, `covariance` with the
/// parameters (a, c) in that order, scaled by `scale`. None for real roots.
/// Slow path (O(n²) twice).
pub fn deviation<T: Real, const N: usize>(
    a: &[T],
    n: usize,
    factor: &Quadratic<T>,
    fs: T,
    covariance: &UdFactors<T, N>,
    scale: T,
) -> Option<ModalDeviation<T>> {
    let Roots::Pair { re, im } = factor.roots() else {
        return None;
    };
    let p = a.len();
    // A′(z) by Horner, complex.
    let (mut value, mut slope) = ((T::ONE, T::ZERO), (T::ZERO, T::ZERO));
    let times_z = |x: (T, T)| (x.0 * re - x.1 * im, x.0 * im + x.1 * re);
    for &coefficient in a {
        slope = times_z(slope);
        slope = (slope.0 + value.0, slope.1 + value.1);
        value = times_z(value);
        value.0 += coefficient;
    }
    let divide = |x: (T, T), y: (T, T)| {
        let d = y.0 * y.0 + y.1 * y.1;
        ((x.0 * y.0 + x.1 * y.1) / d, (x.1 * y.0 - x.0 * y.1) / d)
    };
    // w_p = −1/(z·A′), then w_{i−1} = z·w_i: derivative of ln z by a_i.
    let mut w = divide((-T::ONE, T::ZERO), times_z(slope));
    let l = (factor.v - T::ONE).ln_1p() * T::from_f64(0.5);
    let theta = im.atan2(re);
    let r2 = l * l + theta * theta;
    let r = r2.sqrt();
    let (mut by_f, mut by_zeta) = ([T::ZERO; N], [T::ZERO; N]);
    for i in (0..p).rev() {
        by_f[i] = (l * w.0 + theta * w.1) / r;
        by_zeta[i] = theta * (l * w.1 - theta * w.0) / (r * r2);
        w = times_z(w);
    }
    let sd = |variance: T| (variance * scale).max(T::ZERO).sqrt();
    let (var_f, var_zeta) = covariance.quadratics(n, p, &by_f, &by_zeta);
    Some(ModalDeviation {
        frequency: sd(var_f) * fs / (T::from_f64(2.0) * T::PI),
        damping: sd(var_zeta),
    })
}
