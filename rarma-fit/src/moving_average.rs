//! Moving averages by the innovations algorithm.

use super::ar::check_order;
use super::error::FitError;
use super::series::Series;
use rarma_core::real::Real;

/// A moving average y = C(q)·e with C = 1 + Σ cᵢ q⁻ⁱ, of order q ≤ `N`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaFit<T, const N: usize> {
    c: [T; N],
    q: usize,
    sigma2: T,
}

impl<T: Real, const N: usize> MaFit<T, N> {
    /// Coefficients c₁…c_q, without the leading 1.
    pub fn c(&self) -> &[T] {
        &self.c[..self.q]
    }

    /// Innovation variance σ², input units squared.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }
}

/// Innovations algorithm: one-step predictors of growing length from the sample
/// autocovariances r (about 0, over n), whose coefficients tend to those of the
/// moving average.
///
/// ```text
/// v₀ = r(0),   θ(m, m−k) = [r(m−k) − Σ_{j<k} θ(k, k−j)·θ(m, m−j)·v_j] / v_k,   0 ≤ k < m
/// v_m = r(0) − Σ_{j<m} θ(m, m−j)²·v_j,   cᵢ = θ(rows, i),   σ² = v_rows
/// ```
///
/// `rows` ≥ q, at most `N`: more of them bring the estimate nearer to its limit; the
/// textbook example takes rows = q. Moment estimates scatter more than [`Pem`](super::Pem),
/// which they can start. Needs rows + 1 samples, mean removed.
///
/// P. J. Brockwell and R. A. Davis, *Introduction to Time Series and Forecasting*,
/// section 5.1.
///
/// # Errors
/// `OutOfRange` for rows < q, otherwise see [`FitError`].
pub fn innovations_algorithm<T: Real, const N: usize>(
    y: &[T],
    q: usize,
    rows: usize,
) -> Result<MaFit<T, N>, FitError> {
    check_order::<N>(q)?;
    check_order::<N>(rows)?;
    if rows < q {
        return Err(FitError::OutOfRange);
    }
    let series = Series::new(y, rows + 1)?;
    let r0 = series.autocovariance(0);
    let mut r = [T::ZERO; N];
    for (k, r) in r[..rows].iter_mut().enumerate() {
        *r = series.autocovariance(k + 1);
    }
    // theta[m−1][i−1] = θ(m, i); v[m−1] = v_m.
    let mut theta = [[T::ZERO; N]; N];
    let mut v = [T::ZERO; N];
    for m in 1..=rows {
        let mut power = r0;
        for k in 0..m {
            let mut sum = r[m - k - 1];
            for j in 0..k {
                let v_j = if j == 0 { r0 } else { v[j - 1] };
                sum -= theta[k - 1][k - j - 1] * theta[m - 1][m - j - 1] * v_j;
            }
            let v_k = if k == 0 { r0 } else { v[k - 1] };
            let coefficient = sum / v_k;
            theta[m - 1][m - k - 1] = coefficient;
            power -= coefficient * coefficient * v_k;
        }
        if !(power > r0 * T::EPSILON) {
            return Err(FitError::Singular);
        }
        v[m - 1] = power;
    }
    let mut c = [T::ZERO; N];
    c[..q].copy_from_slice(&theta[rows - 1][..q]);
    Ok(MaFit {
        c,
        q,
        sigma2: series.unscale_variance(v[rows - 1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::arma;

    #[test]
    fn finds_a_moving_average() {
        let y = arma(&[], &[0.6, 0.3], 40_000, 5);
        let fit = innovations_algorithm::<f64, 40>(&y, 2, 40).expect("valid");
        assert!((fit.c()[0] - 0.6).abs() < 0.03 && (fit.c()[1] - 0.3).abs() < 0.03);
        assert!((fit.sigma2() - 1.0).abs() < 0.03, "{}", fit.sigma2());
    }

    #[test]
    fn one_row_is_the_first_autocorrelation() {
        let y = arma(&[-0.5], &[], 100, 1);
        let r = |k: usize| -> f64 { (k..100).map(|t| y[t] * y[t - k]).sum() };
        let fit = innovations_algorithm::<f64, 3>(&y, 1, 1).expect("valid");
        assert!((fit.c()[0] - r(1) / r(0)).abs() < 1e-12);
        let refused = |q, rows| innovations_algorithm::<f64, 3>(&y, q, rows).err();
        assert_eq!(refused(2, 1), Some(FitError::OutOfRange));
        assert_eq!(refused(2, 4), Some(FitError::OrderAboveCapacity));
        assert_eq!(refused(0, 1), Some(FitError::NothingToEstimate));
    }
}
