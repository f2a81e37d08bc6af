//! A fitted response to an input: coefficients, modes, frequency response.

use super::delta::{PoleDeviation, pole_deviation};
use rarma_core::real::Real;

/// Orders of A(q)·y(t) = B(q)·u(t − delay) + e(t).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArxOrder {
    /// Degree of A, 0 upward.
    pub p: usize,
    /// Number of coefficients of B, 1 upward: B = b₀ + b₁ q⁻¹ + …
    pub b: usize,
    /// Samples before the input shows, 0 upward; 1 for an input held between samples.
    pub delay: usize,
}

impl ArxOrder {
    pub(super) fn parameters(self) -> usize {
        self.p + self.b
    }

    /// First sample with a whole past.
    pub(super) fn start(self) -> usize {
        let last = self.delay.saturating_add(self.b.saturating_sub(1));
        self.p.max(last)
    }
}

/// Frequency response at one frequency, output units over input units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response<T> {
    /// Real part; the convention is e^{+jωt}, so a delay turns it clockwise.
    pub re: T,
    /// Imaginary part.
    pub im: T,
    /// Standard deviation of the real part.
    pub re_sd: T,
    /// Standard deviation of the imaginary part.
    pub im_sd: T,
    /// Standard deviation of the magnitude.
    pub magnitude_sd: T,
    /// Standard deviation of the phase, rad.
    pub phase_sd: T,
}

/// A fitted ARX model; p + b ≤ `N`.
#[derive(Debug, Clone, Copy)]
pub struct ArxFit<T, const N: usize> {
    pub(super) theta: [T; N],
    pub(super) order: ArxOrder,
    pub(super) sigma2: T,
    pub(super) samples: usize,
    pub(super) covariance: [[T; N]; N],
    pub(super) rounds: u32,
    pub(super) converged: bool,
}

impl<T: Real, const N: usize> ArxFit<T, N> {
    /// Coefficients a₁…a_p, without the leading 1.
    pub fn a(&self) -> &[T] {
        &self.theta[..self.order.p]
    }

    /// Coefficients b₀, b₁, …, output units over input units.
    pub fn b(&self) -> &[T] {
        &self.theta[self.order.p..self.order.parameters()]
    }

    /// The orders it was fitted with.
    pub fn order(&self) -> ArxOrder {
        self.order
    }

    /// Power of the disturbance, output units squared, corrected for the parameters:
    /// of e by least squares, of the noise on the output by instruments.
    pub fn sigma2(&self) -> T {
        self.sigma2
    }

    /// Equations.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Covariance of parameters i and j of θ = (a, b); NaN outside p + b.
    pub fn covariance(&self, i: usize, j: usize) -> T {
        let k = self.order.parameters();
        if i < k && j < k {
            self.covariance[i][j]
        } else {
            T::from_f64(f64::NAN)
        }
    }

    /// Standard deviation of parameter i of θ = (a, b).
    pub fn deviation(&self, i: usize) -> T {
        self.covariance(i, i).max(T::ZERO).sqrt()
    }

    /// Standard deviations of frequency and damping ratio of a root
    /// z = re + j·im of A, sampled at `fs` Hz; none for a real root.
    pub fn pole(&self, re: T, im: T, fs: T) -> Option<PoleDeviation<T>> {
        pole_deviation(self.a(), &self.covariance, re, im, fs)
    }

    /// Rounds of the instruments; 0 for least squares.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// The rounds came to rest.
    pub fn converged(&self) -> bool {
        self.converged
    }

    /// G = e^{−jωd}·B(e^{jω})/A(e^{jω}) at `f` Hz, with its uncertainty:
    ///
    /// ```text
    /// ∂G/∂aᵢ = −G·e^{−jωi}/A,   ∂G/∂b_j = e^{−jω(d+j)}/A
    /// ```
    ///
    /// None if A has a root there.
    pub fn response(&self, f: T, fs: T) -> Option<Response<T>> {
        let w = T::from_f64(2.0) * T::PI * f / fs;
        let turn = |k: usize| {
            let (sin, cos) = (w * T::from_u32(u32::try_from(k).unwrap_or(u32::MAX))).sin_cos();
            (cos, -sin)
        };
        let times = |x: (T, T), y: (T, T)| (x.0 * y.0 - x.1 * y.1, x.0 * y.1 + x.1 * y.0);
        let ArxOrder { p, delay, .. } = self.order;
        let (mut above, mut below) = ((T::ZERO, T::ZERO), (T::ONE, T::ZERO));
        for (i, a) in self.a().iter().enumerate() {
            let (re, im) = turn(i + 1);
            below = (below.0 + *a * re, below.1 + *a * im);
        }
        for (j, b) in self.b().iter().enumerate() {
            let (re, im) = turn(delay.saturating_add(j));
            above = (above.0 + *b * re, above.1 + *b * im);
        }
        let norm = below.0 * below.0 + below.1 * below.1;
        if !(norm > T::ZERO) {
            return None;
        }
        let inverse = (below.0 / norm, -below.1 / norm);
        let g = times(above, inverse);
        let size = (g.0 * g.0 + g.1 * g.1).sqrt();
        let mut slopes = [(T::ZERO, T::ZERO); N];
        for (i, slope) in slopes[..self.order.parameters()].iter_mut().enumerate() {
            *slope = if i < p {
                let d = times(times(g, turn(i + 1)), inverse);
                (-d.0, -d.1)
            } else {
                times(turn(delay.saturating_add(i - p)), inverse)
            };
        }
        // Deviation along the direction (x, y).
        let along = |x: T, y: T| {
            let mut sum = T::ZERO;
            for (i, one) in slopes.iter().enumerate() {
                for (j, other) in slopes.iter().enumerate() {
                    let weight = (one.0 * x + one.1 * y) * (other.0 * x + other.1 * y);
                    sum += weight * self.covariance[i][j];
                }
            }
            sum.max(T::ZERO).sqrt()
        };
        let out = Response {
            re: g.0,
            im: g.1,
            re_sd: along(T::ONE, T::ZERO),
            im_sd: along(T::ZERO, T::ONE),
            magnitude_sd: along(g.0 / size, g.1 / size),
            phase_sd: along(-g.1 / size, g.0 / size) / size,
        };
        (out.re_sd.is_finite() && g.0.is_finite() && g.1.is_finite()).then_some(out)
    }
}
