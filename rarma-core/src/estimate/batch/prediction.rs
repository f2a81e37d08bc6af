//! Prediction errors of an ARMA model and their derivatives, sample by sample.

use super::series::{Accumulator, Series};
use crate::real::Real;

/// Coefficients of an ARMA model of run-time order, stored in one array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Orders {
    pub p: usize,
    pub q: usize,
}

impl Orders {
    pub fn n(self) -> usize {
        self.p + self.q
    }
}

#[inline(always)]
fn push<T: Real>(history: &mut [T], x: T) {
    let n = history.len();
    if n > 0 {
        history.copy_within(..n - 1, 1);
        history[0] = x;
    }
}

#[inline(always)]
fn feed_back<T: Real>(c: &[T], history: &[T], x: T) -> T {
    let mut out = x;
    for (c, h) in c.iter().zip(history) {
        out -= *c * *h;
    }
    out
}

/// Σ over t ≥ p of e(t)², with e = 0 before p (conditional on the first samples).
pub(super) fn sum_of_squares<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
) -> T {
    let mut sum = Accumulator::default();
    let (a, c) = theta[..order.n()].split_at(order.p);
    let mut e = [T::ZERO; N];
    for t in order.p..series.len() {
        let mut x = series.at(t);
        for (i, a) in a.iter().enumerate() {
            x += *a * series.at(t - 1 - i);
        }
        let x = feed_back(c, &e[..order.q], x);
        push(&mut e[..order.q], x);
        sum.add(x * x);
    }
    sum.value()
}

/// Calls `each(e, ∂e/∂θ)` for t ≥ p; the derivatives are exact, start included.
///
/// ∂e/∂c_j is ∂e/∂c₁ shifted, because e is 0 before p. ∂e/∂aᵢ shifted by one sample
/// misses only what y(p−1−i) puts in at t = p: that times the impulse response h of
/// 1/C is added, so one filter serves all i and the state stays O(p + q).
pub(super) fn sensitivities<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
    mut each: impl FnMut(T, &[T; N]),
) {
    let Orders { p, q } = order;
    let (a, c) = theta[..p + q].split_at(p);
    let (mut e, mut first, mut h) = ([T::ZERO; N], [T::ZERO; N], [T::ZERO; N]);
    let mut gradient = [T::ZERO; N];
    for t in p..series.len() {
        let mut x = series.at(t);
        for (i, a) in a.iter().enumerate() {
            x += *a * series.at(t - 1 - i);
        }
        let x = feed_back(c, &e[..q], x);
        // ∂e/∂c₁ = −e(t−1)/C: its own past is the part of the gradient for c.
        let by_c = feed_back(
            c,
            &gradient[p..p + q],
            -e.first().copied().unwrap_or_default(),
        );
        if q > 0 {
            push(&mut gradient[p..p + q], by_c);
        }
        if p > 0 {
            let impulse = if t == p { T::ONE } else { T::ZERO };
            let response = feed_back(c, &h[..q], impulse);
            let by_a = feed_back(c, &first[..q], series.at(t - 1));
            push(&mut h[..q], response);
            push(&mut first[..q], by_a);
            push(&mut gradient[..p], by_a);
            for (i, g) in gradient[1..p].iter_mut().enumerate() {
                *g += response * series.at(p - 2 - i);
            }
        }
        push(&mut e[..q], x);
        each(x, &gradient);
    }
}

/// Prediction errors of a fitted model over a series, from sample p on, in input
/// units; see [`ArmaFit::residuals`](super::ArmaFit::residuals).
#[derive(Debug, Clone)]
pub struct Residuals<'a, T, const N: usize> {
    pub(super) y: &'a [T],
    pub(super) mean: T,
    pub(super) order: Orders,
    pub(super) theta: [T; N],
    pub(super) past: [T; N],
    pub(super) t: usize,
}

impl<T: Real, const N: usize> Iterator for Residuals<'_, T, N> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        let t = self.t;
        let mut e = *self.y.get(t)? - self.mean;
        let (a, c) = self.theta[..self.order.n()].split_at(self.order.p);
        for (a, y) in a.iter().zip(self.y[..t].iter().rev()) {
            e += *a * (*y - self.mean);
        }
        let e = feed_back(c, &self.past[..self.order.q], e);
        push(&mut self.past[..self.order.q], e);
        self.t += 1;
        Some(e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_errors() {
        let y: [f64; 60] = core::array::from_fn(|t| libm::sin(1.3 * (t * t % 37) as f64));
        let series = Series::new(&y, 2).expect("valid");
        for (p, q) in [(3, 2), (1, 4), (0, 2), (4, 0), (2, 2)] {
            let order = Orders { p, q };
            let theta: [f64; 6] = core::array::from_fn(|i| 0.3 - 0.13 * i as f64);
            let mut rows = [(0.0, [0.0; 6]); 60];
            let mut t = p;
            sensitivities(&series, order, &theta, |e, g| {
                rows[t] = (e, *g);
                t += 1;
            });
            assert_eq!(t, 60);
            let total: f64 = rows.iter().map(|(e, _)| e * e).sum();
            assert!((total - sum_of_squares(&series, order, &theta)).abs() < 1e-10);
            for i in 0..p + q {
                let mut sides = [[0.0; 60]; 2];
                for (side, h) in sides.iter_mut().zip([1e-6, -1e-6]) {
                    let mut moved = theta;
                    moved[i] += h;
                    let mut t = p;
                    sensitivities(&series, order, &moved, |e, _| {
                        side[t] = e;
                        t += 1;
                    });
                }
                for t in p..60 {
                    let slope = (sides[0][t] - sides[1][t]) / 2e-6;
                    let off = (slope - rows[t].1[i]).abs();
                    assert!(off < 1e-6 * slope.abs().max(1.0), "({p},{q}) θ{i} t {t}");
                }
            }
        }
    }
}
