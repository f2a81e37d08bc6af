//! The Cramér–Rao bound of an ARMA model: no unbiased estimator scatters less.
//!
//! Asymptotic and exact: with e the white noise of A·y = C·e, the gradient of the
//! prediction error is e(t−i)/A for aᵢ and −e(t−i)/C for cᵢ, J = E(ψψᵀ)/σ² is its
//! covariance, and cov(a, c) = J⁻¹/n after n samples. Modes follow by the delta
//! method. Plain f64, its own root and matrix arithmetic: nothing of the product
//! is used here.

use crate::signal;
use rarma_plants::modal_noise::ModalNoise;
use std::f64::consts::{PI, TAU};

/// Points on the upper half circle over which J is integrated.
const GRID: usize = 1 << 14;
/// Rows of the factorisation that finds C.
const ROWS: usize = 20_000;

type Complex = (f64, f64);

fn times(x: Complex, y: Complex) -> Complex {
    (x.0 * y.0 - x.1 * y.1, x.0 * y.1 + x.1 * y.0)
}

fn over(x: Complex, y: Complex) -> Complex {
    let d = y.0 * y.0 + y.1 * y.1;
    ((x.0 * y.0 + x.1 * y.1) / d, (x.1 * y.0 - x.0 * y.1) / d)
}

/// What is known of a model before any sample is taken.
#[derive(Debug, Clone)]
pub struct Bound {
    a: Vec<f64>,
    inverse: Vec<Vec<f64>>,
}

/// Least standard deviations of a mode after one sample; divide by √n.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeBound {
    /// Of the natural frequency, Hz.
    pub frequency: f64,
    /// Of the damping ratio.
    pub damping: f64,
}

impl Bound {
    /// Of the model with coefficients a and c, without the leading 1.
    ///
    /// # Panics
    /// A and C share a root: the model has no bound.
    #[must_use]
    pub fn of(a: &[f64], c: &[f64]) -> Self {
        let n = a.len() + c.len();
        let mut j = vec![vec![0.0; n]; n];
        for k in 0..GRID {
            let w = PI * (k as f64 + 0.5) / GRID as f64;
            let ahead = |i: usize| {
                let (s, c) = (w * i as f64).sin_cos();
                (c, -s)
            };
            let value = |x: &[f64]| {
                x.iter()
                    .enumerate()
                    .fold((1.0, 0.0), |sum: Complex, (i, x)| {
                        let e = ahead(i + 1);
                        (sum.0 + x * e.0, sum.1 + x * e.1)
                    })
            };
            let (va, vc) = (value(a), value(c));
            let g: Vec<Complex> = (0..n)
                .map(|i| {
                    if i < a.len() {
                        over(ahead(i + 1), va)
                    } else {
                        let (re, im) = over(ahead(i - a.len() + 1), vc);
                        (-re, -im)
                    }
                })
                .collect();
            for (row, x) in j.iter_mut().zip(&g) {
                for (place, y) in row.iter_mut().zip(&g) {
                    *place += (x.0 * y.0 + x.1 * y.1) / GRID as f64;
                }
            }
        }
        Self {
            a: a.to_vec(),
            inverse: inverse(j),
        }
    }

    /// Of sampled modal noise.
    #[must_use]
    pub fn of_modes(noise: &ModalNoise) -> Self {
        let (a, c) = model_of(noise);
        Self::of(&a, &c)
    }

    /// Least standard deviation of parameter `i` of (a, c) after `n` samples.
    #[must_use]
    pub fn parameter(&self, i: usize, n: f64) -> f64 {
        (self.inverse[i][i] / n).sqrt()
    }

    /// Of the mode with this frequency (Hz) and damping ratio, which must be one of
    /// A's, sampled at `fs_hz`.
    #[must_use]
    pub fn mode(&self, f_hz: f64, zeta: f64, fs_hz: f64) -> ModeBound {
        let w = TAU * f_hz / fs_hz;
        let (l, theta) = (-zeta * w, w * (1.0 - zeta * zeta).sqrt());
        let z = (l.exp() * theta.cos(), l.exp() * theta.sin());
        let (mut value, mut slope) = ((1.0, 0.0), (0.0, 0.0));
        for &x in &self.a {
            slope = times(slope, z);
            slope = (slope.0 + value.0, slope.1 + value.1);
            value = times(value, z);
            value.0 += x;
        }
        let r = l.hypot(theta);
        // d ln z/da_i = −z^(p−i−1)/A′(z), from the last i backwards.
        let mut d = over((-1.0, 0.0), times(z, slope));
        let mut by = vec![(0.0, 0.0); self.inverse.len()];
        for i in (0..self.a.len()).rev() {
            by[i] = (
                fs_hz / TAU * (l * d.0 + theta * d.1) / r,
                theta * (l * d.1 - theta * d.0) / r.powi(3),
            );
            d = times(d, z);
        }
        let form = |pick: fn(&(f64, f64)) -> f64| {
            let mut sum = 0.0;
            for (row, x) in self.inverse.iter().zip(&by) {
                for (place, y) in row.iter().zip(&by) {
                    sum += pick(x) * place * pick(y);
                }
            }
            sum.sqrt()
        };
        ModeBound {
            frequency: form(|x| x.0),
            damping: form(|x| x.1),
        }
    }
}

/// Coefficients a and c, without the leading 1, of sampled modal noise: A from its
/// poles, C from its autocovariance.
#[must_use]
pub fn model_of(noise: &ModalNoise) -> (Vec<f64>, Vec<f64>) {
    let poles = noise.true_poles().into_iter();
    let mut a = signal::product(poles.map(|p| [1.0, -2.0 * p.re, p.re * p.re + p.im * p.im]));
    let (p, q) = noise.arma_order();
    let r = noise.autocovariance(p + q);
    let moving: Vec<f64> = (0..=q)
        .map(|k| {
            let mut sum = 0.0;
            for (i, x) in a.iter().enumerate() {
                for (j, y) in a.iter().enumerate() {
                    sum += x * y * r[(k + i).abs_diff(j)];
                }
            }
            sum
        })
        .collect();
    (a.split_off(1), spectral_factor(&moving))
}

/// The stable C whose moving average has these autocovariances: the rows of the
/// Cholesky factor of the banded Toeplitz matrix converge to it (Bauer).
fn spectral_factor(r: &[f64]) -> Vec<f64> {
    let q = r.len() - 1;
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(ROWS);
    // Row t holds L(t, t−k) at place k.
    for t in 0..ROWS {
        let mut row = vec![0.0; q + 1];
        for k in (0..=q.min(t)).rev() {
            let mut sum = r[k];
            for m in k + 1..=q.min(t) {
                let other: f64 = if k == 0 { row[m] } else { rows[t - k][m - k] };
                sum -= row[m] * other;
            }
            row[k] = if k == 0 {
                sum.sqrt()
            } else {
                sum / rows[t - k][0]
            };
        }
        rows.push(row);
    }
    let last = &rows[ROWS - 1];
    last[1..].iter().map(|x| x / last[0]).collect()
}

/// Inverse of a symmetric positive definite matrix (Gauss–Jordan, pivoted).
fn inverse(mut m: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = m.len();
    let mut out: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for k in 0..n {
        let best = (k..n)
            .max_by(|&i, &j| m[i][k].abs().total_cmp(&m[j][k].abs()))
            .unwrap_or(k);
        m.swap(k, best);
        out.swap(k, best);
        let pivot = m[k][k];
        assert!(pivot.abs() > 1e-14, "A and C share a root");
        for x in m[k].iter_mut().chain(&mut out[k]) {
            *x /= pivot;
        }
        let (row, row_out) = (m[k].clone(), out[k].clone());
        for i in (0..n).filter(|&i| i != k) {
            let f = m[i][k];
            for (x, y) in m[i].iter_mut().zip(&row) {
                *x -= f * y;
            }
            for (x, y) in out[i].iter_mut().zip(&row_out) {
                *x -= f * y;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::modes;

    #[test]
    fn of_an_autoregression_of_order_one() {
        // cov(a) = (1 − a²)/n.
        let bound = Bound::of(&[-0.9], &[]);
        assert!((bound.parameter(0, 100.0) - (0.19f64 / 100.0).sqrt()).abs() < 1e-6);
        // ARMA(1,1): var(a) = (1 − a²)(1 − ac)²/(a − c)²/n (Box and Jenkins).
        let (a, c) = (-0.8, 0.5);
        let want = (1.0 - a * a) * (1.0 - a * c) * (1.0 - a * c) / ((a - c) * (a - c));
        assert!((Bound::of(&[a], &[c]).parameter(0, 1.0).powi(2) - want).abs() < 1e-6);
    }

    #[test]
    fn moving_average_is_found_from_its_autocovariance() {
        let c = [1.0, -0.4, 0.3, 0.2];
        let r: Vec<f64> = (0..4)
            .map(|k| (0..4 - k).map(|i| c[i] * c[i + k]).sum())
            .collect();
        for (found, wanted) in spectral_factor(&r).iter().zip(&c[1..]) {
            assert!((found - wanted).abs() < 1e-9, "{found} for {wanted}");
        }
    }

    #[test]
    fn of_one_mode_is_the_rule_of_thumb() {
        // sd(ζ) = √(ζ/2πfT), a little more because C is estimated as well.
        let noise = modes(&[(980.0, 0.02)], 5000.0, 1);
        let bound = Bound::of_modes(&noise).mode(980.0, 0.02, 5000.0);
        let thumb = (0.02 / (TAU * 980.0)).sqrt();
        let ratio = bound.damping / 5000f64.sqrt() / thumb;
        assert!((1.0..1.06).contains(&ratio), "{ratio}");
    }
}
