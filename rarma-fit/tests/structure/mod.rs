//! Structures that several sensors listen to, what they say, and what can be known from it at
//! best: the bound from spectral matrices alone. No formula here is the estimator's. For the tests
//! here and those of host-tests.

#![allow(dead_code, reason = "each test file takes what it needs")]

pub mod bound;
pub mod noise;

use nalgebra::{Complex, DMatrix};
use noise::Noise;
use std::f64::consts::TAU;

pub type C = Complex<f64>;

/// Rate of all of them, Hz.
pub const FS: f64 = 5000.0;

/// What shakes the modes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Force {
    /// One white force, the same for all modes.
    One,
    /// A white force for each mode.
    Each,
}

/// Modes seen through real shapes by noisy sensors.
#[derive(Clone)]
pub struct Structure {
    /// Frequency in Hz, damping ratio.
    pub modes: Vec<(f64, f64)>,
    /// Of mode m in channel k: `shapes[m][k]`; a mode has unit power where its shape is 1.
    pub shapes: Vec<Vec<f64>>,
    pub force: Force,
    /// Variance of the white noise of every sensor.
    pub noise: f64,
}

/// Pole of a mode, upper half.
pub fn pole(f: f64, zeta: f64) -> C {
    let w = TAU * f / FS;
    C::from_polar((-zeta * w).exp(), w * (1.0 - zeta * zeta).sqrt())
}

/// 1 − 2 Re z·q⁻¹ + |z|²·q⁻², without the leading 1.
fn pair(f: f64, zeta: f64) -> [f64; 2] {
    let z = pole(f, zeta);
    [-2.0 * z.re, z.norm_sqr()]
}

/// Factor that gives white noise through one pair unit power.
fn unit(f: f64, zeta: f64) -> f64 {
    // Power of an autoregression of order 2 from its two coefficients.
    let [a1, a2] = pair(f, zeta);
    let power = (1.0 + a2) / ((1.0 - a2) * ((1.0 + a2).powi(2) - a1 * a1));
    power.sqrt().recip()
}

impl Structure {
    pub fn channels(&self) -> usize {
        self.shapes[0].len()
    }

    /// Mean power of a channel without its noise, as near as modes are apart.
    pub fn power(&self) -> f64 {
        let all: f64 = self.shapes.iter().flatten().map(|x| x * x).sum();
        all / self.channels() as f64
    }

    /// With the noise that makes this ratio, dB.
    pub fn with_snr(mut self, db: f64) -> Self {
        self.noise = self.power() * 10f64.powf(-db / 10.0);
        self
    }

    /// Only these channels.
    pub fn of(&self, channels: &[usize]) -> Self {
        let mut one = self.clone();
        for shape in &mut one.shapes {
            *shape = channels.iter().map(|k| shape[*k]).collect();
        }
        one
    }

    /// Spectral matrix at ω, of variance 2π times its mean over the circle.
    pub fn spectrum(&self, omega: f64) -> DMatrix<C> {
        let k = self.channels();
        let w = C::from_polar(1.0, -omega);
        let mut s = DMatrix::from_diagonal_element(k, k, C::new(self.noise, 0.0));
        let mut sum = vec![C::new(0.0, 0.0); k];
        for (&(f, zeta), shape) in self.modes.iter().zip(&self.shapes) {
            let [a1, a2] = pair(f, zeta);
            let h = unit(f, zeta) / (C::new(1.0, 0.0) + w * a1 + w * w * a2);
            match self.force {
                Force::One => sum.iter_mut().zip(shape).for_each(|(s, x)| *s += h * *x),
                Force::Each => {
                    for i in 0..k {
                        for j in 0..k {
                            s[(i, j)] += shape[i] * shape[j] * h.norm_sqr();
                        }
                    }
                }
            }
        }
        for i in 0..k {
            for j in 0..k {
                s[(i, j)] += sum[i] * sum[j].conj();
            }
        }
        s
    }

    /// Samples, one vector a sample, after the transient has died away.
    pub fn record(&self, n: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Noise::new(seed);
        let before = 4000;
        let mut states = vec![[0.0; 2]; self.modes.len()];
        let deviation = self.noise.sqrt();
        let mut out = Vec::with_capacity(n);
        for t in 0..n + before {
            let one = random.normal();
            let mut y = vec![0.0; self.channels()];
            for ((&(f, zeta), shape), state) in self.modes.iter().zip(&self.shapes).zip(&mut states)
            {
                let [a1, a2] = pair(f, zeta);
                let e = match self.force {
                    Force::One => one,
                    Force::Each => random.normal(),
                };
                let x = unit(f, zeta) * e - a1 * state[0] - a2 * state[1];
                *state = [x, state[0]];
                y.iter_mut().zip(shape).for_each(|(y, s)| *y += s * x);
            }
            if t >= before {
                y.iter_mut().for_each(|y| *y += deviation * random.normal());
                out.push(y);
            }
        }
        out
    }

    /// The model of shared poles that is nearest: each channel's own spectrum exactly, and of the
    /// innovations the covariance at lag 0.
    pub fn shared(&self) -> Shared {
        const GRID: usize = 8192;
        let (k, p) = (self.channels(), 2 * self.modes.len());
        let mut a = vec![1.0];
        for &(f, zeta) in &self.modes {
            let [a1, a2] = pair(f, zeta);
            a = product(&a, &[1.0, a1, a2]);
        }
        let spectra: Vec<DMatrix<C>> = (0..GRID)
            .map(|g| self.spectrum(TAU * g as f64 / GRID as f64))
            .collect();
        let mut c = Vec::new();
        for i in 0..k {
            // Cepstrum of the channel's spectrum, folded to its causal half.
            let cepstrum = |m: usize| -> f64 {
                let term = |g: usize| {
                    spectra[g][(i, i)].re.ln() * (TAU * (g * m % GRID) as f64 / GRID as f64).cos()
                };
                (0..GRID).map(term).sum::<f64>() / GRID as f64
            };
            let caused: Vec<f64> = (0..=p).map(cepstrum).collect();
            let mut h = vec![1.0];
            for m in 1..=p {
                let sum: f64 = (1..=m).map(|j| j as f64 * caused[j] * h[m - j]).sum();
                h.push(sum / m as f64);
            }
            c.push(product(&a, &h)[..=p].to_vec());
        }
        let at = |x: &[f64], g: usize| -> C {
            let w = |i: usize| C::from_polar(1.0, -TAU * (g * i % GRID) as f64 / GRID as f64);
            x.iter().enumerate().map(|(i, x)| w(i) * *x).sum()
        };
        let mut lambda = DMatrix::zeros(k, k);
        for (g, s) in spectra.iter().enumerate() {
            let whiten: Vec<C> = c.iter().map(|c| at(&a, g) / at(c, g)).collect();
            for i in 0..k {
                for j in 0..k {
                    let x = whiten[i] * s[(i, j)] * whiten[j].conj();
                    lambda[(i, j)] += x.re / GRID as f64;
                }
            }
        }
        Shared {
            modes: self.modes.clone(),
            c: c.iter().map(|c| c[1..].to_vec()).collect(),
            lambda,
        }
    }
}

pub fn product(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; x.len() + y.len() - 1];
    for (i, x) in x.iter().enumerate() {
        for (j, y) in y.iter().enumerate() {
            out[i + j] += x * y;
        }
    }
    out
}

/// A model of shared poles, A·y_k = C_k·e_k.
#[derive(Clone)]
pub struct Shared {
    pub modes: Vec<(f64, f64)>,
    pub c: Vec<Vec<f64>>,
    pub lambda: DMatrix<f64>,
}

impl Shared {
    /// Spectral matrix at ω.
    pub fn spectrum(&self, omega: f64) -> DMatrix<C> {
        let w = C::from_polar(1.0, -omega);
        let one = C::new(1.0, 0.0);
        let a = self.modes.iter().fold(one, |product, &(f, zeta)| {
            let [a1, a2] = pair(f, zeta);
            product * (one + w * a1 + w * w * a2)
        });
        let h: Vec<C> = self
            .c
            .iter()
            .map(|c| (c.iter().rev().fold(C::new(0.0, 0.0), |s, x| (s + *x) * w) + one) / a)
            .collect();
        DMatrix::from_fn(h.len(), h.len(), |i, j| {
            h[i] * h[j].conj() * self.lambda[(i, j)]
        })
    }

    /// Samples, one vector a sample, after the transient has died away.
    pub fn record(&self, n: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Noise::new(seed);
        let l = self.lambda.clone().cholesky().expect("definite").l();
        let a = self.modes.iter().fold(vec![1.0], |a, &(f, zeta)| {
            let [a1, a2] = pair(f, zeta);
            product(&a, &[1.0, a1, a2])
        });
        let k = self.c.len();
        let before = 4000;
        let mut y: Vec<Vec<f64>> = Vec::with_capacity(n + before);
        let mut e: Vec<Vec<f64>> = Vec::with_capacity(n + before);
        for t in 0..n + before {
            let white: Vec<f64> = (0..k).map(|_| random.normal()).collect();
            e.push(
                (0..k)
                    .map(|i| (0..=i).map(|j| l[(i, j)] * white[j]).sum())
                    .collect(),
            );
            let now = (0..k).map(|i| {
                let mut x = e[t][i];
                for (m, c) in self.c[i].iter().enumerate().take(t) {
                    x += c * e[t - 1 - m][i];
                }
                for (m, a) in a[1..].iter().enumerate().take(t) {
                    x -= a * y[t - 1 - m][i];
                }
                x
            });
            let now = now.collect();
            y.push(now);
        }
        y.split_off(before)
    }
}
