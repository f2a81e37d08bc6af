//! What the sensors make of currents and motion: bandwidth, noise, zero, converter.
//!
//! Rate: [`Sensors::follow`] twice a period of the loop, a reading once.

use crate::error::{PlantError, non_negative, positive, require};
use core::f64::consts::PI;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_core::condition::{Biquad, BiquadState, Pass};

/// Sensors of the exciter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorConfig {
    /// Noise of a current sensor, A, standard deviation.
    pub current_noise_a: f64,
    /// Zero error of each, A.
    pub current_offset_a: [f64; 4],
    /// Gain error of each, part.
    pub current_gain_error: [f64; 4],
    /// Current from end to end of the converter, A; zero is in its middle. 0: no steps.
    pub current_span_a: f64,
    /// Corner of the displacement sensors' demodulator, Hz; second order.
    pub displacement_hz: f64,
    /// Noise of a displacement sensor, m.
    pub displacement_noise_m: f64,
    /// Displacement from end to end of the converter, m; 0: no steps.
    pub displacement_span_m: f64,
    /// Corner of the accelerometer, Hz; second order.
    pub acceleration_hz: f64,
    /// Noise of the accelerometer, m/s².
    pub acceleration_noise_m_per_s2: f64,
    /// Bits of the converters; oversampling counts.
    pub bits: u32,
}

impl Default for SensorConfig {
    fn default() -> Self {
        Self {
            current_noise_a: 1e-3,
            current_offset_a: [0.03, -0.02, 0.01, -0.04],
            current_gain_error: [0.0; 4],
            current_span_a: 8.0,
            displacement_hz: 10e3,
            displacement_noise_m: 20e-9,
            displacement_span_m: 400e-6,
            acceleration_hz: 10e3,
            acceleration_noise_m_per_s2: 0.05,
            bits: 14,
        }
    }
}

impl SensorConfig {
    /// Without noise, zero errors and steps of the converter; bandwidths stay.
    #[must_use]
    pub fn quiet(self) -> Self {
        Self {
            current_noise_a: 0.0,
            current_offset_a: [0.0; 4],
            current_gain_error: [0.0; 4],
            current_span_a: 0.0,
            displacement_noise_m: 0.0,
            displacement_span_m: 0.0,
            acceleration_noise_m_per_s2: 0.0,
            ..self
        }
    }

    pub(super) fn validate(&self, rate_hz: f64) -> Result<(), PlantError> {
        non_negative(self.current_noise_a, "current_noise_a")?;
        non_negative(self.current_span_a, "current_span_a")?;
        non_negative(self.displacement_noise_m, "displacement_noise_m")?;
        non_negative(self.displacement_span_m, "displacement_span_m")?;
        non_negative(
            self.acceleration_noise_m_per_s2,
            "acceleration_noise_m_per_s2",
        )?;
        for (f, name) in [
            (self.displacement_hz, "displacement_hz"),
            (self.acceleration_hz, "acceleration_hz"),
        ] {
            positive(f, name)?;
            require(f < 0.45 * rate_hz, name)?;
        }
        require((6..=24).contains(&self.bits), "bits")
    }
}

/// Sensors that follow.
#[derive(Clone, Debug)]
pub struct Sensors {
    config: SensorConfig,
    rate_hz: f64,
    filters: [Biquad<f64>; 2],
    states: [BiquadState<f64>; 4],
    now: [f64; 4],
    rng: ChaCha8Rng,
}

impl Sensors {
    pub(super) fn new(config: SensorConfig, rate_hz: f64, rng: ChaCha8Rng) -> Self {
        let filter = |f| Biquad::butterworth(Pass::Low, f, rate_hz, 0, 1);
        Self {
            config,
            rate_hz,
            filters: [
                filter(config.displacement_hz),
                filter(config.acceleration_hz),
            ],
            states: [BiquadState::default(); 4],
            now: [0.0; 4],
            rng,
        }
    }

    /// Displacement and acceleration now, in x and y.
    pub(super) fn follow(&mut self, displacement_m: [f64; 2], acceleration_m_per_s2: [f64; 2]) {
        for k in 0..2 {
            self.now[k] = self.filters[0].process(&mut self.states[k], displacement_m[k]);
            self.now[2 + k] =
                self.filters[1].process(&mut self.states[2 + k], acceleration_m_per_s2[k]);
        }
    }

    /// Response of the displacement sensor at `f_hz`, (real, imaginary), e^{+jωt}: what
    /// an analysis has to divide by.
    #[must_use]
    pub fn displacement_response(&self, f_hz: f64) -> (f64, f64) {
        self.response(f_hz, self.config.displacement_hz)
    }

    /// The same of the accelerometer.
    #[must_use]
    pub fn acceleration_response(&self, f_hz: f64) -> (f64, f64) {
        self.response(f_hz, self.config.acceleration_hz)
    }

    /// 1/(1 + √2·p + p²), p = j·tan(πf/fs)/tan(πf_c/fs).
    fn response(&self, f_hz: f64, corner_hz: f64) -> (f64, f64) {
        let p = (PI * f_hz / self.rate_hz).tan() / (PI * corner_hz / self.rate_hz).tan();
        let (re, im) = (1.0 - p * p, core::f64::consts::SQRT_2 * p);
        let d = re * re + im * im;
        (re / d, -im / d)
    }

    fn noise(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }

    fn convert(&self, x: f64, span: f64) -> f64 {
        if span <= 0.0 {
            return x;
        }
        let step = span / f64::from(1u32 << self.config.bits);
        ((x / step).round() * step).clamp(-0.5 * span, 0.5 * span)
    }

    pub(super) fn current(&mut self, coil: usize, current_a: f64) -> f64 {
        let c = self.config;
        let x = current_a * (1.0 + c.current_gain_error[coil])
            + c.current_offset_a[coil]
            + c.current_noise_a * self.noise();
        self.convert(x, c.current_span_a)
    }

    pub(super) fn displacement(&mut self, axis: usize) -> f64 {
        let x = self.now[axis] + self.config.displacement_noise_m * self.noise();
        self.convert(x, self.config.displacement_span_m)
    }

    pub(super) fn acceleration(&mut self, axis: usize) -> f64 {
        self.now[2 + axis] + self.config.acceleration_noise_m_per_s2 * self.noise()
    }
}
