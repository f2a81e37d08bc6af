//! Is a polynomial stable? The Schur–Cohn test by step-down, in fixed time.

use crate::real::Real;

/// True if every root of z^q + c₁ z^(q-1) + … + c_q lies inside |z| < `radius`.
///
/// Roots are scaled by 1/radius (c_i → c_i/radiusⁱ) and the reflection
/// coefficients k computed downwards; all below 1 in magnitude means stable. Up to
/// `N` coefficients; c is without the leading 1. NaN counts as unstable.
///
/// Rounding errors grow by 1/Π(1 − k²), which is the power gain of white noise
/// through 1/C. Where it leaves no digit of this number type, stable cannot be told
/// from unstable, and the answer is no: between two close lines a test in `f32`
/// without that let roots of radius 1.006 pass.
pub fn inside<T: Real, const N: usize>(c: &[T], radius: T) -> bool {
    inside_inverse::<T, N>(c, T::ONE / radius)
}

/// [`inside`] of 1/radius, for every sample.
#[inline(always)]
pub(super) fn inside_inverse<T: Real, const N: usize>(c: &[T], inverse: T) -> bool {
    let q = c.len();
    let mut a = [T::ZERO; N];
    let mut power = T::ONE;
    for (scaled, c) in a.iter_mut().zip(c) {
        power *= inverse;
        *scaled = *c * power;
    }
    let mut left = T::ONE;
    // Written out for the orders of the box, a loop beyond; see `ud`.
    for m in (17..=q).rev() {
        let rest = step_down(&mut a, m);
        if !(rest > T::ZERO) {
            return false;
        }
        left *= rest;
    }
    macro_rules! each {
        ($($m:literal)*) => {
            $(if $m <= q && $m <= N {
                let rest = step_down(&mut a, $m);
                if !(rest > T::ZERO) {
                    return false;
                }
                left *= rest;
            })*
        };
    }
    each!(16 15 14 13 12 11 10 9 8 7 6 5 4 3 2 1);
    left > T::EPSILON * T::from_f64(NOISE_GAIN)
}

/// Draws the roots of C towards 0, cⱼ ← γʲ·cⱼ, until they are inside the radius.
pub fn shrink<T: Real, const N: usize>(c: &mut [T], radius: T) {
    for _ in 0..200 {
        if inside::<T, N>(c, radius) {
            return;
        }
        let mut power = T::ONE;
        for x in c.iter_mut() {
            power *= T::from_f64(0.95);
            *x *= power;
        }
    }
    c.fill(T::ZERO);
}

/// Rounding units that Π(1 − k²) must be above.
const NOISE_GAIN: f64 = 8.0;

/// From degree m to m − 1: a_i ← (a_i − k·a_{m−i})/(1 − k²) with k = a_m. Returns
/// 1 − k², not above 0 (or NaN) if the polynomial is not stable.
#[inline(always)]
fn step_down<T: Real, const N: usize>(a: &mut [T; N], m: usize) -> T {
    let k = a[m - 1];
    let rest = T::ONE - k * k;
    let scale = T::ONE / rest;
    let half = (m - 1) / 2;
    for i in 0..half {
        let (x, y) = (a[i], a[m - 2 - i]);
        a[i] = (x - k * y) * scale;
        a[m - 2 - i] = (y - k * x) * scale;
    }
    if (m - 1) % 2 == 1 {
        a[half] = a[half] * (T::ONE - k) * scale;
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::inside;

    fn polynomial(roots: &[(f64, f64)]) -> Vec<f64> {
        let mut p = vec![1.0];
        for &(re, im) in roots {
            let factor = [1.0, -2.0 * re, re * re + im * im];
            let mut next = vec![0.0; p.len() + 2];
            for (i, x) in p.iter().enumerate() {
                for (j, y) in factor.iter().enumerate() {
                    next[i + j] += x * y;
                }
            }
            p = next;
        }
        p[1..].to_vec()
    }

    extern crate std;
    use std::{vec, vec::Vec};

    #[test]
    fn decides_on_both_sides_of_the_circle() {
        for r in [0.5, 0.9, 0.99, 0.999] {
            let pair = |r: f64, t: f64| (r * libm::cos(t), r * libm::sin(t));
            let c = polynomial(&[pair(r, 0.7), pair(0.8, 2.0), pair(0.3, 1.0)]);
            assert!(inside::<f64, 6>(&c, (r + 1e-4f64).max(0.81)));
            assert!(!inside::<f64, 6>(&c, r.max(0.8) - 1e-4));
        }
        assert!(inside::<f64, 3>(&[], 1.0));
        assert!(inside::<f64, 3>(&[-0.5], 1.0));
        assert!(!inside::<f64, 3>(&[-1.5], 1.0));
        assert!(!inside::<f32, 3>(&[f32::NAN, 0.1], 1.0));
    }

    #[test]
    fn every_degree_is_told_on_both_sides() {
        // Pairs of 0.9 and for an odd degree a real root, which is the largest.
        for degree in 1..=20 {
            let mut roots = vec![];
            for pair in 0..degree / 2 {
                let angle = 0.2 + 2.7 * f64::from(pair) / f64::from(degree / 2);
                roots.push((0.9 * libm::cos(angle), 0.9 * libm::sin(angle)));
            }
            let mut c = polynomial(&roots);
            let mut largest = 0.9;
            if degree % 2 == 1 {
                largest = 0.95;
                let mut before = 1.0;
                for x in &mut c {
                    (before, *x) = (*x, *x - largest * before);
                }
                c.push(-largest * before);
            }
            assert_eq!(c.len(), degree as usize);
            assert!(inside::<f64, 20>(&c, largest + 1e-3), "{degree}");
            assert!(!inside::<f64, 20>(&c, largest - 1e-3), "{degree}");
        }
    }
}
