//! Regulator, cylinder and transducer.

use std::collections::VecDeque;

/// What the air goes through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirConfig {
    /// Pressure at the regulator's upper end (10 V), Pa.
    pub span_pa: f64,
    /// Dead time, s.
    pub dead_s: f64,
    /// Lag, s.
    pub lag_s: f64,
    /// Lag of venting, s.
    pub vent_s: f64,
    /// Error of its gain, 1.
    pub gain_error: f64,
    /// Half-width of its hysteresis, Pa.
    pub hysteresis_pa: f64,
    /// Steps of the command, Pa: 12 bits of 9 bar are 220 Pa.
    pub step_pa: f64,
    /// Part of the pressure that leaks away.
    pub leak: f64,
    /// Piston: N/Pa and N.
    pub gain_n_per_pa: f64,
    /// See [`Self::gain_n_per_pa`].
    pub offset_n: f64,
    /// Friction of the seal, N.
    pub friction_n: f64,
    /// Stroke over which the seal lets go, m.
    pub stick_m: f64,
    /// Noise of the transducer, Pa, and its steps, Pa.
    pub noise_pa: f64,
    /// See [`Self::noise_pa`].
    pub resolution_pa: f64,
}

impl Default for AirConfig {
    fn default() -> Self {
        Self {
            span_pa: 9e5,
            dead_s: 0.02,
            lag_s: 0.1,
            vent_s: 0.05,
            gain_error: 0.01,
            hysteresis_pa: 2e3,
            step_pa: 220.0,
            leak: 0.0,
            gain_n_per_pa: 126e-5,
            offset_n: -14.0,
            friction_n: 1.5,
            stick_m: 20e-6,
            noise_pa: 250.0,
            resolution_pa: 300.0,
        }
    }
}

/// The air as it is.
#[derive(Debug, Clone)]
pub struct Air {
    /// What it goes through.
    pub config: AirConfig,
    line: VecDeque<f64>,
    asked_pa: f64,
    held_pa: f64,
    pressure_pa: f64,
    /// How far the seal is bent, −1 to 1.
    seal: f64,
    length_m: f64,
}

impl Air {
    /// Vented.
    pub fn new(config: AirConfig) -> Self {
        Self {
            config,
            line: VecDeque::new(),
            asked_pa: 0.0,
            held_pa: 0.0,
            pressure_pa: 0.0,
            seal: 0.0,
            length_m: 0.0,
        }
    }

    /// `dt_s` on: `command_pa` is what the regulator is asked for, none where it has no supply
    /// and vents. `length_m`: the bar's length change, which moves the piston.
    pub fn step(&mut self, dt_s: f64, command_pa: Option<f64>, length_m: f64) {
        let c = self.config;
        let before = self.pressure_pa;
        let Some(command) = command_pa else {
            self.line.clear();
            self.held_pa = 0.0;
            self.asked_pa = 0.0;
            self.pressure_pa -= self.pressure_pa * dt_s / (c.vent_s + dt_s);
            return;
        };
        let steps = (command.clamp(0.0, c.span_pa) / c.step_pa).round();
        self.line.push_back(steps * c.step_pa);
        if self.line.len() as f64 * dt_s > c.dead_s {
            self.asked_pa = self.line.pop_front().unwrap_or(0.0);
        }
        // A play: the regulator's hysteresis.
        self.held_pa = self.held_pa.clamp(
            self.asked_pa - c.hysteresis_pa,
            self.asked_pa + c.hysteresis_pa,
        );
        let goal = self.held_pa * (1.0 + c.gain_error) * (1.0 - c.leak);
        self.pressure_pa += (goal - self.pressure_pa) * dt_s / (c.lag_s + dt_s);
        // A moving pressure works the seal loose; a moving piston bends it.
        let shaken = (self.pressure_pa - before).abs() / dt_s;
        self.seal *= (-shaken * dt_s / 2e4).exp();
        self.seal = (self.seal + (length_m - self.length_m) / c.stick_m).clamp(-1.0, 1.0);
        self.length_m = length_m;
    }

    /// Pressure in the cylinder, Pa.
    pub fn pressure_pa(&self) -> f64 {
        self.pressure_pa
    }

    /// Force along the bar, N; none below 0.
    pub fn force_n(&self) -> f64 {
        let c = &self.config;
        (c.gain_n_per_pa * self.pressure_pa + c.offset_n - c.friction_n * self.seal).max(0.0)
    }

    /// What the transducer says, Pa; `noise` is standard normal.
    pub fn measured_pa(&self, noise: f64) -> f64 {
        let c = &self.config;
        let p = self.pressure_pa + c.noise_pa * noise;
        if c.resolution_pa > 0.0 {
            (p / c.resolution_pa).round() * c.resolution_pa
        } else {
            p
        }
    }
}
