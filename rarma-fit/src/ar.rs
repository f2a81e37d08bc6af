//! Autoregressive models: the result type and the Yule–Walker equations.

use super::error::FitError;
use super::polynomial::step_up;
use super::series::Series;
use rarma_core::real::Real;

/// An autoregressive model A(q)·y = e with A = 1 + Σ aᵢ q⁻ⁱ (plus signs), of order
/// p ≤ `N`.
///
/// A textbook model y = Σ φᵢ y(t−i) + e has aᵢ = −φᵢ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArFit<T, const N: usize> {
    pub(super) a: [T; N],
    pub(super) p: usize,
    pub(super) sigma2: T,
    pub(super) samples: usize,
}

impl<T: Real, const N: usize> ArFit<T, N> {
    /// Coefficients a₁…a_p, without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.a[..self.p]
    }

    /// Variance of the prediction error, input units squared; how it is counted is
    /// said at the method. Not corrected for the number of parameters.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }

    /// Samples the model was made from.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Reflection coefficients k₁…k_p with k_p = a_p (the partial autocorrelations
    /// with the sign changed), all below 1 in magnitude; none if the model is not
    /// stable, which only the least-squares methods and the instrumental variables
    /// allow.
    pub fn reflections(&self) -> Option<[T; N]> {
        super::polynomial::reflections::<T, N>(self.a())
    }
}

/// Checks of the order that every method of the family shares.
pub(super) fn check_order<const N: usize>(p: usize) -> Result<(), FitError> {
    if p > N {
        Err(FitError::OrderAboveCapacity)
    } else if p == 0 {
        Err(FitError::NothingToEstimate)
    } else {
        Ok(())
    }
}

/// Yule–Walker: the model whose first p autocovariances are those of the series.
///
/// ```text
/// r(k) = Σ y(t)·y(t+k)/n,     Σᵢ aᵢ r(k−i) = −r(k),  k = 1…p      (Levinson–Durbin)
/// ```
///
/// Always stable. Biased towards damping when the decay is long against the
/// series; [`burg`](super::burg) is not. σ² = r(0)·Π(1 − kᵢ²). Needs p + 1 samples, mean removed.
///
/// # Errors
/// The cause of the refusal, see [`FitError`].
pub fn yule_walker<T: Real, const N: usize>(y: &[T], p: usize) -> Result<ArFit<T, N>, FitError> {
    check_order::<N>(p)?;
    let series = Series::new(y, p + 1)?;
    let mut r = [T::ZERO; N];
    for (k, r) in r[..p].iter_mut().enumerate() {
        *r = series.autocovariance(k + 1);
    }
    let mut power = series.autocovariance(0);
    let floor = power * T::EPSILON;
    let mut a = [T::ZERO; N];
    for m in 1..=p {
        let mut sum = r[m - 1];
        for i in 0..m - 1 {
            sum += a[i] * r[m - 2 - i];
        }
        let k = -sum / power;
        power *= T::ONE - k * k;
        if !(power > floor) {
            return Err(FitError::Singular);
        }
        step_up(&mut a, m, k);
    }
    Ok(ArFit {
        a,
        p,
        sigma2: series.unscale_variance(power),
        samples: y.len(),
    })
}
