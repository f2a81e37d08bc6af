//! Signals whose properties are known.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_plants::modal_noise::{ModalNoise, ModalNoiseConfig, NoiseMode};
use std::f64::consts::TAU;

/// White Gaussian noise of variance 1.
pub fn white(seed: u64) -> impl Iterator<Item = f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || StandardNormal.sample(&mut rng))
}

/// A tone of amplitude 1.
pub fn tone(f_hz: f64, fs_hz: f64) -> impl Iterator<Item = f64> {
    (0u64..).map(move |n| (TAU * f_hz * n as f64 / fs_hz).sin())
}

/// Modes (frequency in Hz, damping ratio; each of variance 1) that white forces
/// excite: exactly ARMA(2n, 2n−1).
///
/// # Panics
/// A mode is out of range.
#[must_use]
pub fn modes(modes: &[(f64, f64)], fs_hz: f64, seed: u64) -> ModalNoise {
    modes_of(1.0, modes, fs_hz, seed)
}

/// As [`modes`], each of root mean square `rms`.
///
/// # Panics
/// A mode is out of range.
#[must_use]
pub fn modes_of(rms: f64, modes: &[(f64, f64)], fs_hz: f64, seed: u64) -> ModalNoise {
    let modes = modes
        .iter()
        .map(|&(f_hz, zeta)| NoiseMode { f_hz, zeta, rms })
        .collect();
    ModalNoise::new(ModalNoiseConfig {
        fs_hz,
        modes,
        drive: Default::default(),
        quantity: Default::default(),
        snr_db: None,
        seed,
    })
    .expect("modes in range")
}

/// Coefficients a₁…a_p of the polynomial with these modes, sampled at `fs_hz`.
#[must_use]
pub fn polynomial(modes: &[(f64, f64)], fs_hz: f64) -> Vec<f64> {
    let factors = modes.iter().map(|&(f, zeta)| {
        let w = TAU * f / fs_hz;
        let radius = (-zeta * w).exp();
        let angle = w * (1.0 - zeta * zeta).sqrt();
        [1.0, -2.0 * radius * angle.cos(), radius * radius]
    });
    product(factors).split_off(1)
}

/// Coefficients of the product of polynomials of second degree, the leading one first.
#[must_use]
pub fn product(factors: impl IntoIterator<Item = [f64; 3]>) -> Vec<f64> {
    let mut a = vec![1.0];
    for factor in factors {
        let mut next = vec![0.0; a.len() + 2];
        for (i, x) in a.iter().enumerate() {
            for (j, y) in factor.iter().enumerate() {
                next[i + j] += x * y;
            }
        }
        a = next;
    }
    a
}

/// An ARMA process with coefficients a and c (without the leading 1) and white
/// noise of variance 1, after its start-up transient.
#[must_use]
pub fn arma(a: &[f64], c: &[f64], samples: usize, seed: u64) -> Vec<f64> {
    const TRANSIENT: usize = 5000;
    let e: Vec<f64> = white(seed).take(samples + TRANSIENT).collect();
    let mut y = vec![0.0; e.len()];
    for t in 0..e.len() {
        let past = |x: &[f64], i: usize| if t > i { x[t - 1 - i] } else { 0.0 };
        let ma: f64 = c.iter().enumerate().map(|(i, c)| c * past(&e, i)).sum();
        let ar: f64 = a.iter().enumerate().map(|(i, a)| a * past(&y, i)).sum();
        y[t] = e[t] + ma - ar;
    }
    y.split_off(TRANSIENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomial_has_the_asked_for_poles() {
        let (f, zeta, fs) = (980.0, 0.02, 5000.0);
        let a = polynomial(&[(f, zeta)], fs);
        let pole = modes(&[(f, zeta)], fs, 1).true_poles()[0];
        assert!((a[0] + 2.0 * pole.re).abs() < 1e-12);
        assert!((a[1] - pole.re.hypot(pole.im).powi(2)).abs() < 1e-12);
    }

    #[test]
    fn arma_has_its_theoretical_variance() {
        // AR(1) with a = −0.8: variance 1/(1 − 0.64).
        let y = arma(&[-0.8], &[], 200_000, 3);
        let variance = y.iter().map(|x| x * x).sum::<f64>() / y.len() as f64;
        assert!((variance * 0.36 - 1.0).abs() < 0.03, "{variance}");
    }
}
