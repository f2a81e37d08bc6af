//! A sound for the emulated box: a resonance under noise that loses its damping for a while.
//!
//! ```text
//! x(t) = 2r·cos θ·x(t−1) − r²·x(t−2) + g·e(t),   r = e^(−ζω/fs)
//! ```

use core::f32::consts::TAU;
use rarma_core::real::Real;

/// Rate of the samples, Hz.
pub(super) const RATE_HZ: f32 = 8000.0;
/// The resonance, Hz.
const MODE_HZ: f32 = 900.0;
/// ζ at first and again at the end of each round, and in between.
const DAMPED: f32 = 0.03;
const UNDAMPED: f32 = 0.0005;
/// A round, and when in it the damping is gone, s.
const ROUND_S: f32 = 10.0;
const GONE_S: (f32, f32) = (4.0, 8.0);
/// Rms of the damped resonance, of full scale.
const RMS: f32 = 0.01;

/// The sound.
#[derive(Debug)]
pub(super) struct Resonance {
    past: (f32, f32),
    seed: u32,
    n: u32,
    /// 2r·cos θ and r² while damped and while not.
    poles: [(f32, f32); 2],
    gain: f32,
}

impl Resonance {
    pub(super) fn new() -> Self {
        let angle = TAU * MODE_HZ / RATE_HZ;
        let (_, cosine) = angle.sin_cos();
        let pole = |zeta: f32| {
            let r = (-zeta * angle).exp();
            (2.0 * r * cosine, r * r)
        };
        // Variance of an AR(2): (1 + v)/((1 − v)·((1 + v)² − u²)) times that of the noise, which is
        // 1/3 between −1 and 1.
        let (u, v) = pole(DAMPED);
        let variance = (1.0 + v) / ((1.0 - v) * ((1.0 + v) * (1.0 + v) - u * u)) / 3.0;
        Self {
            past: (0.0, 0.0),
            seed: 1,
            n: 0,
            poles: [pole(DAMPED), pole(UNDAMPED)],
            gain: RMS / variance.sqrt(),
        }
    }

    pub(super) fn next(&mut self) -> f32 {
        let t = self.n as f32 / RATE_HZ;
        self.n += 1;
        if t >= ROUND_S {
            self.n = 0;
        }
        let gone = t >= GONE_S.0 && t < GONE_S.1;
        let (u, v) = self.poles[usize::from(gone)];
        // Numerical Recipes' generator; the upper half is random enough for a noise.
        self.seed = self
            .seed
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let noise = (self.seed >> 16) as f32 / 32_768.0 - 1.0;
        let x = u * self.past.0 - v * self.past.1 + self.gain * noise;
        self.past = (x, self.past.0);
        x
    }
}
