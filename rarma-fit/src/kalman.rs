//! The exact innovations of a stationary ARMA process.
//!
//! State space of Harvey's form, r = max(p, q + 1):
//!
//! ```text
//! x₁ = y,   xᵢ(t+1) = φᵢ·x₁(t) + xᵢ₊₁(t) + θᵢ₋₁·e(t+1),   φᵢ = −aᵢ, θ₀ = 1, θⱼ = cⱼ
//! ```
//!
//! The filter starts from the stationary covariance, so the change of the error
//! covariance from step to step has rank one, and the gain follows from a vector
//! recursion (Morf, Sidhu and Kailath; Pearlman for ARMA): O(r) a sample instead of
//! O(r²), and of the stationary covariance only one column is needed, which comes
//! from autocovariances in closed form.

use super::polynomial::{autocovariance, reflections};
use super::prediction::Orders;
use rarma_core::real::Real;

/// Room for autocovariances; r + q must not exceed it.
const LAGS: usize = 2 * super::LONGEST_AR;

/// Innovations filter of unit noise variance for r ≤ `R` states.
#[derive(Debug, Clone, Copy)]
pub(super) struct Innovation<T, const R: usize> {
    r: usize,
    phi: [T; R],
    gain: [T; R],
    increment: [T; R],
    strength: T,
    variance: T,
    settled: bool,
    /// State of the series, and of a constant 1 for the mean.
    state: [T; R],
    level: [T; R],
}

/// One step of the filter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Innovated<T> {
    /// Innovation of the series.
    pub y: T,
    /// Innovation of a constant 1: e(mean) = y − mean·level.
    pub level: T,
    /// Variance of the innovation over σ².
    pub variance: T,
}

impl<T: Real, const R: usize> Innovation<T, R> {
    /// Filter of the model θ = (a, c); none unless A is stable and r ≤ `R`.
    pub fn new(order: Orders, theta: &[T]) -> Option<Self> {
        let Orders { p, q } = order;
        let r = p.max(q + 1);
        if r > R || r + q > LAGS {
            return None;
        }
        let (a, c) = theta[..p + q].split_at(p);
        reflections::<T, R>(a)?;
        let theta_at = |j: usize| match j {
            0 => T::ONE,
            j if j <= q => c[j - 1],
            _ => T::ZERO,
        };
        let mut phi = [T::ZERO; R];
        for (f, a) in phi.iter_mut().zip(a) {
            *f = -*a;
        }
        // Autocovariance of 1/A, then of C/A, and the impulse response.
        let mut pure = [T::ZERO; LAGS];
        autocovariance::<T, R>(a, &mut pure[..r + q])?;
        let (mut gamma, mut psi) = ([T::ZERO; R], [T::ZERO; R]);
        for k in 0..r {
            for i in 0..=q {
                for j in 0..=q {
                    gamma[k] += theta_at(i) * theta_at(j) * pure[(k + i).abs_diff(j)];
                }
            }
            psi[k] = theta_at(k);
            for i in 0..p.min(k) {
                psi[k] -= a[i] * psi[k - 1 - i];
            }
        }
        // Covariance of the state with y = x₁.
        let mut column = [T::ZERO; R];
        column[0] = gamma[0];
        for i in 2..=r {
            let mut sum = T::ZERO;
            for j in i..=r {
                sum += phi[j - 1] * gamma[j - i + 1];
            }
            for j in i - 1..=q {
                sum += theta_at(j) * psi[j + 1 - i];
            }
            column[i - 1] = sum;
        }
        let variance = column[0];
        if !(variance.is_finite() && variance > T::ZERO) {
            return None;
        }
        let mut out = Self {
            r,
            phi,
            gain: [T::ZERO; R],
            increment: [T::ZERO; R],
            strength: -T::ONE / variance,
            variance,
            settled: false,
            state: [T::ZERO; R],
            level: [T::ZERO; R],
        };
        out.advance(&mut column);
        out.increment = column;
        for (g, x) in out.gain.iter_mut().zip(&column) {
            *g = *x / variance;
        }
        Some(out)
    }

    /// x ← transition·x.
    #[inline(always)]
    fn advance(&self, x: &mut [T; R]) {
        let first = x[0];
        for i in 0..self.r {
            let next = if i + 1 < self.r { x[i + 1] } else { T::ZERO };
            x[i] = self.phi[i] * first + next;
        }
    }

    /// Takes one sample.
    #[inline(always)]
    pub fn step(&mut self, y: T) -> Innovated<T> {
        let out = Innovated {
            y: y - self.state[0],
            level: T::ONE - self.level[0],
            variance: self.variance,
        };
        let (mut state, mut level) = (self.state, self.level);
        self.advance(&mut state);
        self.advance(&mut level);
        for i in 0..self.r {
            state[i] += self.gain[i] * out.y;
            level[i] += self.gain[i] * out.level;
        }
        (self.state, self.level) = (state, level);
        if !self.settled {
            self.tighten();
        }
        out
    }

    /// Variance and gain of the next sample:
    /// F⁺ = F + w₁²M, K⁺ = (K·F + Tw·M·w₁)/F⁺, w⁺ = Tw − K⁺·w₁, M⁺ = M + M²w₁²/F.
    fn tighten(&mut self) {
        let first = self.increment[0];
        let change = first * first * self.strength;
        let before = self.variance;
        // F falls towards 1 from above; rounding must not carry it past.
        let after = (before + change).max(T::ONE);
        if !(change.abs() > T::EPSILON * T::from_f64(0.01) * before) {
            // A node of the increment can pass through 0: settled only if the
            // whole vector has become small.
            let mut largest = T::ZERO;
            for x in &self.increment[..self.r] {
                largest = largest.max(*x * *x);
            }
            self.settled = largest * self.strength.abs() < T::EPSILON * T::from_f64(0.01);
        }
        let mut moved = self.increment;
        self.advance(&mut moved);
        let pull = self.strength * first;
        for i in 0..self.r {
            self.gain[i] = (self.gain[i] * before + moved[i] * pull) / after;
            self.increment[i] = moved[i] - self.gain[i] * first;
        }
        self.strength += self.strength * change / before;
        self.variance = after;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plain Kalman filter on dense matrices, covariance by iteration.
    fn dense(a: &[f64], c: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
        let r = a.len().max(c.len() + 1);
        let phi = |i: usize| a.get(i).map_or(0.0, |x| -x);
        let theta = |i: usize| match i {
            0 => 1.0,
            i => c.get(i - 1).copied().unwrap_or(0.0),
        };
        let transit = |p: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let apply = |m: &[Vec<f64>]| -> Vec<Vec<f64>> {
                (0..r)
                    .map(|i| {
                        (0..r)
                            .map(|j| phi(i) * m[0][j] + if i + 1 < r { m[i + 1][j] } else { 0.0 })
                            .collect()
                    })
                    .collect()
            };
            let flip = |m: &[Vec<f64>]| -> Vec<Vec<f64>> {
                (0..r).map(|i| (0..r).map(|j| m[j][i]).collect()).collect()
            };
            let mut out = flip(&apply(&flip(&apply(p))));
            for i in 0..r {
                for j in 0..r {
                    out[i][j] += theta(i) * theta(j);
                }
            }
            out
        };
        let mut p = vec![vec![0.0; r]; r];
        for _ in 0..20_000 {
            p = transit(&p);
        }
        let mut x = vec![0.0; r];
        y.iter()
            .map(|y| {
                let (v, f) = (y - x[0], p[0][0]);
                let k: Vec<f64> = (0..r).map(|i| p[i][0] / f).collect();
                let updated: Vec<f64> = (0..r).map(|i| x[i] + k[i] * v).collect();
                x = (0..r)
                    .map(|i| phi(i) * updated[0] + if i + 1 < r { updated[i + 1] } else { 0.0 })
                    .collect();
                let row = p[0].clone();
                for i in 0..r {
                    for j in 0..r {
                        p[i][j] -= k[i] * row[j];
                    }
                }
                p = transit(&p);
                (v, f)
            })
            .collect()
    }

    #[test]
    fn is_the_plain_filter_in_fewer_operations() {
        let y: [f64; 80] = core::array::from_fn(|t| libm::sin(2.1 * (t * t % 41) as f64));
        let cases: [(&[f64], &[f64]); 5] = [
            (&[-1.6, 0.97], &[0.6]),
            (&[-1.1, 0.95, -0.805, 0.76], &[0.5, -0.3, 0.2, 0.1]),
            (&[], &[0.9, 0.4, 0.2]),
            (&[0.9], &[]),
            (&[-0.5], &[0.3, 0.9]),
        ];
        for (a, c) in cases {
            let order = Orders {
                p: a.len(),
                q: c.len(),
            };
            let theta: Vec<f64> = a.iter().chain(c).copied().collect();
            let mut filter = Innovation::<f64, 6>::new(order, &theta).expect("stable");
            for (t, (v, f)) in dense(a, c, &y).into_iter().enumerate() {
                let step = filter.step(y[t]);
                assert!((step.y - v).abs() < 1e-9, "{order:?} t {t}: {} {v}", step.y);
                assert!((step.variance - f).abs() < 1e-9 * f, "{order:?} t {t}");
            }
        }
        let order = Orders { p: 2, q: 0 };
        assert!(Innovation::<f64, 6>::new(order, &[-2.1, 1.1]).is_none());
        assert!(Innovation::<f64, 1>::new(order, &[-0.1, 0.1]).is_none());
    }
}
