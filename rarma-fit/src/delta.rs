//! Uncertainty through the roots: from the covariance of (a, c) to a mode.

use rarma_core::real::Real;

/// Standard deviations of a mode's frequency and damping ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoleDeviation<T> {
    /// Of the undamped natural frequency, Hz.
    pub frequency: T,
    /// Of the damping ratio, 1.
    pub damping: T,
}

/// By the delta method, for the root z = re + j·im, im > 0, of A:
///
/// ```text
/// ∂z/∂aᵢ = −z^(p−i)/A′(z),   l + jθ = ln z,   r = √(l² + θ²)
/// df = fs/2π·(l·dl + θ·dθ)/r,   dζ = θ·(l·dθ − θ·dl)/r³
/// ```
///
/// `covariance` is that of (a, …), a first. None for a real or double root.
pub(super) fn pole_deviation<T: Real, const N: usize>(
    a: &[T],
    covariance: &[[T; N]; N],
    re: T,
    im: T,
    fs: T,
) -> Option<PoleDeviation<T>> {
    let p = a.len();
    if !(im > T::ZERO) || p > N {
        return None;
    }
    let times_z = |x: (T, T)| (x.0 * re - x.1 * im, x.0 * im + x.1 * re);
    let (mut value, mut slope) = ((T::ONE, T::ZERO), (T::ZERO, T::ZERO));
    for &coefficient in a {
        slope = times_z(slope);
        slope = (slope.0 + value.0, slope.1 + value.1);
        value = times_z(value);
        value.0 += coefficient;
    }
    // d ln z/da_p = −1/(z·A′), then one factor z more for each lower i.
    let slope = times_z(slope);
    let norm = slope.0 * slope.0 + slope.1 * slope.1;
    if !(norm > T::ZERO) {
        return None;
    }
    let mut d = (-slope.0 / norm, slope.1 / norm);
    let l = (re * re + im * im - T::ONE).ln_1p() * T::from_f64(0.5);
    let theta = im.atan2(re);
    let r2 = l * l + theta * theta;
    let r = r2.sqrt();
    let (mut by_f, mut by_zeta) = ([T::ZERO; N], [T::ZERO; N]);
    for i in (0..p).rev() {
        by_f[i] = (l * d.0 + theta * d.1) / r;
        by_zeta[i] = theta * (l * d.1 - theta * d.0) / (r * r2);
        d = times_z(d);
    }
    let sd = |by: &[T; N]| {
        let mut sum = T::ZERO;
        for i in 0..p {
            for j in 0..p {
                sum += by[i] * covariance[i][j] * by[j];
            }
        }
        sum.max(T::ZERO).sqrt()
    };
    let out = PoleDeviation {
        frequency: sd(&by_f) * fs / (T::from_f64(2.0) * T::PI),
        damping: sd(&by_zeta),
    };
    (out.frequency.is_finite() && out.damping.is_finite()).then_some(out)
}
