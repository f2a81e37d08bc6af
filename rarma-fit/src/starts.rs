//! Where the search for the least prediction error begins.
//!
//! The prediction error of several lightly damped modes has local minima, and the
//! start decides. All starts are linear least squares on the innovations ê of a
//! long autoregression (Hannan and Rissanen), repeated with everything filtered by
//! 1/C of the round before: the rounds converge to an estimate next to the
//! efficient one whatever the first C was, so what is left for the search is small.

use super::ar::ArFit;
use super::before::{Before, cost};
use super::block::Collected;
use super::polynomial::reflect;
use super::prediction::Orders;
use super::series::Series;
use super::subspace::lines;
use rarma_core::estimate::{BoundedArma, RarmaConfig};
use rarma_core::real::Real;
use rarma_core::spectrum::{FactorTracker, Roots};

/// Innovations of a long autoregression.
#[derive(Debug, Clone, Copy)]
pub(super) struct Innovations<T> {
    /// Weights of y(t−m)…y(t).
    weights: [T; super::LONGEST_AR + 1],
    m: usize,
}

impl<T: Real> Innovations<T> {
    /// Of the model `long`.
    pub fn of<const M: usize>(long: &ArFit<T, M>) -> Self {
        let mut weights = [T::ZERO; super::LONGEST_AR + 1];
        let m = long.p.min(super::LONGEST_AR);
        for (i, a) in long.a()[..m].iter().enumerate() {
            weights[m - 1 - i] = *a;
        }
        weights[m] = T::ONE;
        Self { weights, m }
    }

    #[inline(always)]
    fn at(&self, series: &Series<'_, T>, t: usize) -> T {
        series.dot(&self.weights[..=self.m], t - self.m)
    }
}

/// What one round minimises over a and c.
#[derive(Debug, Clone, Copy)]
pub(super) enum Round<'a, T> {
    /// Σ [A·y − (C − 1)·ê]²: the regression of Hannan and Rissanen.
    Plain,
    /// Σ [(A·y − C·ê)/C₀]² with this stable C₀.
    Filtered(&'a [T]),
    /// The same with C₀ = 1 and this A given; over c alone.
    Given(&'a [T]),
}

/// One round of linear least squares.
pub(super) fn round<T: Real, const N: usize>(
    series: &Series<'_, T>,
    long: &Innovations<T>,
    order: Orders,
    kind: Round<'_, T>,
) -> Option<[T; N]> {
    let Orders { p, q } = order;
    let longest = p.max(q);
    let mut y_f = [T::ZERO; N];
    let mut e_f = [T::ZERO; N];
    let (before, given): (&[T], Option<&[T]>) = match kind {
        Round::Plain => (&[], None),
        Round::Filtered(c) => (c, None),
        Round::Given(a) => (&[], Some(a)),
    };
    let unknown = if given.is_some() { q } else { p + q };
    let mut equations = Collected::<T, N>::new(unknown);
    for t in 0..series.len() {
        let mut y = series.at(t);
        let mut e = if t >= long.m {
            long.at(series, t)
        } else {
            T::ZERO
        };
        for (j, c) in before.iter().enumerate() {
            y -= *c * y_f[j];
            e -= *c * e_f[j];
        }
        if t >= long.m + longest {
            let mut row = [T::ZERO; N];
            let mut right = match kind {
                Round::Plain => y,
                Round::Filtered(_) | Round::Given(_) => y - e,
            };
            if let Some(a) = given {
                for (a, y) in a.iter().zip(&y_f) {
                    right += *a * *y;
                }
            } else {
                for (x, y) in row[..p].iter_mut().zip(&y_f) {
                    *x = -*y;
                }
            }
            row[unknown - q..unknown].copy_from_slice(&e_f[..q]);
            equations.add(&row, right);
        }
        for i in (1..longest).rev() {
            y_f[i] = y_f[i - 1];
            e_f[i] = e_f[i - 1];
        }
        y_f[0] = y;
        e_f[0] = e;
    }
    let found = equations.triangle().solve()?;
    let Some(a) = given else { return Some(found) };
    let mut out = [T::ZERO; N];
    out[..p].copy_from_slice(a);
    out[p..p + q].copy_from_slice(&found[..q]);
    Some(out)
}

/// Rounds of refinement.
const ROUNDS: u32 = 8;
/// Relative change of the sum of squares below which further rounds are left out.
const SETTLED: f64 = 1e-5;

/// The best of several rounds by the sum of squared prediction errors, beginning
/// from a given A (instrumental variables) or from nothing.
pub(super) fn refine<T: Real, const N: usize>(
    series: &Series<'_, T>,
    long: &Innovations<T>,
    order: Orders,
    given: Option<&[T]>,
    (radius, before_first): (T, Before),
) -> Option<([T; N], T)> {
    let Orders { p, q } = order;
    let mut before = [T::ZERO; N];
    let mut best: Option<([T; N], T)> = None;
    let mut last = T::ZERO;
    for k in 0..ROUNDS {
        let kind = match given {
            Some(a) if k == 0 => Round::Given(a),
            _ => Round::Filtered(&before[..q]),
        };
        let Some(mut theta) = round::<T, N>(series, long, order, kind) else {
            break;
        };
        reflect::<T, N>(&mut theta[p..p + q], radius);
        before[..q].copy_from_slice(&theta[p..p + q]);
        let cost = cost(series, order, &theta, before_first);
        if !cost.is_finite() {
            break;
        }
        if best.as_ref().is_none_or(|(_, b)| cost < *b) {
            best = Some((theta, cost));
        }
        if (cost - last).abs() < cost * T::from_f64(SETTLED) {
            break;
        }
        last = cost;
    }
    best
}

/// Where one pass of the recursion ends, without forgetting: it finds its way past minima that hold
/// a search, for its gradient is a new one at every sample. It keeps C within `radius` itself, so
/// that the start is its model. None above the recursion's orders.
pub(super) fn from_recursion<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    radius: T,
) -> Option<[T; N]> {
    let default = RarmaConfig::<T>::default();
    let config = RarmaConfig {
        forgetting: T::ONE,
        c_radius: default.c_radius.min(radius),
        ..default
    };
    let mut model = BoundedArma::new(order.p, order.q, config)?;
    for t in 0..series.len() {
        model.update(series.at(t));
    }
    model.finish_start();
    let mut theta = [T::ZERO; N];
    theta[..order.p].copy_from_slice(model.a());
    theta[order.p..order.n()].copy_from_slice(model.c());
    theta.iter().all(|x| x.is_finite()).then_some(theta)
}

/// Half the window of the subspace at a start.
const HALF: usize = 48;
/// Radii of the poles at most, and of the zeros over them, at a start from lines.
const POLE: f64 = 0.999;
const ZERO: f64 = 0.95;

/// A start for lines in white noise: poles from the subspace, each with a zero at its
/// angle a little further inside. Tones in noise are such a model, and no long
/// autoregression leads to it. None for a moving average or too short a series.
pub(super) fn from_lines<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
) -> Option<[T; N]> {
    let degree = order.p.min(order.q) / 2 * 2;
    if degree == 0 || degree > HALF {
        return None;
    }
    let fit: ArFit<T, HALF> = lines::<T, HALF, HALF>(series, degree, T::from_f64(0.36)).ok()?;
    let mut roots = FactorTracker::<T, HALF>::new();
    roots.solve(fit.a(), 300)?;
    let mut theta = [T::ZERO; N];
    let (a, c) = theta[..order.n()].split_at_mut(order.p);
    for factor in roots.factors(degree) {
        let Roots::Pair { re, im } = factor.roots() else {
            continue;
        };
        let radius = (re * re + im * im).sqrt();
        let pole = radius.min(T::from_f64(POLE));
        for (polynomial, inside) in [(&mut *a, pole), (&mut *c, pole * T::from_f64(ZERO))] {
            let u = T::from_f64(2.0) * re * inside / radius;
            multiply(polynomial, u, inside * inside);
        }
    }
    Some(theta)
}

/// 1 + Σ aᵢ q⁻ⁱ times 1 − u q⁻¹ + v q⁻²; what exceeds the slice must be 0.
fn multiply<T: Real>(a: &mut [T], u: T, v: T) {
    for i in (0..a.len()).rev() {
        let one = if i > 0 { a[i - 1] } else { T::ONE };
        let two = match i {
            0 => T::ZERO,
            1 => T::ONE,
            _ => a[i - 2],
        };
        a[i] += v * two - u * one;
    }
}
