//! All complex roots of a polynomial from nothing: what a cold start falls back on.
//!
//! Slow path. The sweep over quadratic factors is the quicker at the orders of the
//! box, but from a circle its first steps can overflow: at degree 60 it failed on 77
//! of 100 autoregressions of two tones in noise; this one on none.

use super::quadratic::Quadratic;
use crate::real::{Real, times};

/// Rounds over all roots.
const ROUNDS: u32 = 200;

/// Factors of z^p + a₁ z^(p−1) + … + a_p by Ehrlich and Aberth's iteration
///
/// ```text
/// w = A(z)/A′(z),     z_k ← z_k − w/(1 − w·Σ_{j≠k} 1/(z_k − z_j))
/// ```
///
/// from an unsymmetric circle. Pairs first, then real roots two by two, an odd one
/// with a root at 0. False if it does not settle or conjugates do not match.
pub(super) fn solve<T: Real, const P: usize>(a: &[T], out: &mut [Quadratic<T>; P]) -> bool {
    let p = a.len();
    if p > P {
        return false;
    }
    let mut z = [(T::ZERO, T::ZERO); P];
    for (k, z) in z[..p].iter_mut().enumerate() {
        // Off the real axis and unsymmetric: real roots part from each other.
        let share = (T::from_u32(k as u32) + T::from_f64(0.2)) / T::from_u32(p as u32);
        let (sin, cos) = (T::from_f64(2.0) * T::PI * share).sin_cos();
        *z = (T::from_f64(0.93) * cos, T::from_f64(0.93) * sin);
    }
    let settled = T::EPSILON * T::from_f64(64.0);
    let mut quiet = false;
    for _ in 0..ROUNDS {
        let mut moved = T::ZERO;
        for k in 0..p {
            let here = z[k];
            let step = newton(a, here);
            let mut sum = (T::ZERO, T::ZERO);
            for (j, other) in z[..p].iter().enumerate() {
                if j != k {
                    let part = divide((T::ONE, T::ZERO), subtract(here, *other));
                    sum = (sum.0 + part.0, sum.1 + part.1);
                }
            }
            let shared = times(step, sum);
            let step = divide(step, (T::ONE - shared.0, -shared.1));
            if !(step.0 + step.1).is_finite() {
                continue;
            }
            z[k] = subtract(here, step);
            moved = moved.max(step.0.abs()).max(step.1.abs());
        }
        if !moved.is_finite() {
            return false;
        }
        // One more round once all is quiet to the root of rounding: cubic.
        if moved < settled || quiet {
            return pair(&z[..p], out);
        }
        quiet = moved < T::EPSILON.sqrt();
    }
    false
}

/// Gathers conjugates and real roots into factors; the padded root of an odd degree
/// is at 0.
fn pair<T: Real, const P: usize>(z: &[(T, T)], out: &mut [Quadratic<T>; P]) -> bool {
    let near = T::EPSILON.sqrt() * T::from_f64(16.0);
    let (mut m, mut conjugates) = (0, 0);
    let mut odd: Option<T> = None;
    for (k, &(re, im)) in z.iter().enumerate() {
        let twin = z
            .iter()
            .enumerate()
            .any(|(j, other)| j != k && (other.0 - re).abs() < near && (other.1 + im).abs() < near);
        let factor = if im.abs() > near && twin {
            if im < T::ZERO {
                conjugates += 1;
                continue;
            }
            conjugates += 1;
            Quadratic {
                u: T::from_f64(2.0) * re,
                v: re * re + im * im,
            }
        } else if im.abs() < near {
            match odd.take() {
                None => {
                    odd = Some(re);
                    continue;
                }
                Some(other) => Quadratic {
                    u: other + re,
                    v: other * re,
                },
            }
        } else {
            return false;
        };
        let Some(slot) = out.get_mut(m) else {
            return false;
        };
        *slot = factor;
        m += 1;
    }
    if let Some(last) = odd {
        let Some(slot) = out.get_mut(m) else {
            return false;
        };
        *slot = Quadratic {
            u: last,
            v: T::ZERO,
        };
        m += 1;
    }
    conjugates % 2 == 0 && m == z.len().div_ceil(2)
}

fn subtract<T: Real>(x: (T, T), y: (T, T)) -> (T, T) {
    (x.0 - y.0, x.1 - y.1)
}

fn divide<T: Real>(x: (T, T), y: (T, T)) -> (T, T) {
    let norm = y.0 * y.0 + y.1 * y.1;
    let product = times(x, (y.0, -y.1));
    (product.0 / norm, product.1 / norm)
}

/// A/A′ at z; outside the circle from the reversed polynomial, so that powers do
/// not overflow.
fn newton<T: Real>(a: &[T], z: (T, T)) -> (T, T) {
    let mut value = (T::ONE, T::ZERO);
    let mut slope = (T::ZERO, T::ZERO);
    if z.0 * z.0 + z.1 * z.1 <= T::ONE {
        for &x in a {
            slope = times(slope, z);
            slope = (slope.0 + value.0, slope.1 + value.1);
            value = times(value, z);
            value.0 += x;
        }
        return divide(value, slope);
    }
    // R(w) = 1 + a₁ w + … with w = 1/z:  A′/A = (p − w·R′/R)/z
    let w = divide((T::ONE, T::ZERO), z);
    value = (T::ZERO, T::ZERO);
    for i in (0..=a.len()).rev() {
        slope = times(slope, w);
        slope = (slope.0 + value.0, slope.1 + value.1);
        value = times(value, w);
        value.0 += if i == 0 { T::ONE } else { a[i - 1] };
    }
    let p = T::from_u32(a.len() as u32);
    let inner = times(w, slope);
    let scaled = (p * value.0 - inner.0, p * value.1 - inner.1);
    divide(times(z, value), scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of Π (z² − u z + v), without the leading 1.
    fn product(factors: &[(f64, f64)]) -> ([f64; 60], usize) {
        let mut a = [0.0; 62];
        a[0] = 1.0;
        for &(u, v) in factors {
            for i in (0..61).rev() {
                a[i + 1] -= u * a[i];
                if i > 0 {
                    a[i + 1] += v * a[i - 1];
                }
            }
        }
        (core::array::from_fn(|i| a[i + 1]), 2 * factors.len())
    }

    #[test]
    fn sixty_roots_with_close_ones_and_real_ones() {
        let mut factors = [(0.0, 0.0); 30];
        for (k, f) in factors.iter_mut().enumerate() {
            let (angle, radius) = (0.1 * k as f64 + 0.13, 0.9 + 0.003 * k as f64);
            *f = (2.0 * radius * libm::cos(angle), radius * radius);
        }
        factors[0] = (0.3, -0.54); // 0.9 and −0.6
        factors[1].0 = factors[2].0 + 0.05;
        factors[1].1 = factors[2].1;
        let (a, p) = product(&factors);
        let mut out = [Quadratic { u: 0.0, v: 0.0 }; 60];
        assert!(solve(&a[..p], &mut out));
        for (u, v) in factors {
            let near = out[..30]
                .iter()
                .any(|q| (q.u - u).abs() < 1e-4 && (q.v - v).abs() < 1e-4);
            assert!(near, "{u} {v}");
        }
        // An odd degree: the root 0.5 alone besides one pair.
        let mut out = [Quadratic { u: 0.0, v: 0.0 }; 4];
        assert!(solve(&[-1.5, 1.3, -0.4], &mut out));
        assert!(
            out[..2]
                .iter()
                .any(|q| (q.u - 0.5).abs() < 1e-12 && q.v == 0.0)
        );
        assert!(
            out[..2]
                .iter()
                .any(|q| (q.u - 1.0).abs() < 1e-12 && (q.v - 0.8).abs() < 1e-12)
        );
        assert!(!solve::<f64, 2>(
            &[f64::NAN, 0.2],
            &mut [Quadratic { u: 0.0, v: 0.0 }; 2]
        ));
    }
}
