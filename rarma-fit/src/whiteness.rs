//! Is what a model leaves over white?

use super::error::FitError;
use super::series::{Accumulator, count};
use rarma_core::real::Real;

/// Ljung–Box test of the residuals of a fitted model.
///
/// ```text
/// r(k) = Σ e(t)·e(t−k)/Σ e(t)²,   Q = n(n+2)·Σ_{k=1}^{lags} r(k)²/(n−k)
/// ```
///
/// If the residuals are white, Q follows a χ² distribution with `lags` minus the number
/// of fitted coefficients as its degrees of freedom. A `probability` below 0.01 says
/// that the model misses something. Residuals are taken about 0 and one by one, so
/// any iterator will do, [`ArmaFit::residuals`](super::ArmaFit::residuals) first of all.
///
/// G. M. Ljung and G. E. P. Box, *Biometrika* 65, 1978.
///
/// ```
/// use rarma_fit::Whiteness;
/// let mut seed = 1u32;
/// let white = (0..2000).map(|_| {
///     seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     f64::from(seed >> 8) / 8_388_608.0 - 1.0
/// });
/// let test = Whiteness::of::<20>(white, 20, 0)?;
/// assert!(test.dof == 20 && test.probability > 0.001);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whiteness<T> {
    /// Q, 1.
    pub statistic: T,
    /// Degrees of freedom.
    pub dof: usize,
    /// Probability of a Q this large or larger from white residuals, 0 to 1.
    pub probability: T,
}

impl<T: Real> Whiteness<T> {
    /// Of `residuals` over `lags` ≤ `L` lags, for a model with `fitted`
    /// coefficients.
    ///
    /// # Errors
    /// `OrderAboveCapacity` for lags > L, `OutOfRange` for lags ≤ fitted,
    /// `TooFewSamples` for less than lags + 2 residuals, `NotFinite`, or `Constant`
    /// if all of them are 0.
    pub fn of<const L: usize>(
        residuals: impl IntoIterator<Item = T>,
        lags: usize,
        fitted: usize,
    ) -> Result<Self, FitError> {
        if lags > L {
            return Err(FitError::OrderAboveCapacity);
        }
        if lags <= fitted {
            return Err(FitError::OutOfRange);
        }
        let mut past = [T::ZERO; L];
        let mut sums = [Accumulator::<T>::default(); L];
        let mut power = Accumulator::<T>::default();
        let mut n = 0;
        for e in residuals {
            if !e.is_finite() {
                return Err(FitError::NotFinite { index: n });
            }
            for (sum, before) in sums[..lags].iter_mut().zip(&past) {
                sum.add(e * *before);
            }
            power.add(e * e);
            past.copy_within(..lags - 1, 1);
            past[0] = e;
            n += 1;
        }
        if n < lags + 2 {
            return Err(FitError::TooFewSamples { needed: lags + 2 });
        }
        let power = power.value();
        if !(power > T::ZERO) {
            return Err(FitError::Constant);
        }
        let mut q = T::ZERO;
        for (k, sum) in sums[..lags].iter().enumerate() {
            let r = sum.value() / power;
            q += r * r / count(n - k - 1);
        }
        let statistic = q * count(n) * count(n + 2);
        let dof = lags - fitted;
        Ok(Self {
            statistic,
            dof,
            probability: T::from_f64(chi2_above(statistic.to_f64(), dof)),
        })
    }
}

/// Probability that χ² with `dof` degrees of freedom exceeds x: the regularised
/// incomplete gamma function Q(dof/2, x/2). Slow path, in f64.
fn chi2_above(x: f64, dof: usize) -> f64 {
    let (s, x) = (0.5 * dof as f64, 0.5 * x);
    if !(x > 0.0) {
        return 1.0;
    }
    let front = libm::exp(s * libm::log(x) - x - libm::lgamma(s));
    if x < s + 1.0 {
        // Series of the lower function.
        let (mut term, mut sum) = (1.0 / s, 1.0 / s);
        for k in 1..10_000 {
            term *= x / (s + f64::from(k));
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        (1.0 - front * sum).clamp(0.0, 1.0)
    } else {
        // Continued fraction of the upper one (Lentz).
        let tiny = 1e-300;
        let mut b = x + 1.0 - s;
        let mut c = 1.0 / tiny;
        let mut d = 1.0 / b;
        let mut h = d;
        for k in 1..10_000 {
            let k = f64::from(k);
            let a = -k * (k - s);
            b += 2.0;
            d = 1.0 / keep_off_zero(a * d + b, tiny);
            c = keep_off_zero(b + a / c, tiny);
            let change = c * d;
            h *= change;
            if (change - 1.0).abs() < 1e-15 {
                break;
            }
        }
        (front * h).clamp(0.0, 1.0)
    }
}

fn keep_off_zero(x: f64, tiny: f64) -> f64 {
    if x.abs() < tiny { tiny } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_square_of_known_points() {
        // Closed forms: dof 2: e^(−x/2); dof 4: e^(−x/2)(1 + x/2); dof 1: erfc √(x/2).
        for x in [0.01, 0.5, 1.0, 3.0, 10.0, 40.0, 120.0] {
            let e = (-0.5f64 * x).exp();
            for (dof, want) in [
                (1, libm::erfc((0.5 * x).sqrt())),
                (2, e),
                (4, e * (1.0 + 0.5 * x)),
            ] {
                let got = chi2_above(x, dof);
                assert!(
                    (got - want).abs() < 1e-12 * want.max(1e-2),
                    "{x} {dof}: {got} {want}"
                );
            }
        }
        // 95 % points of the usual table.
        for (dof, x) in [(10, 18.307), (20, 31.410), (30, 43.773)] {
            assert!((chi2_above(x, dof) - 0.05).abs() < 1e-5);
        }
        assert_eq!(chi2_above(0.0, 3), 1.0);
    }

    fn noise(seed: u32, n: usize) -> impl Iterator<Item = f64> {
        let mut seed = seed;
        (0..n).map(move |_| {
            let mut sum = 0.0;
            for _ in 0..4 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(seed >> 8) / 8_388_608.0 - 1.0;
            }
            sum
        })
    }

    #[test]
    fn white_passes_at_its_rate_and_coloured_fails() {
        let runs = 400;
        let mut alarms = 0;
        for seed in 0..runs {
            let test = Whiteness::of::<20>(noise(seed * 7919 + 1, 500), 20, 0).expect("valid");
            alarms += u32::from(test.probability < 0.05);
        }
        // Expected 20, standard deviation 4.4.
        assert!((8..=36).contains(&alarms), "{alarms} alarms of {runs}");
        let mut last = 0.0;
        let coloured = noise(3, 500).map(|e| {
            last = 0.4 * last + e;
            last
        });
        let test = Whiteness::of::<20>(coloured, 20, 0).expect("valid");
        assert!(test.probability < 1e-6);
    }

    #[test]
    fn statistic_by_hand() {
        // e = 1, −1, 1, −1, 1, −1: r(1) = −5/6, r(2) = 4/6.
        let e = [1.0f64, -1.0, 1.0, -1.0, 1.0, -1.0];
        let test = Whiteness::of::<4>(e, 2, 1).expect("valid");
        let want = 48.0 * ((25.0 / 36.0) / 5.0 + (16.0 / 36.0) / 4.0);
        assert!((test.statistic - want).abs() < 1e-12 && test.dof == 1);
    }

    #[test]
    fn refuses_by_cause() {
        let e = [1.0f32, 2.0, 3.0];
        assert_eq!(
            Whiteness::of::<1>(e, 2, 0),
            Err(FitError::OrderAboveCapacity)
        );
        assert_eq!(Whiteness::of::<4>(e, 2, 2), Err(FitError::OutOfRange));
        assert_eq!(
            Whiteness::of::<4>(e, 2, 0),
            Err(FitError::TooFewSamples { needed: 4 })
        );
        assert_eq!(
            Whiteness::of::<4>([1.0, f32::NAN], 1, 0),
            Err(FitError::NotFinite { index: 1 })
        );
        assert_eq!(
            Whiteness::of::<4>([0.0f32; 9], 2, 0),
            Err(FitError::Constant)
        );
    }
}
