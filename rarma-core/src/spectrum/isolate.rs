//! One mode's own part of the signal: everything else the model knows, taken away.
//!
//! Rate: once a decimated sample and mode, p − 1 products and the division.

use super::quadratic::Quadratic;
use crate::real::Real;

/// x(t) = A(q)/q_k(q) · y_f(t), with q_k = 1 − u·q⁻¹ + v·q⁻² the factor of one mode and
/// y_f the output filtered by 1/C: the process that this pole pair alone makes of the
/// innovations, q_k·x = e.
///
/// A/q_k comes by synthetic division, ã₀ = 1, ã_i = a_i + u·ã_(i−1) − v·ã_(i−2), for
/// i up to p − 2; what is left over is zero where `factor` divides A. `a` without the
/// leading 1; `filtered` holds y_f(t), y_f(t−1), … (at least p − 1 of them, of either
/// sign, which x then has too). Zero if there is nothing to filter.
#[inline(always)]
pub fn isolate<T: Real>(a: &[T], factor: &Quadratic<T>, filtered: &[T]) -> T {
    let Some((newest, older)) = filtered.split_first() else {
        return T::ZERO;
    };
    let (mut before, mut last, mut x) = (T::ZERO, T::ONE, *newest);
    let terms = a.len().saturating_sub(2);
    for (coefficient, y) in a.iter().take(terms).zip(older) {
        let next = *coefficient + factor.u * last - factor.v * before;
        (before, last) = (last, next);
        x += next * *y;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_obeys_the_other_factor_alone() {
        // Two pole pairs driven by one impulse: with one isolated, the other's factor
        // makes the impulse out of it again.
        let one = Quadratic { u: 1.2f64, v: 0.97 };
        let two = Quadratic { u: -0.4, v: 0.9 };
        let a = [
            -one.u - two.u,
            one.v + two.v + one.u * two.u,
            -one.u * two.v - two.u * one.v,
            one.v * two.v,
        ];
        let (mut y, mut past) = ([0.0; 4], [0.0; 2]);
        for n in 0..200 {
            let e = if n == 5 { 1.0 } else { 0.0 };
            let new = e - a[0] * y[0] - a[1] * y[1] - a[2] * y[2] - a[3] * y[3];
            y = [new, y[0], y[1], y[2]];
            let x = isolate(&a, &one, &y);
            let back = x - one.u * past[0] + one.v * past[1];
            past = [x, past[0]];
            assert!((back - e).abs() < 1e-12, "{n}: {back}");
        }
        assert!(y[0].abs() > 1e-4, "the poles ring on");
        assert_eq!(isolate(&a, &one, &[]), 0.0);
        // One mode alone: nothing to take away.
        assert_eq!(isolate(&[-1.2, 0.97], &one, &[3.0, 2.0]), 3.0);
    }
}
