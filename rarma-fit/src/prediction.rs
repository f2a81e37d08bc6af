//! Prediction errors of an ARMA model and their derivatives, sample by sample.

use super::block::{Block, ROWS};
use super::series::{Accumulator, Series};
use rarma_core::real::Real;

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

/// A signal block by block, each after the last `N` samples of the one before: what a
/// filter needs of the past, without moving it at every sample.
struct Line<T, const N: usize> {
    past: [T; N],
    now: [T; ROWS],
}

impl<T: Real, const N: usize> Line<T, N> {
    fn new() -> Self {
        Self {
            past: [T::ZERO; N],
            now: [T::ZERO; ROWS],
        }
    }

    /// After samples of which the latest comes first.
    fn after(before: &[T; N]) -> Self {
        let mut out = Self::new();
        for (past, x) in out.past.iter_mut().rev().zip(before) {
            *past = *x;
        }
        out
    }

    /// Sample k − back of this block, back ≤ `N`.
    #[inline(always)]
    fn at(&self, k: usize, back: usize) -> T {
        if back <= k {
            self.now[k - back]
        } else {
            self.past[N + k - back]
        }
    }

    /// x − Σ cⱼ·(sample k − j), j from 1: the next output of 1/C.
    #[inline(always)]
    fn feed_back(&self, c: &[T], k: usize, x: T) -> T {
        let mut out = x;
        let (near, far) = c.split_at(k.min(c.len()));
        for (c, x) in near.iter().zip(self.now[..k].iter().rev()) {
            out -= *c * *x;
        }
        for (c, x) in far.iter().zip(self.past.iter().rev()) {
            out -= *c * *x;
        }
        out
    }

    /// The block is over: its last samples become the past.
    fn turn(&mut self) {
        if N <= ROWS {
            self.past.copy_from_slice(&self.now[ROWS - N..]);
        } else {
            self.past.copy_within(ROWS.., 0);
            self.past[N - ROWS..].copy_from_slice(&self.now);
        }
    }
}

/// Σ over t ≥ p of e(t)², conditional on the first p samples, with `before` = e(p−1), e(p−2) …
pub(super) fn sum_of_squares<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
    before: &[T; N],
) -> T {
    let mut sum = Accumulator::default();
    let (a, c) = theta[..order.n()].split_at(order.p);
    let mut e = Line::after(before);
    let mut from = order.p;
    while from < series.len() {
        let rows = ROWS.min(series.len() - from);
        for k in 0..rows {
            let x = e.feed_back(c, k, moved(series, a, from + k));
            e.now[k] = x;
            sum.add(x * x);
        }
        e.turn();
        from += rows;
    }
    sum.value()
}

/// A·y at t ≥ p.
#[inline(always)]
fn moved<T: Real>(series: &Series<'_, T>, a: &[T], t: usize) -> T {
    let mut x = series.at(t);
    for (i, a) in a.iter().enumerate() {
        x += *a * series.at(t - 1 - i);
    }
    x
}

/// Calls `each` with blocks of equations ∂e/∂θ·δ = −e for t ≥ p, which it may use up; the
/// derivatives are exact, start included, for `before` = e(p−1), e(p−2) … as they are.
///
/// ∂e/∂aᵢ shifted by one sample misses only what y(p−1−i) puts in at t = p, and ∂e/∂cⱼ what
/// e(p−j) does: that times the impulse response h of 1/C is added, so one filter serves all i,
/// one all j, and the state stays O(p + q).
pub(super) fn sensitivities<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
    before: &[T; N],
    mut each: impl FnMut(&mut Block<T, N>),
) {
    let Orders { p, q } = order;
    let (a, c) = theta[..p + q].split_at(p);
    let (mut e, mut h) = (Line::after(before), Line::<T, N>::new());
    let (mut by_a, mut by_c) = (Line::<T, N>::new(), Line::<T, N>::new());
    // The last row of the columns of the block before.
    let mut last = [T::ZERO; N];
    let mut from = p;
    let mut block = Block::<T, N>::new();
    while from < series.len() {
        let rows = ROWS.min(series.len() - from);
        if rows < ROWS {
            // What was left of the block before is no equation.
            block = Block::new();
        }
        for k in 0..rows {
            let t = from + k;
            e.now[k] = e.feed_back(c, k, moved(series, a, t));
            block.right[k] = -e.now[k];
            if q > 0 {
                // ∂e/∂c₁ = −e(t−1)/C.
                by_c.now[k] = by_c.feed_back(c, k, -e.at(k, 1));
            }
            let impulse = if t == p { T::ONE } else { T::ZERO };
            h.now[k] = h.feed_back(c, k, impulse);
            if p > 0 {
                by_a.now[k] = by_a.feed_back(c, k, series.at(t - 1));
            }
        }
        if q > 0 {
            block.columns[p][..rows].copy_from_slice(&by_c.now[..rows]);
        }
        if p > 0 {
            block.columns[0][..rows].copy_from_slice(&by_a.now[..rows]);
        }
        for i in (1..p).chain(p + 1..p + q) {
            let y = if i < p {
                series.at(p - 1 - i)
            } else {
                -before[i - p]
            };
            let (before, column) = block.columns.split_at_mut(i);
            let (before, column) = (&before[i - 1], &mut column[0]);
            column[0] = last[i - 1] + h.now[0] * y;
            for ((x, before), h) in column[1..rows].iter_mut().zip(before).zip(&h.now[1..rows]) {
                *x = *before + *h * y;
            }
        }
        for (last, column) in last[..p + q].iter_mut().zip(&block.columns) {
            *last = column[ROWS - 1];
        }
        each(&mut block);
        for line in [&mut e, &mut h, &mut by_a, &mut by_c] {
            line.turn();
        }
        from += rows;
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
            let before: [f64; 6] =
                core::array::from_fn(|i| if i < q { 0.7 - i as f64 } else { 0.0 });
            let mut rows = [(0.0, [0.0; 6]); 60];
            let mut t = p;
            sensitivities(&series, order, &theta, &before, |block| {
                for k in 0..ROWS.min(60 - t) {
                    rows[t] = (-block.right[k], block.columns.map(|column| column[k]));
                    t += 1;
                }
            });
            assert_eq!(t, 60);
            let total: f64 = rows.iter().map(|(e, _)| e * e).sum();
            assert!((total - sum_of_squares(&series, order, &theta, &before)).abs() < 1e-10);
            for i in 0..p + q {
                let mut sides = [[0.0; 60]; 2];
                for (side, h) in sides.iter_mut().zip([1e-6, -1e-6]) {
                    let mut moved = theta;
                    moved[i] += h;
                    let mut t = p;
                    sensitivities(&series, order, &moved, &before, |block| {
                        for k in 0..ROWS.min(60 - t) {
                            side[t] = -block.right[k];
                            t += 1;
                        }
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
