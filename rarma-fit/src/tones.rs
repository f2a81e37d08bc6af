//! Undamped tones in white noise by exact maximum likelihood.

use super::ar::ArFit;
use super::block::Collected;
use super::error::FitError;
use super::levenberg::{Limits, Minimum, Problem, minimise};
use super::series::{Accumulator, Series, count};
use super::subspace::{half_window, lines};
use super::triangle::Triangle;
use rarma_core::real::Real;
use rarma_core::spectrum::{FactorTracker, Roots};

/// One tone: amplitude·cos(2πf·t/fs + phase), t = 0 at the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone<T> {
    /// Frequency, Hz.
    pub frequency: T,
    /// Standard deviation of it, Hz.
    pub frequency_sd: T,
    /// Amplitude (peak), input units.
    pub amplitude: T,
    /// Standard deviation of it, input units.
    pub amplitude_sd: T,
    /// Phase at the first sample, rad, −π to π.
    pub phase: T,
}

/// Tones fitted to a series; see [`tones`].
#[derive(Debug, Clone, Copy)]
pub struct ToneFit<T, const N: usize> {
    /// (ω, cosine, sine) of each tone, about the middle of the series.
    theta: [T; N],
    covariance: [[T; N]; N],
    count: usize,
    sigma2: T,
    scale: T,
    samples: usize,
    converged: bool,
}

/// Tones in white Gaussian noise by exact maximum likelihood, which for them is
/// least squares of the series itself:
///
/// ```text
/// min over ω, b, c of Σ_t [y(t) − Σ_k b_k·cos ω_k t′ + c_k·sin ω_k t′]²,   t′ = t − (n − 1)/2
/// ```
///
/// by Levenberg–Marquardt from the subspace estimates ([`esprit`](super::esprit)) of
/// several windows and orders, the least sum of squares wins. Reaches the Cramér–Rao
/// bound where the lines are resolved; what is a decaying or noise-driven mode is not
/// a tone and comes out wrong.
///
/// Generics: `N` ≥ 3·`tones` parameters, `H` ≥ `tones` + 3 half the window of the
/// subspace at most. Needs 6·`tones` + 8 samples, mean removed. Covariance
/// σ²·(JᵀJ)⁻¹ with σ² = Σe²/(n − 3·`tones`).
///
/// ```
/// use rarma_fit::tones;
/// let y: [f64; 64] = core::array::from_fn(|t| {
///     let t = t as f64;
///     3.0 * (0.7 * t + 0.4).cos() + 0.5 * (0.8 * t).sin() + 0.01 * (t * t).sin()
/// });
/// let fit = tones::<_, 6, 24>(&y, 2)?;
/// let first = fit.tone(0, 1000.0).unwrap();
/// assert!((first.amplitude - 3.0).abs() < 0.02 && (first.phase - 0.4).abs() < 0.02);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
///
/// # Errors
/// `Singular` if so many tones are not found, otherwise see [`FitError`].
pub fn tones<T: Real, const N: usize, const H: usize>(
    y: &[T],
    tones: usize,
) -> Result<ToneFit<T, N>, FitError> {
    if tones == 0 {
        return Err(FitError::NothingToEstimate);
    }
    if tones.saturating_mul(3) > N || tones.saturating_add(3) > H {
        return Err(FitError::OrderAboveCapacity);
    }
    let series = Series::new(y, 6 * tones + 8)?;
    let problem = Lines {
        series: &series,
        tones,
    };
    let limits = Limits {
        tolerance: T::from_f64(1e-4),
        iterations: 100,
        residuals: count(series.len()),
    };
    let mut best: Option<Minimum<T, N>> = None;
    let half = |share: f64| half_window(series.len(), T::from_f64(share), H);
    for (k, share) in SHARES.into_iter().enumerate() {
        // A long series fills the window whatever its share.
        if SHARES[..k].iter().any(|other| half(*other) == half(share)) {
            continue;
        }
        for extra in EXTRA {
            let Some(start) = problem.start::<N, H>(2 * tones + extra, T::from_f64(share)) else {
                continue;
            };
            let found = minimise(&problem, start, limits);
            if best.as_ref().is_none_or(|b| found.cost < b.cost) {
                best = Some(found);
            }
        }
    }
    let found = best.ok_or(FitError::Singular)?;
    problem.finish(found)
}

/// Halves of the windows over the length, and poles beyond two for each tone: noise
/// takes some, and which window resolves depends on the phases.
const SHARES: [f64; 3] = [0.36, 0.25, 0.42];
const EXTRA: [usize; 3] = [0, 2, 6];

struct Lines<'a, T> {
    series: &'a Series<'a, T>,
    tones: usize,
}

impl<T: Real> Lines<'_, T> {
    fn middle(&self) -> T {
        (count::<T>(self.series.len()) - T::ONE) * T::from_f64(0.5)
    }

    /// Frequencies of the poles next to the circle, amplitudes by least squares.
    fn start<const N: usize, const H: usize>(&self, p: usize, share: T) -> Option<[T; N]> {
        let fit: ArFit<T, H> = lines::<T, H, H>(self.series, p, share).ok()?;
        let mut roots = FactorTracker::<T, H>::new();
        roots.solve(fit.a(), 300)?;
        let mut angles = [(T::ZERO, T::ZERO); H];
        let mut m = 0;
        for factor in roots.factors(p) {
            if let Roots::Pair { re, im } = factor.roots() {
                angles[m] = ((factor.v - T::ONE).abs(), im.atan2(re));
                m += 1;
            }
        }
        if m < self.tones {
            return None;
        }
        let mut theta = [T::ZERO; N];
        for k in 0..self.tones {
            let mut least = k;
            for i in k + 1..m {
                if angles[i].0 < angles[least].0 {
                    least = i;
                }
            }
            angles.swap(k, least);
            theta[3 * k] = angles[k].1;
        }
        self.amplitudes(&mut theta)?;
        Some(theta)
    }

    /// Least squares of the cosines and sines for given frequencies.
    fn amplitudes<const N: usize>(&self, theta: &mut [T; N]) -> Option<()> {
        let mut triangle = Triangle::<T, N>::new(2 * self.tones);
        for t in 0..self.series.len() {
            let time = count::<T>(t) - self.middle();
            let mut row = [T::ZERO; N];
            for k in 0..self.tones {
                let (sin, cos) = (theta[3 * k] * time).sin_cos();
                (row[2 * k], row[2 * k + 1]) = (cos, sin);
            }
            let _ = triangle.add(&mut row, self.series.at(t));
        }
        let found = triangle.solve()?;
        for k in 0..self.tones {
            theta[3 * k + 1] = found[2 * k];
            theta[3 * k + 2] = found[2 * k + 1];
        }
        Some(())
    }

    fn residual<const N: usize>(&self, theta: &[T; N], t: usize, row: &mut [T; N]) -> T {
        let time = count::<T>(t) - self.middle();
        let mut e = self.series.at(t);
        for k in 0..self.tones {
            let [w, b, c] = [theta[3 * k], theta[3 * k + 1], theta[3 * k + 2]];
            let (sin, cos) = (w * time).sin_cos();
            e -= b * cos + c * sin;
            row[3 * k] = time * (c * cos - b * sin);
            row[3 * k + 1] = cos;
            row[3 * k + 2] = sin;
        }
        e
    }

    fn finish<const N: usize>(&self, found: Minimum<T, N>) -> Result<ToneFit<T, N>, FitError> {
        let used = 3 * self.tones;
        let triangle: Triangle<T, N> = self.linearise(&found.theta);
        let mut covariance = triangle.inverse_normal().ok_or(FitError::Singular)?;
        let n = self.series.len();
        let variance = found.cost / count(n - used);
        for x in covariance.iter_mut().flatten() {
            *x *= variance;
        }
        let mut out = ToneFit {
            theta: found.theta,
            covariance,
            count: self.tones,
            sigma2: self.series.unscale_variance(found.cost / count(n)),
            scale: self.series.scale(),
            samples: n,
            converged: found.converged,
        };
        out.sort();
        Ok(out)
    }
}

impl<T: Real, const N: usize> Problem<T, N> for Lines<'_, T> {
    fn n(&self) -> usize {
        3 * self.tones
    }

    fn admissible(&self, theta: &[T; N]) -> bool {
        (0..self.tones).all(|k| theta[3 * k] > T::ZERO && theta[3 * k] < T::PI)
            && theta.iter().all(|x| x.is_finite())
    }

    fn cost(&self, theta: &[T; N]) -> T {
        let mut row = [T::ZERO; N];
        let mut sum = Accumulator::default();
        for t in 0..self.series.len() {
            let e = self.residual(theta, t, &mut row);
            sum.add(e * e);
        }
        sum.value()
    }

    fn linearise(&self, theta: &[T; N]) -> Triangle<T, N> {
        let mut equations = Collected::new(3 * self.tones);
        for t in 0..self.series.len() {
            let mut row = [T::ZERO; N];
            let e = self.residual(theta, t, &mut row);
            equations.add(&row, e);
        }
        equations.triangle()
    }
}

impl<T: Real, const N: usize> ToneFit<T, N> {
    /// Number of tones.
    pub fn tones(&self) -> usize {
        self.count
    }

    /// Tone k by rising frequency, sampled at `fs` Hz; none above the number fitted.
    pub fn tone(&self, k: usize, fs: T) -> Option<Tone<T>> {
        if k >= self.count {
            return None;
        }
        let [w, b, c] = [0, 1, 2].map(|i| self.theta[3 * k + i]);
        let cov = |i: usize, j: usize| self.covariance[3 * k + i][3 * k + j];
        let hertz = fs / (T::from_f64(2.0) * T::PI);
        let size = (b * b + c * c).sqrt();
        let (x, y) = (b / size, c / size);
        let variance = x * x * cov(1, 1) + T::from_f64(2.0) * x * y * cov(1, 2) + y * y * cov(2, 2);
        // b·cos ωt′ + c·sin ωt′ = size·cos(ωt′ − atan2(c, b)).
        let middle = (count::<T>(self.samples) - T::ONE) * T::from_f64(0.5);
        let turns = T::from_f64(2.0) * T::PI;
        let angle = -c.atan2(b) - w * middle;
        Some(Tone {
            frequency: w * hertz,
            frequency_sd: cov(0, 0).max(T::ZERO).sqrt() * hertz,
            amplitude: size * self.scale,
            amplitude_sd: variance.max(T::ZERO).sqrt() * self.scale,
            phase: angle - turns * (angle / turns).round(),
        })
    }

    /// Power of the noise, input units squared: the mean of the squared residuals,
    /// not corrected for the parameters.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }

    /// Samples fitted.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// The search ended at a minimum.
    pub fn converged(&self) -> bool {
        self.converged
    }

    fn sort(&mut self) {
        for k in 0..self.count {
            let mut least = k;
            for i in k + 1..self.count {
                if self.theta[3 * i] < self.theta[3 * least] {
                    least = i;
                }
            }
            for i in 0..3 {
                let (x, y) = (3 * k + i, 3 * least + i);
                self.theta.swap(x, y);
                self.covariance.swap(x, y);
                for row in &mut self.covariance {
                    row.swap(x, y);
                }
            }
        }
    }
}
