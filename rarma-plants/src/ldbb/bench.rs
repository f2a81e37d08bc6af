//! Machine, bar, gauge and air together.

use super::air::{Air, AirConfig};
use super::machine::{Commanded, Machine, MachineConfig};
use super::motion::{Motion, MotionFault, Program};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugeConfig {
    /// Noise, m.
    pub noise_m: f64,
    /// Steps, m.
    pub step_m: f64,
    /// Compliance of the bar and its joints, m/N: the gauge reads it along with the
    /// machine's.
    pub bar_m_per_n: f64,
}

impl Default for GaugeConfig {
    fn default() -> Self {
        Self {
            noise_m: 0.4e-6,
            step_m: 0.1e-6,
            bar_m_per_n: 0.0,
        }
    }
}

/// Everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchConfig {
    /// The machine.
    pub machine: MachineConfig,
    /// The air.
    pub air: AirConfig,
    /// The gauge.
    pub gauge: GaugeConfig,
    /// Inclination of the bar, rad.
    pub inclination_rad: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// One reading, and what is true of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reading {
    /// The gauge, m.
    pub gauge_m: f64,
    /// The transducer, Pa.
    pub pressure_pa: f64,
    /// Angle, rad.
    pub theta: f64,
    /// Force along the bar, N.
    pub force_n: f64,
    /// Change of the bar's length, m, without noise.
    pub length_m: f64,
}

/// The bench.
#[derive(Debug, Clone)]
pub struct Bench {
    config: BenchConfig,
    machine: Machine,
    air: Air,
    motion: Motion,
    rng: ChaCha8Rng,
    length_m: f64,
}

impl Bench {
    /// The spindle stands at 0°, the air is vented.
    pub fn new(config: BenchConfig) -> Self {
        Self {
            machine: Machine::new(config.machine),
            air: Air::new(config.air),
            motion: Motion::standing(0.0),
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            length_m: 0.0,
            config,
        }
    }

    /// The axes.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The air, to spoil it.
    pub fn air_mut(&mut self) -> &mut Air {
        &mut self.air
    }

    /// Goes to the start of a program and waits there.
    pub fn prepare(&mut self, program: &Program) {
        self.motion.prepare(program);
    }

    /// Starts a program.
    pub fn start(&mut self, program: Program, fault: Option<MotionFault>) {
        self.motion.start(program, fault);
    }

    /// Stands at an angle, rad.
    pub fn stand(&mut self, theta: f64) {
        self.motion.stand(theta);
        self.machine.released();
    }

    /// `dt_s` on; `command_pa` as in [`Air::step`].
    pub fn step(&mut self, dt_s: f64, command_pa: Option<f64>) -> Reading {
        self.air.step(dt_s, command_pa, self.length_m);
        self.after_air(dt_s)
    }

    /// `dt_s` on with a pressure that comes from elsewhere, Pa.
    pub fn step_at_force(&mut self, dt_s: f64, force_n: f64) -> f64 {
        self.motion.step(dt_s);
        self.move_to(force_n);
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        self.read(noise)
    }

    fn after_air(&mut self, dt_s: f64) -> Reading {
        self.motion.step(dt_s);
        let force_n = self.air.force_n();
        self.move_to(force_n);
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        let gauge_m = self.read(noise);
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        Reading {
            gauge_m,
            pressure_pa: self.air.measured_pa(noise),
            theta: self.motion.place().theta,
            force_n,
            length_m: self.length_m,
        }
    }

    fn move_to(&mut self, force_n: f64) {
        let place = self.motion.place();
        let incline = self.config.inclination_rad;
        let at = Commanded {
            theta: place.theta,
            radius_m: self.config.machine.radius_m + place.outside_m,
            speed_m_s: place.speed_m_s,
            inclination_rad: incline,
        };
        let in_plane = self.machine.length_change_m(&at, force_n * incline.cos());
        // Stiff across the plane: only the part along the bar is seen.
        self.length_m = in_plane * incline.cos() + self.config.gauge.bar_m_per_n * force_n;
    }

    fn read(&self, noise: f64) -> f64 {
        let g = &self.config.gauge;
        let x = self.length_m + g.noise_m * noise;
        if g.step_m > 0.0 {
            (x / g.step_m).round() * g.step_m
        } else {
            x
        }
    }
}
