//! Vibration of known modes under white force noise: the bench on which an
//! estimator of damping is measured.
//!
//! Responsibility: samples whose poles are known exactly. Rate: one call per
//! sample, no allocation; building and retuning are slow paths.
//!
//! Sampling n modes driven by continuous white noise gives, without any
//! approximation, an ARMA(2n, 2n-1) process (ARMA(2n, 2n) once white
//! measurement noise is added): the state advances by Φ = e^(A·dt) and by a
//! random step whose covariance is the exact integral over the sample
//! interval. No integration step, no aliasing question, no model error: what
//! an estimator gets wrong on these data is its own.

use super::error::{PlantError, positive, require};
use super::linalg::{Square, discrete_lyapunov, van_loan};
use core::f64::consts::TAU;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// One mode of the noise generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseMode {
    /// Undamped natural frequency, Hz, > 0. It may lie above half the sampling rate.
    pub f_hz: f64,
    /// Damping ratio, 1, 0 < ζ < 1.
    pub zeta: f64,
    /// Standard deviation this mode alone gives to the output, output units, > 0.
    pub rms: f64,
}

/// Which force drives the modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Drive {
    /// Each mode has its own white noise: variances of the modes add.
    #[default]
    Independent,
    /// One white force drives all modes: there are antiresonances between them.
    Common,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Quantity {
    /// Sum of the modal displacements.
    #[default]
    Displacement,
    /// Sum of the modal velocities.
    Velocity,
}

/// Configuration of [`ModalNoise`].
#[derive(Clone, Debug, PartialEq)]
pub struct ModalNoiseConfig {
    /// Sampling rate, Hz, > 0.
    pub fs_hz: f64,
    /// The modes, at least one.
    pub modes: Vec<NoiseMode>,
    /// Which force drives them.
    pub drive: Drive,
    /// What is measured.
    pub quantity: Quantity,
    /// White measurement noise: variance of the modes over that of the noise, dB. `None`: none.
    pub snr_db: Option<f64>,
    /// Seed; the same seed gives the same samples to the bit.
    pub seed: u64,
}

/// A pole of the sampled process (the one with Im z ≥ 0 of a pair).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruePole {
    /// Undamped natural frequency, Hz.
    pub f_hz: f64,
    /// Damping ratio, 1.
    pub zeta: f64,
    /// Real part of z = e^((-ζω + jω√(1-ζ²))·dt).
    pub re: f64,
    /// Imaginary part of z; negative if the mode lies between fs/2 and fs.
    pub im: f64,
}

/// Exactly sampled response of known modes to white noise.
///
/// xₖ₊₁ = Φ·xₖ + L·eₖ, yₖ = C·xₖ + vₖ, with L·Lᵀ = ∫₀^dt e^(As)·G·Gᵀ·e^(Aᵀs) ds
/// (Van Loan) and e standard normal. The first state is drawn from the
/// stationary distribution, so that there is no start-up transient.
///
/// Per mode the state is (ω·q, q̇); both have the same variance g²/(4ζω), and
/// g = 2·rms·√(ζω) makes it rms².
///
/// ```
/// use rarma_plants::modal_noise::{ModalNoise, ModalNoiseConfig, NoiseMode};
/// let mut noise = ModalNoise::new(ModalNoiseConfig {
///     fs_hz: 5000.0,
///     modes: vec![NoiseMode { f_hz: 980.0, zeta: 0.02, rms: 1.0 }],
///     drive: Default::default(),
///     quantity: Default::default(),
///     snr_db: Some(20.0),
///     seed: 1,
/// })?;
/// let samples: Vec<f64> = noise.by_ref().take(5000).collect();
/// assert_eq!(noise.arma_order(), (2, 2));
/// assert!(samples.iter().all(|y| y.is_finite()));
/// # Ok::<(), rarma_plants::error::PlantError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModalNoise {
    config: ModalNoiseConfig,
    phi: Square,
    factor: Square,
    stationary: Square,
    state: Vec<f64>,
    scratch: Vec<f64>,
    normal: Vec<f64>,
    noise_std: f64,
    rng: ChaCha8Rng,
}

impl ModalNoise {
    /// Builds the generator in its stationary state.
    ///
    /// # Errors
    /// `WrongLength` without modes, `OutOfRange` naming the field otherwise.
    pub fn new(config: ModalNoiseConfig) -> Result<Self, PlantError> {
        let (phi, factor, stationary) = sampled(&config)?;
        let n = phi.n();
        let mut out = Self {
            noise_std: 0.0,
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            state: vec![0.0; n],
            scratch: vec![0.0; n],
            normal: vec![0.0; n],
            config,
            phi,
            factor,
            stationary,
        };
        out.noise_std = out.measurement_std();
        for e in &mut out.normal {
            *e = StandardNormal.sample(&mut out.rng);
        }
        out.stationary
            .cholesky_psd()
            .apply(&out.normal, &mut out.state);
        Ok(out)
    }

    /// Changes the modes while running and keeps the state: for processes whose
    /// damping moves. The measurement noise stays as it was built.
    ///
    /// # Errors
    /// `WrongLength` if the number of modes differs, `OutOfRange` as in `new`.
    pub fn retune(&mut self, modes: &[NoiseMode]) -> Result<(), PlantError> {
        if modes.len() != self.config.modes.len() {
            return Err(PlantError::WrongLength { name: "modes" });
        }
        let mut config = self.config.clone();
        config.modes = modes.to_vec();
        let (phi, factor, stationary) = sampled(&config)?;
        self.config = config;
        self.phi = phi;
        self.factor = factor;
        self.stationary = stationary;
        Ok(())
    }

    /// Next sample.
    pub fn next_sample(&mut self) -> f64 {
        let first = self.first();
        let y: f64 = self.state.iter().skip(first).step_by(2).sum();
        for e in &mut self.normal {
            *e = StandardNormal.sample(&mut self.rng);
        }
        self.phi.apply(&self.state, &mut self.scratch);
        self.factor.apply(&self.normal, &mut self.state);
        for (s, p) in self.state.iter_mut().zip(&self.scratch) {
            *s += p;
        }
        if self.noise_std > 0.0 {
            let v: f64 = StandardNormal.sample(&mut self.rng);
            y + self.noise_std * v
        } else {
            y
        }
    }

    /// The poles the data really have, in the order of the modes.
    #[must_use]
    pub fn true_poles(&self) -> Vec<TruePole> {
        let dt = 1.0 / self.config.fs_hz;
        self.config
            .modes
            .iter()
            .map(|m| {
                let w = TAU * m.f_hz;
                let radius = (-m.zeta * w * dt).exp();
                let angle = w * (1.0 - m.zeta * m.zeta).sqrt() * dt;
                TruePole {
                    f_hz: m.f_hz,
                    zeta: m.zeta,
                    re: radius * angle.cos(),
                    im: radius * angle.sin(),
                }
            })
            .collect()
    }

    /// Orders (p, q) of the process: (2n, 2n-1), or (2n, 2n) with measurement noise.
    #[must_use]
    pub fn arma_order(&self) -> (usize, usize) {
        let p = 2 * self.config.modes.len();
        (p, if self.noise_std > 0.0 { p } else { p - 1 })
    }

    /// Theoretical autocovariance at lags 0 to `lags`, measurement noise
    /// included: R(k) = C·Φᵏ·Σ·Cᵀ + δₖ·σv².
    #[must_use]
    pub fn autocovariance(&self, lags: usize) -> Vec<f64> {
        let n = self.phi.n();
        let first = self.first();
        let mut column: Vec<f64> = (0..n)
            .map(|i| {
                (first..n)
                    .step_by(2)
                    .map(|j| self.stationary.at(i, j))
                    .sum()
            })
            .collect();
        let mut next = vec![0.0; n];
        let mut out = Vec::with_capacity(lags + 1);
        for lag in 0..=lags {
            let modal: f64 = column.iter().skip(first).step_by(2).sum();
            out.push(if lag == 0 {
                modal + self.noise_std * self.noise_std
            } else {
                modal
            });
            self.phi.apply(&column, &mut next);
            core::mem::swap(&mut column, &mut next);
        }
        out
    }

    fn first(&self) -> usize {
        match self.config.quantity {
            Quantity::Displacement => 0,
            Quantity::Velocity => 1,
        }
    }

    fn measurement_std(&self) -> f64 {
        match self.config.snr_db {
            Some(db) => (self.autocovariance(0)[0] / 10f64.powf(db / 10.0)).sqrt(),
            None => 0.0,
        }
    }
}

impl Iterator for ModalNoise {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        Some(self.next_sample())
    }
}

/// Φ, factor of the sampled noise, stationary covariance.
fn sampled(config: &ModalNoiseConfig) -> Result<(Square, Square, Square), PlantError> {
    positive(config.fs_hz, "fs_hz")?;
    require(config.snr_db.is_none_or(f64::is_finite), "snr_db")?;
    if config.modes.is_empty() {
        return Err(PlantError::WrongLength { name: "modes" });
    }
    let n = 2 * config.modes.len();
    let mut a = Square::zeros(n);
    let mut w = Square::zeros(n);
    let mut gains = Vec::with_capacity(config.modes.len());
    for (i, m) in config.modes.iter().enumerate() {
        positive(m.f_hz, "f_hz")?;
        require(m.zeta > 0.0 && m.zeta < 1.0, "zeta")?;
        positive(m.rms, "rms")?;
        let omega = TAU * m.f_hz;
        a.set(2 * i, 2 * i + 1, omega);
        a.set(2 * i + 1, 2 * i, -omega);
        a.set(2 * i + 1, 2 * i + 1, -2.0 * m.zeta * omega);
        gains.push(2.0 * m.rms * (m.zeta * omega).sqrt());
    }
    for (i, gi) in gains.iter().enumerate() {
        for (j, gj) in gains.iter().enumerate() {
            if i == j || config.drive == Drive::Common {
                w.set(2 * i + 1, 2 * j + 1, gi * gj);
            }
        }
    }
    let (phi, q) = van_loan(&a, &w, 1.0 / config.fs_hz);
    let stationary = discrete_lyapunov(&phi, &q);
    Ok((phi, q.cholesky_psd(), stationary))
}

#[cfg(test)]
#[path = "modal_noise_tests.rs"]
mod tests;
