//! Poles from the signal subspace of a series (ESPRIT).

use super::ar::{ArFit, check_order};
use super::eigen::{characteristic, jacobi};
use super::error::FitError;
use super::series::{Series, count};
use rarma_core::real::Real;

/// Poles of p lines in white noise by the shift of their subspace (ESPRIT):
///
/// ```text
/// R = Σ_t x_t x_tᵀ + J x_t x_tᵀ J,   x_t = y(t)…y(t+L−1)      forward and backward
/// U = the p eigenvectors of R with the largest eigenvalues
/// (U without its last row)·Φ = (U without its first row),   A(z) = det(zI − Φ)
/// ```
///
/// A tone takes two of p. Made for tones, at a resolution beyond that of the Fourier
/// transform (a record of T tells apart 1/T): two of them 0.64/T apart, see the
/// documentation of the estimators. Read backward a decay is a growth, so the damping
/// of what dies away within the series is not to be trusted; and a mode that noise
/// keeps ringing is no line at all: take [`Pem`](super::Pem).
///
/// Sign convention: A = 1 + Σ aᵢ q⁻ⁱ. Poles may lie slightly outside the circle.
/// σ² is the mean of the eigenvalues left out over the number of products in
/// each, the power of the white noise. Window L = 2·min(⌊0.36 n⌋, `H`): from 0.5 n to
/// 0.8 n was measured, 0.7 n resolves best. R is symmetric about both diagonals, so
/// two eigenproblems of half the size do (Jacobi). `f32` squares the ratio of noise to
/// signal: below 1e-3 it is lost in rounding.
///
/// Generics: `N` ≥ p coefficients, `H` ≥ p half the window at most; stack about
/// 4·H² + 2·N² numbers. Needs p + ⌈p/2⌉ + 2 samples (at least 8), mean removed.
///
/// ```
/// use rarma_fit::esprit;
/// let y: [f64; 40] = core::array::from_fn(|t| (0.7 * t as f64).sin());
/// let fit = esprit::<_, 2, 16>(&y, 2)?;
/// assert!((fit.a()[0] + 2.0 * 0.7f64.cos()).abs() < 1e-9);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
///
/// # Errors
/// `Singular` if the series holds fewer lines than p asks for and no noise,
/// otherwise see [`FitError`].
pub fn esprit<T: Real, const N: usize, const H: usize>(
    y: &[T],
    p: usize,
) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    let series = Series::new(y, (p + p.div_ceil(2) + 2).max(8))?;
    lines::<T, N, H>(&series, p, T::from_f64(SHARE))
}

/// Half the window over the length.
const SHARE: f64 = 0.36;

/// Half the window for this share of `n` samples, `most` at most.
pub(super) fn half_window<T: Real>(n: usize, share: T, most: usize) -> usize {
    let wanted = share * count(n);
    let mut half = 1;
    while half < most && count::<T>(half + 1) <= wanted {
        half += 1;
    }
    half
}

/// [`esprit`] of a series already checked, with half the window this share of it.
pub(super) fn lines<T: Real, const N: usize, const H: usize>(
    series: &Series<'_, T>,
    p: usize,
    share: T,
) -> Result<ArFit<T, N>, FitError> {
    let n = series.len();
    let half = half_window(n, share, H);
    if 2 * half <= p || half > H {
        return Err(FitError::OrderAboveCapacity);
    }
    let window = 2 * half;
    let mut matrices = covariance::<T, H>(series, half);
    let mut vectors = [[[T::ZERO; H]; H]; 2];
    for (s, v) in matrices.iter_mut().zip(vectors.iter_mut()) {
        if !jacobi(s, v, half) {
            return Err(FitError::Singular);
        }
    }
    // The p largest of both kinds; (kind, column).
    let mut chosen = [(0usize, 0usize); N];
    let mut taken = [[false; H]; 2];
    let mut kept = T::ZERO;
    let mut smallest = T::ZERO;
    let mut largest = T::ZERO;
    for (k, slot) in chosen[..p].iter_mut().enumerate() {
        let mut best: Option<(usize, usize)> = None;
        for kind in 0..2 {
            for i in 0..half {
                let value = matrices[kind][i][i];
                if !taken[kind][i] && best.is_none_or(|(b, j)| value > matrices[b][j][j]) {
                    best = Some((kind, i));
                }
            }
        }
        let (kind, i) = best.ok_or(FitError::Singular)?;
        taken[kind][i] = true;
        smallest = matrices[kind][i][i];
        kept += smallest;
        if k == 0 {
            largest = smallest;
        }
        *slot = (kind, i);
    }
    if !(smallest > largest * T::EPSILON * count::<T>(window)) {
        return Err(FitError::Singular);
    }
    let all: T = matrices
        .iter()
        .flat_map(|s| (0..half).map(|i| s[i][i]))
        .sum();
    let products = count::<T>(2 * (n - window + 1) * (window - p));
    let basis = |row: usize, k: usize| {
        let (kind, i) = chosen[k];
        let root = T::from_f64(core::f64::consts::FRAC_1_SQRT_2);
        if row < half {
            root * vectors[kind][row][i]
        } else if kind == 0 {
            root * vectors[kind][window - 1 - row][i]
        } else {
            -root * vectors[kind][window - 1 - row][i]
        }
    };
    // (U₁ᵀU₁)⁻¹ = I + u·uᵀ/(1 − uᵀu) with u the row that U₁ lacks.
    let mut phi = [[T::ZERO; N]; N];
    let mut last = [T::ZERO; N];
    for i in 0..p {
        last[i] = basis(window - 1, i);
        for (j, x) in phi[i][..p].iter_mut().enumerate() {
            for row in 0..window - 1 {
                *x += basis(row, i) * basis(row + 1, j);
            }
        }
    }
    let rest = T::ONE - last[..p].iter().map(|x| *x * *x).sum::<T>();
    if !(rest > T::EPSILON) {
        return Err(FitError::Singular);
    }
    let mut shared = [T::ZERO; N];
    for (row, u) in phi[..p].iter().zip(&last) {
        for (s, x) in shared[..p].iter_mut().zip(row) {
            *s += *u * *x / rest;
        }
    }
    for (row, u) in phi[..p].iter_mut().zip(&last) {
        for (x, s) in row[..p].iter_mut().zip(&shared) {
            *x += *u * *s;
        }
    }
    let a = characteristic(&mut phi, p);
    if !a.iter().all(|x| x.is_finite()) {
        return Err(FitError::Singular);
    }
    Ok(ArFit {
        a,
        p,
        sigma2: series.unscale_variance((all - kept).max(T::ZERO) / products),
        samples: n,
    })
}

/// The halves of R: on vectors (x, Jx) and on vectors (x, −Jx).
fn covariance<T: Real, const H: usize>(series: &Series<'_, T>, half: usize) -> [[[T; H]; H]; 2] {
    let window = 2 * half;
    let columns = series.len() - window + 1;
    let mut out = [[[T::ZERO; H]; H]; 2];
    let mut add = |i: usize, j: usize, x: T| {
        if i >= half {
            return;
        }
        if j < half {
            out[0][i][j] += x;
            out[1][i][j] += x;
        } else {
            out[0][i][window - 1 - j] += x;
            out[1][i][window - 1 - j] -= x;
        }
    };
    for lag in 0..window {
        let mut product: T = (0..columns)
            .map(|t| series.at(t) * series.at(t + lag))
            .sum();
        for i in 0..window - lag {
            let j = i + lag;
            add(i, j, product);
            add(window - 1 - i, window - 1 - j, product);
            if lag > 0 {
                add(j, i, product);
                add(window - 1 - j, window - 1 - i, product);
            }
            if j + 1 < window {
                product +=
                    series.at(i + columns) * series.at(j + columns) - series.at(i) * series.at(j);
            }
        }
    }
    out
}
