//! A response to a known input: ARX by least squares, and by refined instruments.

use super::arx_fit::{ArxFit, ArxOrder};
use super::columns::{Columns, step};
use super::error::FitError;
use super::instruments::Instruments;
use super::polynomial::{reflect, reflections};
use super::series::{Accumulator, Series, count};
use super::triangle::Triangle;
use rarma_core::real::Real;

/// Rounds of the instruments at most; five to eight are usual.
const ROUNDS: u32 = 50;
/// Change of every parameter, in standard deviations, at which the rounds end.
const SETTLED: f64 = 1e-3;
/// Roots of A at most this far out in the simulated output.
const RADIUS: f64 = 0.9999;

/// Input and output, checked, each over its own power of two.
struct Records<'a, T> {
    y: Series<'a, T>,
    u: Series<'a, T>,
    order: ArxOrder,
}

/// ARX by least squares, for an exciter whose command or force is recorded:
///
/// ```text
/// A(q)·y(t) = B(q)·u(t−d) + e(t),   A = 1 + Σ aᵢ q⁻ⁱ,   B = Σ_{j<m} b_j q⁻ʲ
/// min over a, b of Σ_t [y(t) + Σ aᵢ y(t−i) − Σ b_j u(t−d−j)]²,   t ≥ max(p, d + m − 1)
/// ```
///
/// Sign convention: plus in A, as everywhere; a textbook y = Σ φᵢ y(t−i) + Σ b_j u(t−d−j)
/// has aᵢ = −φᵢ. A sampled mode driven by force held between samples is (p, m, d) =
/// (2, 2, 1), n of them (2n, 2n, 1).
///
/// Efficient if the disturbance is white *through 1/A*, as cutting noise through the
/// same structure is. Noise added to the output (a sensor, another machine) pulls A
/// towards strong damping, however long the record: take [`arx_instruments`] there.
///
/// `N` ≥ p + m; needs max(p, d + m − 1) + 2(p + m) samples, means removed.
/// σ² = Σe²/(equations − p − m), covariance σ²·(ΦᵀΦ)⁻¹. Solved by rotations.
///
/// ```
/// use rarma_fit::{ArxOrder, arx};
/// let u: [f64; 60] = core::array::from_fn(|t| ((t * t) as f64).sin());
/// let mut y = [0.0; 60];
/// for t in 2..60 {
///     y[t] = 1.6 * y[t - 1] - 0.95 * y[t - 2] + 0.5 * u[t - 1] + 0.2 * u[t - 2];
/// }
/// let fit = arx::<_, 4>(&y, &u, ArxOrder { p: 2, b: 2, delay: 1 })?;
/// assert!((fit.a()[0] + 1.6).abs() < 1e-9 && (fit.b()[1] - 0.2).abs() < 1e-9);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
///
/// # Errors
/// `DifferentLengths`; `InputNotFinite`; `NoExcitation` if the input is constant or
/// has fewer lines than B needs; `Singular` if the output then has too few;
/// otherwise see [`FitError`].
pub fn arx<T: Real, const N: usize>(
    y: &[T],
    u: &[T],
    order: ArxOrder,
) -> Result<ArxFit<T, N>, FitError> {
    let records = Records::new::<N>(y, u, order)?;
    records.least_squares()
}

/// The same model from instruments, for noise on the output (refined instrumental
/// variables, Young's): with the simulated output x = B/A·u(t−d) of the round before,
///
/// ```text
/// Σ_t ζ_f(t)·[y_f(t) − φ_f(t)ᵀθ] = 0,   φ = (−y(t−i), u(t−d−j)),   ζ = (−x(t−i), u(t−d−j))
/// ```
///
/// where f means filtered by 1/A of the round before. x knows nothing of the noise, so
/// the estimate is consistent whatever the noise is, provided it does not depend on u:
/// not in closed loop. With white noise on the output it is efficient, and the
/// covariance, σ²·(ZᵀZ)⁻¹ with σ² the power of that noise, holds; with coloured noise
/// the covariance is an approximation.
///
/// Starts from [`arx`]; ends when no parameter moves by more than 1e-3 standard
/// deviations, or after 50 rounds with `converged()` false. Otherwise as [`arx`].
///
/// # Errors
/// As [`arx`]; `Singular` also if the simulated output does not explain the recorded
/// one at all.
pub fn arx_instruments<T: Real, const N: usize>(
    y: &[T],
    u: &[T],
    order: ArxOrder,
) -> Result<ArxFit<T, N>, FitError> {
    let records = Records::new::<N>(y, u, order)?;
    let settled = T::from_f64(SETTLED);
    let mut fit = records.least_squares_scaled::<N>()?;
    fit.converged = false;
    for round in 1..=ROUNDS {
        let next = records.refine(&fit, round)?;
        let largest = next.theta.iter().fold(T::ZERO, |m, x| m.max(x.abs()));
        // Without noise the deviations are rounding: a floor of its own.
        let floor = T::EPSILON.sqrt() * T::from_f64(0.01) * largest;
        let still = (0..order.parameters())
            .all(|i| (next.theta[i] - fit.theta[i]).abs() <= settled * next.deviation(i) + floor);
        fit = next;
        if still {
            fit.converged = true;
            break;
        }
    }
    Ok(records.unscaled(fit))
}

impl<'a, T: Real> Records<'a, T> {
    fn new<const N: usize>(y: &'a [T], u: &'a [T], order: ArxOrder) -> Result<Self, FitError> {
        if order.p.saturating_add(order.b) > N {
            return Err(FitError::OrderAboveCapacity);
        }
        if order.b == 0 {
            return Err(FitError::NothingToEstimate);
        }
        if y.len() != u.len() {
            return Err(FitError::DifferentLengths);
        }
        let needed = order.start().saturating_add(2 * order.parameters());
        let y = Series::new(y, needed)?;
        let u = Series::new(u, needed).map_err(|why| match why {
            FitError::NotFinite { index } => FitError::InputNotFinite { index },
            FitError::Constant => FitError::NoExcitation,
            other => other,
        })?;
        let records = Self { y, u, order };
        if records.excitation::<N>().solve().is_none() {
            return Err(FitError::NoExcitation);
        }
        Ok(records)
    }

    /// The columns of the input alone.
    fn excitation<const N: usize>(&self) -> Triangle<T, N> {
        let mut triangle = Triangle::new(self.order.b);
        for t in self.order.start()..self.u.len() {
            let mut row = [T::ZERO; N];
            for (j, x) in row[..self.order.b].iter_mut().enumerate() {
                *x = self.u.at(t - self.order.delay - j);
            }
            let _ = triangle.add(&mut row, T::ZERO);
        }
        triangle
    }

    /// φ(t), or ζ(t) with the past of the simulated output instead.
    fn row<const N: usize>(&self, t: usize, past: Option<&[T; N]>) -> [T; N] {
        let ArxOrder { p, b, delay } = self.order;
        let mut row = [T::ZERO; N];
        for (i, x) in row[..p].iter_mut().enumerate() {
            *x = match past {
                Some(past) => -past[i],
                None => -self.y.at(t - 1 - i),
            };
        }
        for (j, x) in row[p..p + b].iter_mut().enumerate() {
            *x = self.u.at(t - delay - j);
        }
        row
    }

    /// Least squares, in scaled units for the rounds that may follow.
    fn least_squares_scaled<const N: usize>(&self) -> Result<ArxFit<T, N>, FitError> {
        let k = self.order.parameters();
        let mut triangle = Triangle::<T, N>::new(k);
        let mut sum = Accumulator::default();
        for t in self.order.start()..self.y.len() {
            let rest = triangle.add(&mut self.row(t, None), self.y.at(t));
            sum.add(rest * rest);
        }
        let theta = triangle.solve().ok_or(FitError::Singular)?;
        let inverse = triangle.inverse_normal().ok_or(FitError::Singular)?;
        Ok(self.result(theta, inverse, sum.value(), 0, true))
    }

    fn least_squares<const N: usize>(&self) -> Result<ArxFit<T, N>, FitError> {
        Ok(self.unscaled(self.least_squares_scaled()?))
    }

    /// One round of instruments, in scaled units.
    fn refine<const N: usize>(
        &self,
        before: &ArxFit<T, N>,
        round: u32,
    ) -> Result<ArxFit<T, N>, FitError> {
        let ArxOrder { p, b, delay } = self.order;
        let k = p + b;
        let mut a = [T::ZERO; N];
        a[..p].copy_from_slice(before.a());
        if reflections::<T, N>(&a[..p]).is_none() {
            reflect::<T, N>(&mut a[..p], T::from_f64(RADIUS));
        }
        let a = &a[..p];
        let mut equations = Instruments::<T, N>::new(k);
        // x(t−1)…x(t−p), newest first; columns of φ and ζ, and the output, filtered.
        let mut past = [T::ZERO; N];
        let mut columns = [Columns::<T, N>::new(p, k); 2];
        let mut output = [T::ZERO; N];
        let mut power = Accumulator::default();
        for t in 0..self.y.len() {
            if t >= self.order.start() {
                let [of_phi, of_zeta] = &mut columns;
                let mut phi = of_phi.filtered(a, &self.row(t, None));
                let mut zeta = of_zeta.filtered(a, &self.row(t, Some(&past)));
                let target = step(a, &mut output[..p], self.y.at(t));
                let mut error = target;
                for (x, theta) in phi[..k].iter().zip(&before.theta) {
                    error -= *x * *theta;
                }
                power.add(error * error);
                equations.add(&mut zeta, &mut phi, target);
            }
            let mut drive = T::ZERO;
            for (j, b) in before.b().iter().enumerate() {
                if t >= delay + j {
                    drive += *b * self.u.at(t - delay - j);
                }
            }
            step(a, &mut past[..p], drive);
        }
        let theta = equations.solve().ok_or(FitError::Singular)?;
        let inverse = equations.inverse_normal().ok_or(FitError::Singular)?;
        Ok(self.result(theta, inverse, power.value(), round, false))
    }

    fn result<const N: usize>(
        &self,
        theta: [T; N],
        mut covariance: [[T; N]; N],
        squares: T,
        rounds: u32,
        converged: bool,
    ) -> ArxFit<T, N> {
        let equations = self.y.len() - self.order.start();
        let sigma2 = squares / count(equations - self.order.parameters());
        for x in covariance.iter_mut().flatten() {
            *x *= sigma2;
        }
        ArxFit {
            theta,
            order: self.order,
            sigma2,
            samples: equations,
            covariance,
            rounds,
            converged,
        }
    }

    /// In input units: b in output over input.
    fn unscaled<const N: usize>(&self, mut fit: ArxFit<T, N>) -> ArxFit<T, N> {
        let gain = self.y.scale() / self.u.scale();
        let ArxOrder { p, b, .. } = self.order;
        fit.sigma2 = self.y.unscale_variance(fit.sigma2);
        for x in &mut fit.theta[p..p + b] {
            *x *= gain;
        }
        for (i, row) in fit.covariance.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                for k in [i, j] {
                    if (p..p + b).contains(&k) {
                        *x *= gain;
                    }
                }
            }
        }
        fit
    }
}
