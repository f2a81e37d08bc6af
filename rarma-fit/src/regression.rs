//! Autoregressive models by linear equations: least squares forward, forward and
//! backward, and instrumental variables.

use super::ar::{ArFit, check_order};
use super::error::FitError;
use super::series::{Accumulator, Series, count};
use super::triangle::Triangle;
use rarma_core::real::Real;

/// Least squares of the forward prediction error (covariance method):
///
/// ```text
/// min over a of Σ_{t=p}^{n−1} [y(t) + Σ aᵢ y(t−i)]²
/// ```
///
/// Solved by rotations, not by normal equations. The model need not be stable.
/// σ² is the minimum over n − p. Needs 2p + 1 samples, mean removed.
///
/// # Errors
/// The cause of the refusal, see [`FitError`].
pub fn covariance<T: Real, const N: usize>(y: &[T], p: usize) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    least_squares(&Series::new(y, 2 * p + 1)?, p, false)
}

/// Least squares of forward and backward prediction error together (modified
/// covariance, forward–backward):
///
/// ```text
/// min over a of Σ_{t=p}^{n−1} [y(t) + Σ aᵢ y(t−i)]² + [y(t−p) + Σ aᵢ y(t−p+i)]²
/// ```
///
/// Best of the family for the frequency of tones; the model need not be stable.
/// σ² is the minimum over 2(n − p). Needs ⌈3p/2⌉ + 1 samples, mean removed.
///
/// # Errors
/// The cause of the refusal, see [`FitError`].
pub fn modified_covariance<T: Real, const N: usize>(
    y: &[T],
    p: usize,
) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    least_squares(&Series::new(y, p + p.div_ceil(2) + 1)?, p, true)
}

/// Forward, or forward and backward, of a series already checked.
pub(super) fn least_squares<T: Real, const N: usize>(
    series: &Series<'_, T>,
    p: usize,
    both: bool,
) -> Result<ArFit<T, N>, FitError> {
    let n = series.len();
    let mut triangle = Triangle::<T, N>::new(p);
    let mut sum = Accumulator::default();
    let mut row = [T::ZERO; N];
    for t in p..n {
        for (i, x) in row[..p].iter_mut().enumerate() {
            *x = -series.at(t - 1 - i);
        }
        let rest = triangle.add(&mut row, series.at(t));
        sum.add(rest * rest);
        if both {
            for (i, x) in row[..p].iter_mut().enumerate() {
                *x = -series.at(t - p + 1 + i);
            }
            let rest = triangle.add(&mut row, series.at(t - p));
            sum.add(rest * rest);
        }
    }
    let equations = if both { 2 * (n - p) } else { n - p };
    Ok(ArFit {
        a: triangle.solve().ok_or(FitError::Singular)?,
        p,
        sigma2: series.unscale_variance(sum.value() / count(equations)),
        samples: n,
    })
}

/// Autoregressive part of an ARMA(p, q) by instrumental variables: outputs older
/// than q samples are uncorrelated with the moving average, so
///
/// ```text
/// Σᵢ aᵢ r(k−i) = −r(k),   k = q+1 … q+lags        (modified, for lags > p extended, Yule–Walker)
/// ```
///
/// in the sense of least squares. `lags` ≥ p; 2p to 4p is usual. Consistent whatever
/// the moving average, not efficient, and not always stable. σ² here is the
/// variance of A·y, the moving average itself, not of its innovation. Needs
/// q + lags + p + 1 samples, mean removed.
///
/// # Errors
/// `OutOfRange` for `lags` < p, otherwise see [`FitError`].
pub fn instrumental_variables<T: Real, const N: usize>(
    y: &[T],
    p: usize,
    q: usize,
    lags: usize,
) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    if lags < p {
        return Err(FitError::OutOfRange);
    }
    let series = Series::new(y, q.saturating_add(lags).saturating_add(p + 1))?;
    instruments(&series, p, q, lags)
}

/// [`instrumental_variables`] of a series already checked.
pub(super) fn instruments<T: Real, const N: usize>(
    series: &Series<'_, T>,
    p: usize,
    q: usize,
    lags: usize,
) -> Result<ArFit<T, N>, FitError> {
    let n = series.len();
    let mut triangle = Triangle::<T, N>::new(p);
    // r(k−1)…r(k−p) for the equation of lag k.
    let mut window = [T::ZERO; N];
    for (i, r) in window[..p].iter_mut().enumerate() {
        *r = series.autocovariance(q.abs_diff(i));
    }
    for k in q + 1..=q + lags {
        let r = series.autocovariance(k);
        let mut row = window;
        let _ = triangle.add(&mut row, -r);
        window.copy_within(..p - 1, 1);
        window[0] = r;
    }
    let a = triangle.solve().ok_or(FitError::Singular)?;
    let mut sum = Accumulator::default();
    for t in p..n {
        let mut w = series.at(t);
        for (i, a) in a[..p].iter().enumerate() {
            w += *a * series.at(t - 1 - i);
        }
        sum.add(w * w);
    }
    Ok(ArFit {
        a,
        p,
        sigma2: series.unscale_variance(sum.value() / count(n - p)),
        samples: n,
    })
}
