//! Choice of the order: what a better fit costs in parameters.

use super::error::FitError;
use super::series::count;
use rarma_core::real::Real;

/// Information criteria of one model; the smallest of several candidates, all
/// fitted to the same samples, is the choice.
///
/// ```text
/// AIC = n·ln σ² + 2k           AICc = AIC + 2k(k+1)/(n−k−1)
/// BIC = n·ln σ² + k·ln n       FPE  = σ²·(n+k)/(n−k)
/// ```
///
/// The constant n·(ln 2π + 1) of the Gaussian likelihood is left out, as it is the
/// same for every candidate. AIC and FPE agree for large n and tend to too many
/// parameters; BIC finds the true order as n grows; AICc is AIC for n below 40k.
///
/// ```
/// use rarma_fit::Criteria;
/// let small = Criteria::of(1.0f64, 500, 3)?;
/// let large = Criteria::of(0.999, 500, 7)?;   // 0.1 % better for 4 parameters more
/// assert!(small.aic < large.aic && small.bic < large.bic);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criteria<T> {
    /// Akaike's information criterion, 1.
    pub aic: T,
    /// The same corrected for short series, 1.
    pub aicc: T,
    /// Schwarz' Bayesian criterion, 1.
    pub bic: T,
    /// Akaike's final prediction error, input units squared.
    pub fpe: T,
}

impl<T: Real> Criteria<T> {
    /// From the innovation variance `sigma2` (sum of squares over n), the number of
    /// samples n and of estimated coefficients k.
    ///
    /// # Errors
    /// `TooFewSamples` for n < k + 2, `OutOfRange` unless `sigma2` is positive and
    /// finite.
    pub fn of(sigma2: T, n: usize, k: usize) -> Result<Self, FitError> {
        let needed = k.saturating_add(2);
        if n < needed {
            return Err(FitError::TooFewSamples { needed });
        }
        if !(sigma2 > T::ZERO && sigma2.is_finite()) {
            return Err(FitError::OutOfRange);
        }
        let two = T::from_f64(2.0);
        let fit = count::<T>(n) * sigma2.ln();
        let k_real = count::<T>(k);
        let aic = fit + two * k_real;
        Ok(Self {
            aic,
            aicc: aic + two * k_real * count(k + 1) / count(n - k - 1),
            bic: fit + k_real * count::<T>(n).ln(),
            fpe: sigma2 * count(n + k) / count(n - k),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas() {
        let c = Criteria::of(2.0f64, 100, 4).expect("valid");
        let fit = 100.0 * 2f64.ln();
        assert!((c.aic - fit - 8.0).abs() < 1e-12);
        assert!((c.aicc - c.aic - 40.0 / 95.0).abs() < 1e-12);
        assert!((c.bic - fit - 4.0 * 100f64.ln()).abs() < 1e-12);
        assert!((c.fpe - 2.0 * 104.0 / 96.0).abs() < 1e-12);
    }

    #[test]
    fn refuses_by_cause() {
        assert_eq!(
            Criteria::of(1.0, 5, 4),
            Err(FitError::TooFewSamples { needed: 6 })
        );
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Criteria::of(bad, 50, 4), Err(FitError::OutOfRange));
        }
    }
}
