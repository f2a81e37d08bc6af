//! Poles to frequency and damping ratio, with their uncertainty.

use super::quadratic::{Quadratic, Roots};
use crate::real::Real;
use crate::ud::UdFactors;

/// Natural frequency and damping ratio of a conjugate pole pair.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    // √(l² + θ²) = θ·√(1 + (l/θ)²); next to 1, where damping is light, by its series
    // as far as the next term, 5/128 of the fourth power, is below the last digit.
    let ratio = l / theta;
    let w = ratio * ratio;
    let single = T::EPSILON > T::from_f64(1e-10);
    let light = if single { 0.03 } else { 1e-4 };
    let root = if w < T::from_f64(light) {
        T::ONE + w * (T::from_f64(0.5) - w * (T::from_f64(0.125) - w * T::from_f64(0.0625)))
    } else {
        (T::ONE + w).sqrt()
    };
    Some(Modal {
        frequency: fs * theta * root * T::from_f64(0.5 / core::f64::consts::PI),
        damping: -ratio / root,
    })
}

/// Standard deviations of a mode's frequency (Hz) and damping ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(f: f64, zeta: f64, fs: f64) -> Quadratic<f64> {
        let w = 2.0 * core::f64::consts::PI * f / fs;
        let radius = (-zeta * w).exp();
        let angle = w * (1.0 - zeta * zeta).sqrt();
        Quadratic {
            u: 2.0 * radius * angle.cos(),
            v: radius * radius,
        }
    }

    #[test]
    fn frequency_and_damping_come_back_over_the_whole_band() {
        let fs = 8000.0;
        for part in 1..=9 {
            let f = 0.05 * f64::from(part) * fs;
            for zeta in [-0.01, 0.0005, 0.01, 0.05, 0.1] {
                let q = factor(f, zeta, fs);
                let exact = modal(&q, fs).expect("a pair");
                assert!((exact.frequency / f - 1.0).abs() < 1e-12);
                assert!((exact.damping - zeta).abs() < 1e-12);
                let single = Quadratic {
                    u: q.u as f32,
                    v: q.v as f32,
                };
                let m = modal(&single, fs as f32).expect("a pair");
                assert!(
                    (f64::from(m.frequency) / f - 1.0).abs() < 1e-5,
                    "{f} {zeta}: {m:?}"
                );
                assert!(
                    (f64::from(m.damping) - zeta).abs() < 1e-5,
                    "{f} {zeta}: {m:?}"
                );
            }
        }
        assert!(modal(&Quadratic { u: 1.9, v: 0.9 }, fs).is_none());
    }

    #[test]
    fn deviation_is_the_derivative_through_the_roots() {
        // Against finite differences of the roots themselves.
        let fs = 5000.0;
        let (one, two) = (factor(980.0, 0.02, fs), factor(450.0, 0.03, fs));
        let a = [
            -one.u - two.u,
            one.v + two.v + one.u * two.u,
            -one.u * two.v - two.u * one.v,
            one.v * two.v,
        ];
        let covariance = UdFactors::<f64, 4>::diagonal(1e-8);
        let sd = deviation(&a, 4, &one, fs, &covariance, 1.0).expect("a pair");
        let (mut var_f, mut var_zeta) = (0.0, 0.0);
        for i in 0..4 {
            let mut moved = a;
            moved[i] += 1e-7;
            let mut tracker = crate::spectrum::FactorTracker::<f64, 4>::new();
            tracker.solve(&moved, 500).expect("found");
            let near = tracker
                .factors(4)
                .iter()
                .filter_map(|q| modal(q, fs))
                .min_by(|x, y| {
                    (x.frequency - 980.0)
                        .abs()
                        .total_cmp(&(y.frequency - 980.0).abs())
                })
                .expect("a mode");
            var_f += ((near.frequency - 980.0) / 1e-7).powi(2) * 1e-8;
            var_zeta += ((near.damping - 0.02) / 1e-7).powi(2) * 1e-8;
        }
        assert!((sd.frequency / var_f.sqrt() - 1.0).abs() < 1e-3);
        assert!((sd.damping / var_zeta.sqrt() - 1.0).abs() < 1e-3);
    }
}
