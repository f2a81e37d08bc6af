//! Deviations from what each stretch changes, to first order.

use super::subspace::{Subspace, Turn};
use nalgebra::{Complex, DMatrix};

impl Subspace {
    /// What a stretch adds to the observability matrix of n states, as far as it leaves its
    /// space: turns within it change neither eigenvalues nor shapes.
    ///
    /// ```text
    /// u_kᵀ·Δu_j = (σ_j·u_kᵀΔH v_j + σ_k·v_kᵀΔHᵀu_j)/(σ_j² − σ_k²),   k > n ≥ j
    /// ```
    pub(super) fn observability_turn(&self, turn: &Turn, n: usize) -> DMatrix<f64> {
        let rest = self.sigma.len() - n;
        let x = DMatrix::from_fn(rest, n, |k, j| {
            let (high, low) = (self.sigma[j], self.sigma[n + k]);
            (high * turn.left[(n + k, j)] + low * turn.right[(n + k, j)])
                / (high * high - low * low)
        });
        let mut out = self.u.columns(n, rest) * x;
        for (j, mut column) in out.column_iter_mut().enumerate() {
            column.axpy(1.0 / self.sigma[j], &turn.outside.column(j), 1.0);
        }
        out
    }
}

/// Standard deviation of a sum of one difference a stretch, which has those of neighbouring
/// stretches in common (Bartlett's weights):
///
/// ```text
/// variance = γ(0) + 2·Σ (1 − l/(L + 1))·γ(l),  γ(l) = Σ_b d(b)·d(b + l),  l = 1 … L
/// ```
pub(super) fn deviation(d: &[f64], neighbours: usize) -> f64 {
    let product = |lag: usize| -> f64 { d.iter().zip(&d[lag..]).map(|(x, y)| x * y).sum() };
    let mut variance = product(0);
    for lag in 1..=neighbours.min(d.len().saturating_sub(1)) {
        variance += 2.0 * (1.0 - lag as f64 / (neighbours + 1) as f64) * product(lag);
    }
    libm::sqrt(variance.max(0.0))
}

/// Frequency, rad a sample, and damping ratio of a pole, and what a small change of the pole
/// makes of them.
pub(super) struct Pole {
    /// |ln λ|.
    pub omega: f64,
    /// −Re ln λ/|ln λ|.
    pub damping: f64,
    log: Complex<f64>,
    lambda: Complex<f64>,
}

impl Pole {
    /// Of an eigenvalue that is not 0.
    pub fn of(lambda: Complex<f64>) -> Self {
        let log = Complex::new(
            libm::log(libm::hypot(lambda.re, lambda.im)),
            libm::atan2(lambda.im, lambda.re),
        );
        let omega = libm::hypot(log.re, log.im);
        Self {
            omega,
            damping: -log.re / omega,
            log,
            lambda,
        }
    }

    /// Changes of (ω, ζ) with λ.
    pub fn change(&self, by: Complex<f64>) -> (f64, f64) {
        let d = by / self.lambda;
        let omega = (self.log.re * d.re + self.log.im * d.im) / self.omega;
        let cube = self.omega * self.omega * self.omega;
        let damping = self.log.im * (self.log.re * d.im - self.log.im * d.re) / cube;
        (omega, damping)
    }
}
