//! Exact Gaussian maximum likelihood of a stationary ARMA model.

use super::error::FitError;
use super::fit::ArmaFit;
use super::kalman::Innovation;
use super::levenberg::{Limits, Problem, minimise};
use super::pem::{Pem, PemConfig, check};
use super::polynomial::{reflections, shrink};
use super::prediction::Orders;
use super::series::{Accumulator, Series, count, mean};
use super::starts::from_lines;
use super::triangle::Triangle;
use rarma_core::real::Real;

/// Settings of [`Ml`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MlConfig<T> {
    /// Of the prediction-error fit that gives the start, and of the search.
    pub pem: PemConfig<T>,
    /// Estimates the mean jointly (generalised least squares at each step) instead
    /// of taking it as 0. Default false.
    pub with_mean: bool,
}

impl<T: Real> Default for MlConfig<T> {
    fn default() -> Self {
        Self {
            pem: PemConfig::default(),
            with_mean: false,
        }
    }
}

/// Exact maximum likelihood for short series.
///
/// With the innovations v(t) and their variances σ²F(t) from a Kalman filter that
/// starts in the stationary state,
///
/// ```text
/// −2·ln L = n·ln 2πσ² + Σ ln F(t) + Σ v(t)²/(σ²F(t))
/// ```
///
/// σ² = Σ(v²/F)/n is eliminated, and the rest is minimised as the sum of squares of
/// u(t) = v(t)·√(G/F(t)), G = (Π F)^(1/n), by Levenberg–Marquardt with derivatives
/// by central differences. Nothing is lost at the start of the series, and C may
/// come close to the unit circle; both matter for tens to hundreds of samples. From
/// thousands on, [`Pem`] gives the same in a fraction of the time.
///
/// Sign convention as everywhere: A = 1 + Σ aᵢ q⁻ⁱ, C = 1 + Σ cᵢ q⁻ⁱ. A is kept
/// strictly stable, C inside `c_radius`. Generics of [`Ml::fit`]: `N` ≥ p + q
/// parameters, `R` ≥ max(p, q + 1) states.
///
/// ```
/// use rarma_fit::{Ml, MlConfig};
/// let y: [f64; 40] = core::array::from_fn(|t| ((t * t) as f64).sin() + 3.0);
/// let config = MlConfig { with_mean: true, ..MlConfig::default() };
/// let fit = Ml::new(config)?.fit::<2, 2>(&y, 1, 1)?;
/// assert!((fit.mean() - 3.0).abs() < 0.3 && fit.log_likelihood().is_finite());
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Ml<T> {
    config: MlConfig<T>,
}

/// Exact Gaussian likelihood of a given model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likelihood<T> {
    /// ln L at the σ² that maximises it, constants included.
    pub log_likelihood: T,
    /// That σ² = Σ(v²/F)/n, input units squared.
    pub sigma2: T,
}

/// Exact Gaussian likelihood of the model a, c (without the leading 1) on a series
/// with its mean removed; max(p, q + 1) ≤ `R`. For models that come from elsewhere.
///
/// # Errors
/// `NotStable` if A has a root on or outside the unit circle, otherwise see
/// [`FitError`].
pub fn likelihood<T: Real, const R: usize>(
    y: &[T],
    a: &[T],
    c: &[T],
) -> Result<Likelihood<T>, FitError> {
    let series = Series::new(y, 2)?;
    let order = Orders {
        p: a.len(),
        q: c.len(),
    };
    if order.p.max(order.q + 1) > R {
        return Err(FitError::OrderAboveCapacity);
    }
    let mut theta = [T::ZERO; 2 * super::LONGEST_AR];
    if order.n() > theta.len() {
        return Err(FitError::OrderAboveCapacity);
    }
    theta[..order.p].copy_from_slice(a);
    theta[order.p..order.n()].copy_from_slice(c);
    let exact = Exact::<T, R> {
        series: &series,
        order,
        radius: T::ONE,
        with_mean: false,
    };
    let run = exact.run(&theta).ok_or(FitError::NotStable)?;
    Ok(exact.report(&run))
}

/// Sums over one run of the filter.
#[derive(Debug, Clone, Copy)]
struct Run<T> {
    /// Σ ln F.
    log_variance: T,
    /// Least Σ v²/F, mean eliminated.
    squares: T,
    mean: T,
}

struct Exact<'a, T, const R: usize> {
    series: &'a Series<'a, T>,
    order: Orders,
    radius: T,
    with_mean: bool,
}

impl<T: Real, const R: usize> Exact<'_, T, R> {
    fn run(&self, theta: &[T]) -> Option<Run<T>> {
        let mut filter = Innovation::<T, R>::new(self.order, theta)?;
        let mut sums = [Accumulator::default(); 4];
        for t in 0..self.series.len() {
            let step = filter.step(self.series.at(t));
            sums[0].add(step.variance.ln());
            sums[1].add(step.y * step.y / step.variance);
            sums[2].add(step.y * step.level / step.variance);
            sums[3].add(step.level * step.level / step.variance);
        }
        let [log_variance, yy, yl, ll] = sums.map(|s| s.value());
        let mean = if self.with_mean && ll > T::ZERO {
            yl / ll
        } else {
            T::ZERO
        };
        let squares = yy - mean * yl;
        squares.is_finite().then_some(Run {
            log_variance,
            squares,
            mean,
        })
    }

    fn n_samples(&self) -> T {
        count(self.series.len())
    }

    fn report(&self, run: &Run<T>) -> Likelihood<T> {
        let n = self.n_samples();
        let two = T::from_f64(2.0);
        let sigma2 = run.squares / n;
        let log_variance = (two * T::PI * sigma2).ln() + two * self.series.scale().ln();
        Likelihood {
            log_likelihood: -(n * (log_variance + T::ONE) + run.log_variance) / two,
            sigma2: self.series.unscale_variance(sigma2),
        }
    }

    /// √G.
    fn weight(&self, run: &Run<T>) -> T {
        (run.log_variance / self.n_samples() * T::from_f64(0.5)).exp()
    }

    /// The filter of a model, with its mean and the weight of its residuals.
    fn residual<const N: usize>(&self, theta: &[T; N]) -> Option<(Innovation<T, R>, T, T)> {
        let run = self.run(theta)?;
        let filter = Innovation::new(self.order, theta)?;
        Some((filter, run.mean, self.weight(&run)))
    }

    fn inside<const N: usize>(&self, theta: &[T; N]) -> bool {
        theta.iter().all(|x| x.is_finite())
            && reflections::<T, N>(&theta[..self.order.p]).is_some()
            && rarma_core::estimate::schur::inside::<T, N>(
                &theta[self.order.p..self.order.n()],
                self.radius,
            )
    }
}

impl<T: Real, const N: usize, const R: usize> Problem<T, N> for Exact<'_, T, R> {
    fn n(&self) -> usize {
        self.order.n()
    }

    fn admissible(&self, theta: &[T; N]) -> bool {
        self.inside(theta)
    }

    fn cost(&self, theta: &[T; N]) -> T {
        match self.run(theta) {
            Some(run) => {
                let weight = self.weight(&run);
                run.squares * weight * weight
            }
            None => T::from_f64(f64::INFINITY),
        }
    }

    fn linearise(&self, theta: &[T; N]) -> Triangle<T, N> {
        let n = self.order.n();
        let mut triangle = Triangle::new(n);
        let Some(centre) = self.residual(theta) else {
            return triangle;
        };
        // Filters of the moved models run in step, so each sample gives one row.
        let mut above = [centre; N];
        let mut below = [centre; N];
        let mut width = [T::ONE; N];
        // Third root of the rounding: the best width of a central difference.
        let h0 = (T::EPSILON.ln() / T::from_f64(3.0)).exp();
        for i in 0..n {
            let h = h0 * theta[i].abs().max(T::from_f64(0.1));
            let side = |h: T| {
                let mut moved = *theta;
                moved[i] += h;
                // A hair outside is no model: the difference is one-sided there.
                self.residual(&moved)
            };
            let (up, down) = (side(h), side(-h));
            let sides = T::from_u32(u32::from(up.is_some()) + u32::from(down.is_some()));
            width[i] = h * sides.max(T::ONE);
            above[i] = up.unwrap_or(centre);
            below[i] = down.unwrap_or(centre);
        }
        let mut centre = centre;
        let residual = |x: &mut (Innovation<T, R>, T, T), y: T| {
            let step = x.0.step(y);
            (step.y - x.1 * step.level) * x.2 / step.variance.sqrt()
        };
        for t in 0..self.series.len() {
            let y = self.series.at(t);
            let mut row = [T::ZERO; N];
            for i in 0..n {
                row[i] = (residual(&mut above[i], y) - residual(&mut below[i], y)) / width[i];
            }
            let _ = triangle.add(&mut row, -residual(&mut centre, y));
        }
        triangle
    }
}

impl<T: Real> Ml<T> {
    /// An estimator with these settings.
    ///
    /// # Errors
    /// `OutOfRange` if a setting is out of its range.
    pub fn new(config: MlConfig<T>) -> Result<Self, FitError> {
        if config.pem.is_valid() {
            Ok(Self { config })
        } else {
            Err(FitError::OutOfRange)
        }
    }

    /// Fits ARMA(p, q), p + q ≤ `N` and max(p, q + 1) ≤ `R`, to `y`.
    ///
    /// # Errors
    /// The cause of the refusal, see [`FitError`].
    pub fn fit<const N: usize, const R: usize>(
        &self,
        y: &[T],
        p: usize,
        q: usize,
    ) -> Result<ArmaFit<T, N>, FitError> {
        self.solve::<N, R>(y, p, q, None)
    }

    /// Fits ARMA(p, q) from a given start only, θ = (a, c).
    ///
    /// # Errors
    /// `NotStable` if A of the start has a root on or outside the circle or C one
    /// outside `c_radius`, `OutOfRange` if `start` does not hold p + q numbers,
    /// otherwise see [`FitError`].
    pub fn fit_from<const N: usize, const R: usize>(
        &self,
        y: &[T],
        p: usize,
        q: usize,
        start: &[T],
    ) -> Result<ArmaFit<T, N>, FitError> {
        if start.len() != p.saturating_add(q) || start.iter().any(|x| !x.is_finite()) {
            return Err(FitError::OutOfRange);
        }
        self.solve::<N, R>(y, p, q, Some(start))
    }

    fn solve<const N: usize, const R: usize>(
        &self,
        y: &[T],
        p: usize,
        q: usize,
        given: Option<&[T]>,
    ) -> Result<ArmaFit<T, N>, FitError> {
        let offset = if self.config.with_mean && y.iter().all(|x| x.is_finite()) {
            mean(y)
        } else {
            T::ZERO
        };
        let series = check::<T, N>(y, offset, p, q)?;
        if p.max(q + 1) > R || p.max(q + 1) + q > super::LONGEST_AR {
            return Err(FitError::OrderAboveCapacity);
        }
        let order = Orders { p, q };
        let problem = Exact::<T, R> {
            series: &series,
            order,
            radius: self.config.pem.c_radius,
            with_mean: self.config.with_mean,
        };
        let limits = Limits {
            tolerance: self.config.pem.tolerance,
            iterations: self.config.pem.iterations,
            residuals: count(series.len()),
        };
        let found = match given {
            Some(given) => {
                let mut start = [T::ZERO; N];
                start[..order.n()].copy_from_slice(given);
                if !problem.inside(&start) {
                    return Err(FitError::NotStable);
                }
                minimise(&problem, start, limits)
            }
            None => {
                let start = self.start::<N>(&series, order);
                let mut found = minimise(&problem, start, limits);
                if start != [T::ZERO; N] && !found.converged {
                    // Second opinion from white noise.
                    let other = minimise(&problem, [T::ZERO; N], limits);
                    if other.cost < found.cost {
                        found = other;
                    }
                }
                if let Some(start) = from_lines::<T, N>(&series, order)
                    && problem.inside(&start)
                {
                    let other = minimise(&problem, start, limits);
                    let regular = |theta: &[T; N]| {
                        let triangle: Triangle<T, N> = problem.linearise(theta);
                        triangle.inverse_normal().is_some()
                    };
                    if other.cost < found.cost && regular(&other.theta) {
                        found = other;
                    }
                }
                found
            }
        };
        let run = problem.run(&found.theta).ok_or(FitError::Singular)?;
        let n = series.len();
        let triangle: Triangle<T, N> = problem.linearise(&found.theta);
        let mut covariance = triangle.inverse_normal().ok_or(FitError::Singular)?;
        let variance = found.cost / count(n - order.n());
        for x in covariance.iter_mut().flatten() {
            *x *= variance;
        }
        let Likelihood {
            log_likelihood,
            sigma2,
        } = problem.report(&run);
        Ok(ArmaFit {
            theta: found.theta,
            order,
            sigma2,
            mean: offset + run.mean * series.scale(),
            samples: n,
            covariance,
            log_likelihood,
            before: [T::ZERO; N],
            iterations: found.iterations,
            converged: found.converged,
        })
    }

    /// The prediction-error estimate, A pulled into the circle; white noise if
    /// there is none.
    fn start<const N: usize>(&self, series: &Series<'_, T>, order: Orders) -> [T; N] {
        let mut theta = [T::ZERO; N];
        let conditional =
            Pem::new(self.config.pem).and_then(|pem| pem.search_all::<N>(series, order));
        if let Ok(found) = conditional {
            theta = found.theta;
            shrink::<T, N>(&mut theta[..order.p], T::from_f64(0.99995));
        }
        theta
    }
}
