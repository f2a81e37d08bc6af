//! The whole exciter on a machine, one period of the current loop at a time.
//!
//! A period: sensors are read at its start ([`ExciterPlant::read`]), a duty is given
//! ([`ExciterPlant::period`]) and drives the *next* period, as a timer with preload does.
//! Three-level modulation: two pulses a period of the whole supply, so that current passes
//! through its mean at the period's start.

use super::coil::{Coil, CoilConfig};
use super::sensors::{SensorConfig, Sensors};
use super::structure::{Structure, StructureConfig};
use crate::error::{PlantError, non_negative, positive, require};
use core::f64::consts::TAU;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Coils: +x, −x, +y, −y.
pub const COILS: usize = 4;

/// What is connected.
#[derive(Clone, Debug, PartialEq)]
pub struct ExciterConfig {
    /// The four magnets.
    pub coils: [CoilConfig; COILS],
    /// Gap at rest as it is thought to be, m.
    pub gap_m: f64,
    /// Supply, V.
    pub supply_v: f64,
    /// Periods of the loop a second.
    pub loop_hz: f64,
    /// Steps of the electric circuit in a period, even, from 4: ripple needs 20 or more.
    pub substeps: usize,
    /// Structure with the rotor in it.
    pub structure: StructureConfig,
    /// Sensors.
    pub sensors: SensorConfig,
    /// Unbalance of the rotor, kg·m.
    pub unbalance_kg_m: f64,
    /// Amplitude of the runout that the displacement sensors see at order 1, 2, 3, m.
    pub runout_m: [f64; 3],
    /// Lines of the bearings: order (times a revolution) and force at 300 revolutions/s, N,
    /// growing with the square of the speed.
    pub bearing_lines: Vec<(f64, f64)>,
}

impl Default for ExciterConfig {
    fn default() -> Self {
        Self {
            coils: [CoilConfig::default(); COILS],
            gap_m: 150e-6,
            supply_v: 48.0,
            loop_hz: 40e3,
            substeps: 20,
            structure: StructureConfig::table_3(0.1),
            sensors: SensorConfig::default(),
            unbalance_kg_m: 2e-6,
            runout_m: [3e-6, 1e-6, 0.5e-6],
            bearing_lines: vec![(0.43, 0.4), (3.64, 0.6), (5.36, 0.6)],
        }
    }
}

/// What the sensors say at the start of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Currents with their zero errors, A.
    pub current_a: [f64; COILS],
    /// Displacement of the rotor in x and y, runout included, m.
    pub displacement_m: [f64; 2],
    /// Acceleration at the front bearing, m/s².
    pub acceleration_m_per_s2: [f64; 2],
}

/// What is true at the start of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Currents, A.
    pub current_a: [f64; COILS],
    /// Magnetic force on the rotor, N.
    pub force_n: [f64; 2],
    /// Displacement of the rotor, m.
    pub displacement_m: [f64; 2],
    /// Largest flux density over that of its knee.
    pub flux_part: f64,
}

/// The plant.
#[derive(Clone, Debug)]
pub struct ExciterPlant {
    config: ExciterConfig,
    coils: [Coil; COILS],
    structure: Structure,
    sensors: Sensors,
    closing: [f64; COILS],
    duty: Option<[f64; COILS]>,
    next: Option<[f64; COILS]>,
    spindle_hz: f64,
    turned_hz: f64,
    angle: f64,
}

impl ExciterPlant {
    /// At rest, without current.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn new(config: ExciterConfig, seed: u64) -> Result<Self, PlantError> {
        positive(config.gap_m, "gap_m")?;
        positive(config.supply_v, "supply_v")?;
        positive(config.loop_hz, "loop_hz")?;
        let even = config.substeps >= 4 && config.substeps.is_multiple_of(2);
        require(even && config.substeps <= 1000, "substeps")?;
        non_negative(config.unbalance_kg_m, "unbalance_kg_m")?;
        require(config.runout_m.iter().all(|r| r.is_finite()), "runout_m")?;
        config.sensors.validate(2.0 * config.loop_hz)?;
        let dt = 1.0 / (config.loop_hz * config.substeps as f64);
        let coil = |k: usize| Coil::new(config.coils[k], dt);
        let closing = core::array::from_fn(|k| {
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            side * config.coils[k].pole_angle_rad.cos()
        });
        Ok(Self {
            coils: [coil(0)?, coil(1)?, coil(2)?, coil(3)?],
            structure: Structure::new(config.structure.clone(), 0.5 / config.loop_hz)?,
            sensors: Sensors::new(
                config.sensors,
                2.0 * config.loop_hz,
                ChaCha8Rng::seed_from_u64(seed),
            ),
            closing,
            duty: None,
            next: None,
            spindle_hz: 0.0,
            turned_hz: 0.0,
            angle: 0.0,
            config,
        })
    }

    /// What it is made of.
    #[must_use]
    pub fn config(&self) -> &ExciterConfig {
        &self.config
    }

    /// The sensors, for their responses.
    #[must_use]
    pub fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    /// The spindle turns at this speed, revolutions/s. Modes follow in steps of 0.05
    /// revolutions/s.
    pub fn turn(&mut self, spindle_hz: f64) {
        self.spindle_hz = spindle_hz;
        if (spindle_hz - self.turned_hz).abs() > 0.05 || spindle_hz == 0.0 && self.turned_hz != 0.0
        {
            self.structure.turn(spindle_hz);
            self.turned_hz = spindle_hz;
        }
    }

    /// Angle of the spindle, revolutions.
    #[must_use]
    pub fn revolutions(&self) -> f64 {
        self.angle
    }

    /// Reads every sensor.
    pub fn read(&mut self) -> Reading {
        let mut out = Reading::default();
        for k in 0..COILS {
            out.current_a[k] = self.sensors.current(k, self.coils[k].current_a());
        }
        for axis in 0..2 {
            out.displacement_m[axis] = self.sensors.displacement(axis);
            out.acceleration_m_per_s2[axis] = self.sensors.acceleration(axis);
        }
        out
    }

    /// What is true now.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let pull = |k: usize| self.coils[k].force_n();
        Truth {
            current_a: core::array::from_fn(|k| self.coils[k].current_a()),
            force_n: [pull(0) - pull(1), pull(2) - pull(3)],
            displacement_m: self.structure.rotor_m(),
            flux_part: self
                .coils
                .iter()
                .map(|c| c.flux_t() / c.config().saturation_t)
                .fold(0.0, f64::max),
        }
    }

    /// Runs one period with this duty in this very period: for a board that keeps the PWM's
    /// delay itself. None: switches open.
    pub fn drive(&mut self, duty: Option<[f64; COILS]>) {
        self.duty = duty;
        self.period(duty);
    }

    /// Runs one period; `duty`, mean voltage over the supply's, drives the next one. None:
    /// switches open, at once.
    pub fn period(&mut self, duty: Option<[f64; COILS]>) {
        let steps = self.config.substeps;
        let dt = 1.0 / (self.config.loop_hz * steps as f64);
        if duty.is_none() {
            self.duty = None;
        }
        self.next = duty;
        for half in 0..2 {
            let (x, v) = (self.structure.rotor_m(), self.structure.rotor_m_per_s());
            for n in 0..steps / 2 {
                let at = half * steps / 2 + n;
                let middle = (n as f64 + 0.5) * dt;
                for k in 0..COILS {
                    let axis = k / 2;
                    let toward = x[axis] + v[axis] * middle;
                    let gap = self.config.gap_m - self.closing[k] * toward;
                    let volts = match self.duty {
                        Some(d) => self.config.supply_v * pulse(d[k], at, steps),
                        None => -self.config.supply_v,
                    };
                    self.coils[k].step(volts, gap);
                }
            }
            self.move_on(0.5 / self.config.loop_hz);
        }
        self.duty = self.next;
    }

    fn move_on(&mut self, dt: f64) {
        self.angle += self.spindle_hz * dt;
        let turn = TAU * self.spindle_hz;
        let mut force = self.truth().force_n;
        let (s, c) = (TAU * self.angle).sin_cos();
        let swing = self.config.unbalance_kg_m * turn * turn;
        force[0] += swing * c;
        force[1] += swing * s;
        let strength = (self.spindle_hz / 300.0).powi(2);
        for &(order, newton) in &self.config.bearing_lines {
            let (s, c) = (TAU * order * self.angle).sin_cos();
            force[0] += strength * newton * c;
            force[1] += strength * newton * s;
        }
        self.structure.step(force);
        let mut seen = self.structure.rotor_m();
        for (k, r) in self.config.runout_m.iter().enumerate() {
            let phase = TAU * (k + 1) as f64 * self.angle;
            seen[0] += r * phase.cos();
            seen[1] += r * phase.sin();
        }
        self.sensors.follow(seen, self.structure.casing_m_per_s2());
    }
}

/// Mean of the three-level voltage over substep `at` of `steps`, over the supply: pulses of
/// half the duty about one and three quarters of the period.
fn pulse(duty: f64, at: usize, steps: usize) -> f64 {
    let (low, high) = (at as f64 / steps as f64, (at + 1) as f64 / steps as f64);
    let half = 0.25 * duty.abs().min(1.0);
    let covered = |centre: f64| {
        let overlap = high.min(centre + half) - low.max(centre - half);
        overlap.max(0.0)
    };
    (covered(0.25) + covered(0.75)) / (high - low) * duty.signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_have_the_duty_as_their_mean() {
        for duty in [-1.0, -0.31, 0.0, 0.013, 0.5, 1.0] {
            let mean: f64 = (0..50).map(|n| pulse(duty, n, 50)).sum::<f64>() / 50.0;
            assert!((mean - duty).abs() < 1e-12, "{duty}: {mean}");
        }
    }

    #[test]
    fn ripple_is_that_of_three_levels_and_samples_see_its_mean() {
        // U/(8·f·L) at half duty; the coil without leakage, iron and lag: 4.19 mH.
        let coil = CoilConfig {
            iron_path_m: 0.0,
            leakage_h: 0.0,
            saturation_t: 3.0,
            resistance_ohm: 30.0,
            ..CoilConfig::default()
        };
        let dt = 1.0 / (50e3 * 100.0);
        let mut c = Coil::new(coil, dt).expect("valid");
        let (mut low, mut high, mut sampled, mut mean) = (f64::MAX, 0.0f64, 0.0, 0.0);
        for period in 0..400 {
            for n in 0..100 {
                if n == 0 && period >= 300 {
                    sampled += c.current_a() / 100.0;
                }
                let i = c.step(48.0 * pulse(0.5, n, 100), 150e-6);
                if period >= 300 {
                    (low, high) = (low.min(i), high.max(i));
                    mean += i / 10_000.0;
                }
            }
        }
        let ripple = high - low;
        println!(
            "ripple {:.4} A, sampled − mean {:.5} A",
            ripple,
            sampled - mean
        );
        assert!(
            (ripple / (48.0 / (8.0 * 50e3 * 4.19e-3)) - 1.0).abs() < 0.05,
            "{ripple}"
        );
        assert!((sampled - mean).abs() < 0.05 * ripple);
    }

    #[test]
    fn equal_currents_pull_nowhere_and_open_switches_end_them() {
        let mut plant = ExciterPlant::new(ExciterConfig::default(), 1).expect("valid");
        for _ in 0..2000 {
            plant.period(Some([0.0667; COILS]));
        }
        let t = plant.truth();
        assert!(t.current_a.iter().all(|i| (i - 0.8).abs() < 0.01), "{t:?}");
        assert!(t.force_n[0].abs() < 1e-3 && t.force_n[1].abs() < 1e-3);
        let mut periods = 0;
        while plant.truth().current_a.iter().any(|i| *i > 0.0) {
            plant.period(None);
            periods += 1;
        }
        assert!((2..=4).contains(&periods), "{periods} periods of 25 µs");
    }

    #[test]
    fn the_same_seed_gives_the_same_readings() {
        let run = |seed| {
            let mut plant = ExciterPlant::new(ExciterConfig::default(), seed).expect("valid");
            plant.turn(100.0);
            for _ in 0..50 {
                plant.period(Some([0.1; COILS]));
            }
            plant.read()
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }
}
