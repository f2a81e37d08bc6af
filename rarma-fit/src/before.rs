//! Prediction errors before the first that is counted.
//!
//! e(p) needs e(p−1)…e(p−q), which the record does not hold. Taken as 0 they are wrong by as much
//! as any other error, and what they leave decays with 1/C. That is little for one mode. The C of
//! four close modes makes a thousandfold of it before it decays: at 980, 450, 1600 and 700 Hz, 10 dB
//! of noise, the sum of squares of the true model was up to 61 % above n·σ², and that of a model with
//! three modes below it.

use super::error::FitError;
use super::prediction::{Orders, sum_of_squares};
use super::series::Series;
use super::triangle::Triangle;
use rarma_core::real::Real;

/// What the errors before the first one are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Before {
    /// 0: the "conditional sum of squares" of the statistics packages.
    Zero,
    /// Those under which the sum of squares, their own included, is the least.
    #[default]
    Estimated,
}

/// What is left of an error before the start counts as gone below this part of it.
const GONE: f64 = 1e-4;

/// e(p−1), e(p−2) … e(p−q) that make the sum of squares least, their own squares included:
///
/// ```text
/// e = e₀ + Σ_k x_k·h_k,   h_k(t) = −Σ_{j ≥ k} c_j·g(t − j + k),  g = impulse response of 1/C
/// min over x of Σ (e₀ + Σ x_k·h_k)² + Σ x_k²
/// ```
///
/// Linear least squares on as many samples as h lasts. All 0 where they are not asked for.
pub(super) fn errors_before<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
    before: Before,
) -> [T; N] {
    let Orders { p, q } = order;
    if q == 0 || before == Before::Zero {
        return [T::ZERO; N];
    }
    let (a, c) = theta[..p + q].split_at(p);
    let mut triangle = Triangle::<T, N>::new(q);
    for k in 0..q {
        let mut row = [T::ZERO; N];
        row[k] = T::ONE;
        let _ = triangle.add(&mut row, T::ZERO);
    }
    // g(t), g(t−1) …, and e₀(t−1), e₀(t−2) …
    let (mut g, mut e) = ([T::ZERO; N], [T::ZERO; N]);
    let mut quiet = 0;
    for t in p..series.len() {
        let (mut impulse, mut error) = (T::ZERO, series.at(t));
        if t == p {
            impulse = T::ONE;
        }
        for (i, a) in a.iter().enumerate() {
            error += *a * series.at(t - 1 - i);
        }
        for (c, (g, e)) in c.iter().zip(g.iter().zip(&e)) {
            impulse -= *c * *g;
            error -= *c * *e;
        }
        for k in (1..q).rev() {
            g[k] = g[k - 1];
            e[k] = e[k - 1];
        }
        (g[0], e[0]) = (impulse, error);
        let mut row = [T::ZERO; N];
        let mut largest = T::ZERO;
        for k in 0..q {
            for (c, g) in c[k..].iter().zip(&g) {
                row[k] -= *c * *g;
            }
            largest = largest.max(row[k].abs());
        }
        let _ = triangle.add(&mut row, -error);
        // Gone when it has been so for as long as C reaches back.
        quiet = if largest < T::from_f64(GONE) {
            quiet + 1
        } else {
            0
        };
        if quiet > q {
            break;
        }
    }
    triangle.solve().unwrap_or([T::ZERO; N])
}

/// Σ e² from sample p on, and of the errors before it.
pub(super) fn cost<T: Real, const N: usize>(
    series: &Series<'_, T>,
    order: Orders,
    theta: &[T; N],
    before: Before,
) -> T {
    let before = errors_before(series, order, theta, before);
    let own: T = before.iter().map(|x| *x * *x).sum();
    sum_of_squares(series, order, theta, &before) + own
}

/// The errors before the first of a model that is given: e(p−1), e(p−2) … e(p−q), input units, for
/// whoever works out residuals from p on. `y` without its mean; p + q ≤ `N`.
///
/// ```
/// // y(t) = e(t) + 0.9 e(t−1), of which e(−1) = 1 is all there was.
/// let before = rarma_fit::earlier_errors::<f64, 1>(&[0.9, 0.0, 0.0, 0.0, 0.0], &[], &[0.9])?;
/// // Less than 1, for an error as large as that is not likely without cause.
/// assert!(before[0] > 0.4 && before[0] < 1.0);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
///
/// # Errors
/// `OrderAboveCapacity`, or what is wrong with the series: see [`FitError`].
pub fn earlier_errors<T: Real, const N: usize>(
    y: &[T],
    a: &[T],
    c: &[T],
) -> Result<[T; N], FitError> {
    let (p, q) = (a.len(), c.len());
    if p + q > N {
        return Err(FitError::OrderAboveCapacity);
    }
    let series = Series::new(y, p + 2)?;
    let mut theta = [T::ZERO; N];
    theta[..p].copy_from_slice(a);
    theta[p..p + q].copy_from_slice(c);
    let mut out = errors_before(&series, Orders { p, q }, &theta, Before::Estimated);
    out.iter_mut().for_each(|x| *x *= series.scale());
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that are known, before the record too: they are found where they make the difference,
    /// and the residuals that follow from them are the true ones.
    #[test]
    fn errors_that_the_record_does_not_hold_are_found() {
        let a = [-1.5, 0.9];
        // Two close pairs of zeros: what is before the record is a hundredfold in it.
        let pair = |angle: f64, r: f64| [-2.0 * r * libm::cos(angle), r * r];
        let (u, v) = (pair(0.9, 0.95), pair(1.0, 0.95));
        let c = [
            u[0] + v[0],
            u[1] + v[1] + u[0] * v[0],
            u[0] * v[1] + u[1] * v[0],
            u[1] * v[1],
        ];
        let e: [f64; 400] = core::array::from_fn(|t| {
            libm::sin((t * t) as f64 * 0.731) + libm::cos(17.3 * t as f64)
        });
        let mut y = [0.0; 400];
        for t in 4..400 {
            y[t] = e[t] - a[0] * y[t - 1] - a[1] * y[t - 2];
            for (j, c) in c.iter().enumerate() {
                y[t] += c * e[t - 1 - j];
            }
        }
        let heard = &y[50..];
        let left = |before: &[f64]| {
            let mut past: [f64; 4] = core::array::from_fn(|k| before[k]);
            let mut off = 0.0f64;
            for t in 2..heard.len() {
                let mut x = heard[t] + a[0] * heard[t - 1] + a[1] * heard[t - 2];
                for (c, e) in c.iter().zip(&past) {
                    x -= c * e;
                }
                past.copy_within(..3, 1);
                past[0] = x;
                off += (x - e[50 + t]).powi(2);
            }
            off
        };
        let found = earlier_errors::<f64, 6>(heard, &a, &c).expect("a series");
        let (zero, estimated) = (left(&[0.0; 4]), left(&found));
        assert!(
            zero > 100.0 && estimated < 0.02 * zero,
            "{zero} {estimated}"
        );
        assert_eq!(
            earlier_errors::<f64, 3>(heard, &a, &c).err(),
            Some(FitError::OrderAboveCapacity)
        );
    }
}
