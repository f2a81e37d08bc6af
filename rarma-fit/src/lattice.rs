//! Autoregressive models by reflection coefficients: Burg and the geometric lattice.

use super::ar::{ArFit, check_order};
use super::error::FitError;
use super::polynomial::step_up;
use super::series::{Accumulator, Series, count};
use rarma_core::real::Real;

/// How a reflection coefficient is made of the two error powers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mean {
    /// Harmonic mean of the forward and the backward coefficient (Burg).
    Harmonic,
    /// Geometric mean (Itakura and Saito).
    Geometric,
}

/// Burg: the reflection coefficients that minimise the power of forward and
/// backward prediction error together, one order after the other.
///
/// ```text
/// f₀ = b₀ = y,   k_m = −2 Σ f_{m−1}(t) b_{m−1}(t−1) / Σ [f_{m−1}(t)² + b_{m−1}(t−1)²],  t ≥ m
/// f_m(t) = f_{m−1}(t) + k_m b_{m−1}(t−1),   b_m(t) = b_{m−1}(t−1) + k_m f_{m−1}(t)
/// ```
///
/// No window and no assumption about what lies outside the series: the sharpest of
/// the stable methods on short records. σ² is the mean of the forward and backward
/// error power over n − p samples. The errors are made anew from the series for
/// each order, so no memory of its length is needed: O(n·p²) operations. Needs
/// p + 1 samples, mean removed.
///
/// J. P. Burg, *Maximum entropy spectral analysis*, 1975.
///
/// # Errors
/// The cause of the refusal, see [`FitError`].
pub fn burg<T: Real, const N: usize>(y: &[T], p: usize) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    burg_of(&Series::new(y, p + 1)?, p)
}

/// [`burg`] of a series already checked; 0 < p < its length, p ≤ `N`.
pub(super) fn burg_of<T: Real, const N: usize>(
    series: &Series<'_, T>,
    p: usize,
) -> Result<ArFit<T, N>, FitError> {
    lattice(series, p, Mean::Harmonic)
}

/// Lattice with the geometric mean of the forward and backward coefficient:
///
/// ```text
/// k_m = −Σ f_{m−1}(t) b_{m−1}(t−1) / √(Σ f_{m−1}(t)² · Σ b_{m−1}(t−1)²),  t ≥ m
/// ```
///
/// k_m is a correlation coefficient, so always below 1 in magnitude; never smaller
/// in magnitude than Burg's. Everything else as in [`burg`].
///
/// F. Itakura and S. Saito, 1971; Makhoul 1977 compares the means.
///
/// # Errors
/// The cause of the refusal, see [`FitError`].
pub fn geometric_lattice<T: Real, const N: usize>(
    y: &[T],
    p: usize,
) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    lattice(&Series::new(y, p + 1)?, p, Mean::Geometric)
}

fn lattice<T: Real, const N: usize>(
    series: &Series<'_, T>,
    p: usize,
    mean: Mean,
) -> Result<ArFit<T, N>, FitError> {
    let mut a = [T::ZERO; N];
    let mut sigma2 = T::ZERO;
    let mut before = T::ZERO;
    for m in 1..=p {
        let (power, k) = stage(series, &a[..m - 1], mean).ok_or(FitError::Singular)?;
        if m == 1 {
            before = power;
        }
        // Rounding in the sums leaves this much of what is predicted exactly.
        if !(power * (T::ONE - k * k) > before * T::EPSILON * T::EPSILON) {
            return Err(FitError::Singular);
        }
        step_up(&mut a, m, k);
        sigma2 = power * (T::ONE - k * k);
        if mean == Mean::Geometric && m == p {
            // Not the minimum of the power: the sum itself tells.
            sigma2 = error_power(series, &a[..p]);
        }
    }
    Ok(ArFit {
        a,
        p,
        sigma2: series.unscale_variance(sigma2),
        samples: series.len(),
    })
}

/// Mean error power before stage m = a.len() + 1 over t ≥ m, and the stage's k.
fn stage<T: Real>(series: &Series<'_, T>, a: &[T], mean: Mean) -> Option<(T, T)> {
    let m = a.len() + 1;
    let mut sums = [Accumulator::default(); 3];
    errors(series, a, m, |forward, backward| {
        sums[0].add(forward * forward);
        sums[1].add(backward * backward);
        sums[2].add(forward * backward);
    });
    let [ff, bb, fb] = sums.map(|s| s.value());
    let half = (ff + bb) * T::from_f64(0.5);
    let norm = match mean {
        Mean::Harmonic => half,
        Mean::Geometric => (ff * bb).sqrt(),
    };
    let k = -fb / norm;
    // A magnitude of 1 by rounding alone is a perfectly predictable series.
    (norm > T::ZERO && k.abs() < T::ONE).then(|| (half / count(series.len() - m), k))
}

/// Mean of forward and backward error power of a whole model.
fn error_power<T: Real>(series: &Series<'_, T>, a: &[T]) -> T {
    let mut sum = Accumulator::default();
    let p = a.len();
    for t in p..series.len() {
        let (mut f, mut b) = (series.at(t), series.at(t - p));
        for i in 0..p {
            f += a[i] * series.at(t - 1 - i);
            b += a[i] * series.at(t - p + 1 + i);
        }
        sum.add(f * f + b * b);
    }
    sum.value() / count(2 * (series.len() - p))
}

/// Longest filter that is written out for the vector product.
const LONGEST: usize = super::LONGEST_AR + 1;

/// f(t) and b(t−1) of order m − 1 = a.len(), for t = m…n−1.
fn errors<T: Real>(series: &Series<'_, T>, a: &[T], m: usize, mut each: impl FnMut(T, T)) {
    // Weights of y(t−m+1)…y(t) for f and of y(t−m)…y(t−1) for b.
    let (mut ahead, mut behind) = ([T::ZERO; LONGEST], [T::ZERO; LONGEST]);
    if m <= LONGEST {
        ahead[m - 1] = T::ONE;
        behind[0] = T::ONE;
        for i in 0..m - 1 {
            ahead[m - 2 - i] = a[i];
            behind[i + 1] = a[i];
        }
        for t in m..series.len() {
            each(
                series.dot(&ahead[..m], t + 1 - m),
                series.dot(&behind[..m], t - m),
            );
        }
        return;
    }
    for t in m..series.len() {
        let (mut f, mut b) = (series.at(t), series.at(t - m));
        for i in 0..m - 1 {
            f += a[i] * series.at(t - 1 - i);
            b += a[i] * series.at(t - m + 1 + i);
        }
        each(f, b);
    }
}
