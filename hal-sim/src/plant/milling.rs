//! Regenerative milling in the time domain.
//!
//! Responsibility: a cutter with straight teeth on a structure with modes in x
//! (feed) and y (normal to it), cutting the surface that its own earlier teeth
//! left. Rate: [`Milling::step`] runs once per integration step, an integer
//! number of which makes a revolution; no allocation.
//!
//! Glossary: *cell* the angle of one step; *tip* the radial position of a
//! cutting edge; *Heun* one predictor and one corrector for the force.

use super::error::{PlantError, require};
pub use super::milling_config::{Engagement, MillingConfig};
use super::modal::ModeBank;
use super::process::{Contact, SmoothNoise};
use core::f64::consts::TAU;

/// What the machine does at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MillSample {
    /// Time, s.
    pub t: f64,
    /// Displacement of the tool in x and y, m.
    pub position_m: [f64; 2],
    /// Velocity in x and y, m/s.
    pub velocity_m_s: [f64; 2],
    /// Acceleration in x and y, m/s².
    pub acceleration_m_s2: [f64; 2],
    /// Force on the tool in x and y, N, background noise included.
    pub force_n: [f64; 2],
    /// Axial depth, m.
    pub depth_m: f64,
    /// Largest chip thickness over the teeth in the arc, m; 0 out of contact.
    pub chip_m: f64,
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    sin: f64,
    cos: f64,
    weight: f64,
    surface: f64,
}

#[derive(Clone, Copy, Debug)]
struct Motion {
    q: [f64; 2],
    v: [f64; 2],
}

/// The virtual milling machine.
///
/// For tooth j at angle φ (from +y, clockwise), with the tool at (x, y), the
/// feed position X = v_f·t and the runout ρ_j:
///
/// tip u = (x + X)·sin φ + y·cos φ + ρ_j, chip h = max(0, u - S\[φ\]),
/// S\[φ\] ← u wherever the tooth cut; Ft = (Kt·h + Kte)·b, Fr = (Kn·h + Kne)·b;
/// Fx = -Ft·cos φ - Fr·sin φ, Fy = +Ft·sin φ - Fr·cos φ.
///
/// With equal teeth that all cut, u - S is the textbook h = fz·sin φ +
/// Δx·sin φ + Δy·cos φ with Δ = q(t) - q(t-τ). S holds the highest of *all*
/// earlier passes, so a tooth that jumps out leaves its wave to the next one.
/// At depth 0 the surface follows the teeth without force, so entry into the
/// cut meets a fresh surface.
///
/// The structure advances exactly for a force linear within the step; the
/// force at the end of the step is predicted with the old force and corrected
/// once. A force simply held over the step would act half a step late, which
/// is negative damping of about b·H·dt/(4mω): enough to move a limit.
///
/// Limits: circular tooth paths (feed small against the radius), straight
/// teeth, no axial modes, angles on the grid of cells.
#[derive(Clone, Debug)]
pub struct Milling {
    config: MillingConfig,
    dt: f64,
    cells: Vec<Cell>,
    tooth_cell: Vec<usize>,
    runout: Vec<f64>,
    bank: [ModeBank; 2],
    force: [f64; 2],
    damping: Option<(f64, f64)>,
    noise: Option<SmoothNoise<4>>,
    feed_speed: f64,
    index: u64,
}

impl Milling {
    /// Builds the machine at rest, with the surface left by one undisturbed
    /// revolution before time 0.
    ///
    /// # Errors
    /// As [`MillingConfig::validate`] and [`Mode::validate`](super::modal::Mode::validate).
    pub fn new(config: MillingConfig) -> Result<Self, PlantError> {
        config.validate()?;
        let per_tooth = (config.min_step_rate_hz / config.tooth_hz() - 1e-9)
            .ceil()
            .max(4.0) as usize;
        let count = per_tooth * config.teeth;
        let dt = 1.0 / (config.spindle_hz * count as f64);
        let cell = TAU / count as f64;
        let cells: Vec<Cell> = (0..count)
            .map(|i| {
                let angle = cell * i as f64;
                let (sin, cos) = angle.sin_cos();
                Cell {
                    sin,
                    cos,
                    weight: config.engagement.weight(angle, cell),
                    surface: 0.0,
                }
            })
            .collect();
        // Tooth j trails tooth 0 by the pitches before it.
        let mut angle = 0.0;
        let mut tooth_cell = Vec::with_capacity(config.teeth);
        for j in 0..config.teeth {
            let lag = (angle / cell).round() as usize % count;
            tooth_cell.push((count - lag) % count);
            angle += config
                .pitch_rad
                .get(j)
                .copied()
                .unwrap_or(TAU / config.teeth as f64);
        }
        let mut sorted = tooth_cell.clone();
        sorted.sort_unstable();
        require(sorted.windows(2).all(|w| w[0] != w[1]), "pitch_rad")?;
        let mut runout = config.runout_m.clone();
        runout.resize(config.teeth, 0.0);
        let noisy = config.noise.relative > 0.0 || config.noise.background_n > 0.0;
        let mut out = Self {
            dt,
            cells,
            tooth_cell,
            runout,
            bank: [
                ModeBank::new(&config.modes_x, dt)?,
                ModeBank::new(&config.modes_y, dt)?,
            ],
            force: [0.0; 2],
            damping: config
                .process_damping
                .map(|p| (p.per_speed(config.spindle_hz), p.friction)),
            noise: noisy.then(|| SmoothNoise::new(config.noise.bandwidth_hz, dt, config.seed)),
            feed_speed: config.feed_per_tooth_m * config.tooth_hz(),
            index: 0,
            config,
        };
        out.lay_first_surface();
        Ok(out)
    }

    /// Step length, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Steps per second, Hz.
    #[must_use]
    pub fn step_rate_hz(&self) -> f64 {
        self.config.spindle_hz * self.cells.len() as f64
    }

    /// Steps per mean tooth period.
    #[must_use]
    pub fn steps_per_tooth(&self) -> usize {
        self.cells.len() / self.config.teeth
    }

    /// The configuration it was built from.
    #[must_use]
    pub fn config(&self) -> &MillingConfig {
        &self.config
    }

    /// Sets mode `index` of direction `axis` (0 = x, 1 = y) to displacement m
    /// and velocity m/s: a disturbance to watch grow or decay.
    pub fn disturb(&mut self, axis: usize, index: usize, q: f64, v: f64) {
        if let Some(bank) = self.bank.get_mut(axis) {
            bank.set_state(index, q, v);
        }
    }

    /// Advances by one step and returns the state after it.
    pub fn step(&mut self) -> MillSample {
        self.index += 1;
        let t = self.index as f64 * self.dt;
        let depth = self.config.depth.at(t);
        let noise = self.noise.as_mut().map_or([0.0; 4], SmoothNoise::advance);
        let turn = (self.index % self.cells.len() as u64) as usize;
        let old = self.force;
        let ahead = [
            self.bank[0].peek(old[0], old[0]),
            self.bank[1].peek(old[1], old[1]),
        ];
        let predicted = Motion {
            q: [ahead[0].0, ahead[1].0],
            v: [ahead[0].1, ahead[1].1],
        };
        let (force, _) = self.cut(&predicted, t, turn, depth, &noise);
        let x = self.bank[0].step(old[0], force[0]);
        let y = self.bank[1].step(old[1], force[1]);
        let motion = Motion {
            q: [x.0, y.0],
            v: [x.1, y.1],
        };
        let (force, chip) = self.cut(&motion, t, turn, depth, &noise);
        self.write_surface(&motion, t, turn);
        self.force = force;
        MillSample {
            t,
            position_m: motion.q,
            velocity_m_s: motion.v,
            acceleration_m_s2: [
                self.bank[0].acceleration_m_s2(force[0]),
                self.bank[1].acceleration_m_s2(force[1]),
            ],
            force_n: force,
            depth_m: depth,
            chip_m: chip,
        }
    }

    /// Force on the tool and largest chip for this motion; changes nothing.
    fn cut(&self, m: &Motion, t: f64, turn: usize, b: f64, noise: &[f64; 4]) -> ([f64; 2], f64) {
        let c = &self.config;
        let background = c.noise.background_n;
        let mut force = [background * noise[2], background * noise[3]];
        let mut chip = 0.0_f64;
        if b <= 0.0 {
            return (force, chip);
        }
        let x = m.q[0] + self.feed_speed * t;
        for (start, runout) in self.tooth_cell.iter().zip(&self.runout) {
            let cell = &self.cells[wrap(start + turn, self.cells.len())];
            if cell.weight <= 0.0 {
                continue;
            }
            let h = x * cell.sin + m.q[1] * cell.cos + runout - cell.surface;
            let linear = c.contact == Contact::Linear;
            if h <= 0.0 && !linear {
                continue;
            }
            chip = chip.max(h);
            let edge = if linear { 0.0 } else { 1.0 };
            let mut tangential = c.kt_n_per_m2 * h + edge * c.kt_edge_n_per_m;
            let mut radial = c.kn_n_per_m2 * h + edge * c.kn_edge_n_per_m;
            if let Some((c_over_v, friction)) = self.damping {
                let rub = c_over_v * (m.v[0] * cell.sin + m.v[1] * cell.cos);
                radial += rub;
                tangential += friction * rub;
            }
            tangential *= b * cell.weight * (1.0 + c.noise.relative * noise[0]);
            radial *= b * cell.weight * (1.0 + c.noise.relative * noise[1]);
            force[0] -= tangential * cell.cos + radial * cell.sin;
            force[1] += tangential * cell.sin - radial * cell.cos;
        }
        (force, chip)
    }

    fn write_surface(&mut self, m: &Motion, t: f64, turn: usize) {
        let x = m.q[0] + self.feed_speed * t;
        let count = self.cells.len();
        for (start, runout) in self.tooth_cell.iter().zip(&self.runout) {
            let cell = &mut self.cells[wrap(start + turn, count)];
            let tip = x * cell.sin + m.q[1] * cell.cos + runout;
            if tip > cell.surface || self.config.contact == Contact::Linear {
                cell.surface = tip;
            }
        }
    }

    /// The surface one revolution before time 0 would have left, tool at rest.
    fn lay_first_surface(&mut self) {
        let still = Motion {
            q: [0.0; 2],
            v: [0.0; 2],
        };
        for cell in &mut self.cells {
            cell.surface = f64::NEG_INFINITY;
        }
        for back in (0..self.cells.len()).rev() {
            let turn = (self.cells.len() - back) % self.cells.len();
            self.write_surface(&still, -(back as f64) * self.dt, turn);
        }
    }
}

fn wrap(index: usize, count: usize) -> usize {
    if index >= count { index - count } else { index }
}

#[cfg(test)]
#[path = "milling_tests.rs"]
mod tests;
