//! Regenerative milling in the time domain.
//!
//! Responsibility: a cutter on a structure with modes of any shape, cutting the
//! surface that its own earlier teeth left. Rate: [`Milling::step`] runs once per
//! integration step, an integer number of which makes a revolution; no
//! allocation, except where the spindle speed changes.
//!
//! Glossary: *cell* the angle of one step; *slice* a part of the depth with one
//! helix lag; *tip* the radial position of a cutting edge; *Heun* one predictor
//! and one corrector for the force.

use super::error::PlantError;
pub use super::milling_config::{Engagement, MillingConfig};
pub use super::milling_motion::MillSample;
use super::milling_motion::{Motion, Moving, tooth_cells};
use super::modal::{FohStep, ShapedMode, StepTable};
use super::process::{Contact, SmoothNoise};
pub use super::workpiece::{Gap, Workpiece};
use core::f64::consts::TAU;

/// Slices at most, and the helix lag one of them may have.
const MOST_SLICES: usize = 64;
const SLICE_RAD: f64 = 0.05;

#[derive(Clone, Copy, Debug)]
struct Cell {
    sin: f64,
    cos: f64,
    weight: f64,
}

/// What holds for all teeth during one step.
#[derive(Clone, Copy, Debug)]
struct Now {
    turn: usize,
    feed: f64,
    depth: f64,
    kt: f64,
    kn: f64,
    edge: [f64; 2],
    rub: Option<(f64, f64)>,
    factor: [f64; 2],
    background: [f64; 2],
}

/// The virtual milling machine.
///
/// For tooth j at angle φ (from +y, clockwise), with the tool at (x, y) and turned
/// ahead by ϑ, the feed position X, the feed per radian g and the runout ρ_j:
///
/// tip u = (x + X - g·ϑ)·sin φ + y·cos φ + ρ_j, chip h = max(0, u - S\[φ\]),
/// S\[φ\] ← u wherever the tooth cut; Ft = (Kt·h + Kte)·b, Fr = (Kn·h + Kne)·b;
/// Fx = -Ft·cos φ - Fr·sin φ, Fy = +Ft·sin φ - Fr·cos φ, Mz = -Ft·D/2.
///
/// With equal teeth that all cut, u - S is the textbook h = fz·sin φ +
/// Δx·sin φ + Δy·cos φ with Δ = q(t) - q(t-τ). S holds the highest of *all*
/// earlier passes, so a tooth that jumps out leaves its wave to the next one.
/// Where there is no material (depth 0, a gap of the workpiece) the surface
/// follows the teeth without force, so re-entry meets a fresh surface. A helix
/// cuts the depth into slices of at most 0.05 rad lag, each with its own surface.
///
/// The structure advances exactly for a force linear within the step; the
/// force at the end of the step is predicted with the old force and corrected
/// once. A force simply held over the step would act half a step late, which
/// is negative damping of about b·H·dt/(4mω): enough to move a limit.
///
/// Where the speed changes, it does so from revolution to revolution, and the
/// step with it: the angles stay on their grid. A speed that swings does so from
/// step to step: each is as long as the spindle takes for one cell, so that the
/// delay solves the integral of the speed over it without an interpolation. The
/// feed follows the spindle.
///
/// Limits: circular tooth paths (feed small against the radius), no axial modes,
/// angles on the grid of cells.
#[derive(Clone, Debug)]
pub struct Milling {
    config: MillingConfig,
    modes: Vec<Moving>,
    dt: f64,
    spindle_hz: f64,
    cells: Vec<Cell>,
    surface: Vec<f64>,
    tooth_cell: Vec<usize>,
    slice_lag: Vec<usize>,
    slice_m: f64,
    runout: Vec<f64>,
    noise: Option<SmoothNoise<4>>,
    feed_per_step: f64,
    feed_ahead: f64,
    index: u64,
    /// Index and time at which the present speed began.
    since: (u64, f64),
    /// A speed that goes before the schedule's, Hz.
    told_hz: Option<f64>,
    /// The speed without its swing, Hz.
    carrier_hz: f64,
    /// Where the speed swings: the time, s, and the steps of each mode by their length.
    swinging: Option<(f64, Vec<StepTable>)>,
}

impl Milling {
    /// Builds the machine at rest, with the surface left by one undisturbed
    /// revolution before time 0.
    ///
    /// # Errors
    /// As [`MillingConfig::validate`] and [`Mode::validate`](super::modal::Mode::validate).
    pub fn new(config: MillingConfig) -> Result<Self, PlantError> {
        config.validate()?;
        let shapes = config.shaped_modes();
        for s in &shapes {
            s.validate()?;
        }
        let per_tooth = (config.min_step_rate_hz / (config.slowest_hz() * config.teeth as f64)
            - 1e-9)
            .ceil()
            .max(4.0) as usize;
        let count = per_tooth * config.teeth;
        let spindle_hz = config.spindle_at(0.0);
        let dt = 1.0 / (spindle_hz * count as f64);
        let cell = TAU / count as f64;
        let cells: Vec<Cell> = (0..count)
            .map(|i| {
                let angle = cell * i as f64;
                let (sin, cos) = angle.sin_cos();
                Cell {
                    sin,
                    cos,
                    weight: config.engagement.weight(angle, cell),
                }
            })
            .collect();
        let deepest = config.depth.largest();
        let lag = config.helix_lag_rad(deepest);
        let slices = ((lag / SLICE_RAD).ceil() as usize).clamp(1, MOST_SLICES);
        let slice_lag: Vec<usize> = (0..slices)
            .map(|l| {
                let middle = lag * (l as f64 + 0.5) / slices as f64;
                if lag > 0.0 {
                    (middle / cell).round() as usize % count
                } else {
                    0
                }
            })
            .collect();
        let mut runout = config.runout_m.clone();
        runout.resize(config.teeth, 0.0);
        let noisy = config.noise.relative > 0.0 || config.noise.background_n > 0.0;
        let swinging = config.variation.map(|_| {
            let step_s = |hz: f64| 1.0 / (hz * count as f64);
            let (least, most) = (step_s(config.fastest_hz()), step_s(config.slowest_hz()));
            let table = |s: &ShapedMode| StepTable::new(&s.mode, least, most);
            (0.0, shapes.iter().map(table).collect())
        });
        let mut out = Self {
            tooth_cell: tooth_cells(&config, count)?,
            modes: shapes.into_iter().map(|s| Moving::new(s, dt)).collect(),
            feed_ahead: config.feed_ahead_m_per_rad(),
            dt,
            spindle_hz,
            surface: vec![f64::NEG_INFINITY; slices * count],
            cells,
            slice_m: deepest / slices as f64,
            slice_lag,
            runout,
            noise: noisy.then(|| SmoothNoise::new(config.noise.bandwidth_hz, dt, config.seed)),
            feed_per_step: config.feed_per_tooth_m / per_tooth as f64,
            index: 0,
            since: (0, 0.0),
            told_hz: None,
            carrier_hz: spindle_hz,
            swinging,
            config,
        };
        out.lay_first_surface();
        Ok(out)
    }

    /// Step length now, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Steps per second now, Hz.
    #[must_use]
    pub fn step_rate_hz(&self) -> f64 {
        self.spindle_hz * self.cells.len() as f64
    }

    /// Steps per second at the highest speed there will be, Hz.
    #[must_use]
    pub fn fastest_step_rate_hz(&self) -> f64 {
        self.config.fastest_hz() * self.cells.len() as f64
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

    /// Sets mode `index` of those along `axis` (0 = x, 1 = y, 2 = others) to
    /// displacement m and velocity m/s: a disturbance to watch grow or decay.
    /// A mode that is not there is ignored, so that a rigid direction stays rigid.
    pub fn disturb(&mut self, axis: usize, index: usize, q: f64, v: f64) {
        let (x, y) = (self.config.modes_x.len(), self.config.modes_y.len());
        let (from, count) = match axis {
            0 => (0, x),
            1 => (x, y),
            _ => (x + y, self.config.modes_other.len()),
        };
        if index < count {
            self.modes[from + index].state = [q, v];
        }
    }

    /// Angle of tooth `j` at the latest step, rad, from +y clockwise, 0 to 2π.
    #[must_use]
    pub fn tooth_angle_rad(&self, j: usize) -> f64 {
        let count = self.cells.len();
        let turn = (self.index % count as u64) as usize;
        TAU * wrap(self.tooth_cell[j] + turn, count) as f64 / count as f64
    }

    /// Advances by one step and returns the state after it.
    pub fn step(&mut self) -> MillSample {
        let count = self.cells.len() as u64;
        if self.config.speed.is_some() && self.index.is_multiple_of(count) {
            self.change_speed();
        }
        self.index += 1;
        let t = self.advance_time();
        let now = self.now(t, (self.index % count) as usize);
        let mut predicted = Motion::default();
        for m in &self.modes {
            predicted.add(&m.shape, m.step.advance(m.state, m.load, m.load));
        }
        // The teeth of a rigid tool do not move, whatever the machine does.
        let rigid = (self.config.contact == Contact::Rigid).then(Motion::default);
        let (force, _) = self.cut::<false>(rigid.as_ref().unwrap_or(&predicted), &now);
        let mut motion = Motion::default();
        for m in &mut self.modes {
            m.state = m.step.advance(m.state, m.load, m.generalised(force));
            motion.add(&m.shape, m.state);
        }
        let (force, chip) = self.cut::<true>(rigid.as_ref().unwrap_or(&motion), &now);
        let mut acceleration = [0.0; 2];
        let mut sensor = [[0.0; 2]; 3];
        for m in &mut self.modes {
            m.load = m.generalised(force);
            let a = m.load * m.law[0] - m.law[1] * m.state[1] - m.law[2] * m.state[0];
            acceleration[0] += m.shape.x * a;
            acceleration[1] += m.shape.y * a;
            let (x, y) = (m.shape.at_sensor * m.shape.x, m.shape.at_sensor * m.shape.y);
            for (sum, value) in sensor.iter_mut().zip([m.state[0], m.state[1], a]) {
                sum[0] += x * value;
                sum[1] += y * value;
            }
        }
        MillSample {
            t,
            position_m: motion.q,
            velocity_m_s: motion.v,
            acceleration_m_s2: acceleration,
            sensor,
            force_n: [force[0], force[1]],
            depth_m: now.depth,
            chip_m: chip,
            spindle_hz: self.spindle_hz,
            feed_m: now.feed,
        }
    }

    /// From the next revolution on the spindle turns at this, Hz, whatever its schedule says,
    /// within the slowest and the fastest of it; without a schedule it is passed over.
    pub fn turn(&mut self, spindle_hz: f64) {
        let (slowest, fastest) = self.config.carriers_hz();
        self.told_hz = Some(spindle_hz.clamp(slowest, fastest));
    }

    /// Takes on the speed for the revolution that begins.
    fn change_speed(&mut self) {
        let t = match &self.swinging {
            Some((now_s, _)) => *now_s,
            None => self.since.1 + (self.index - self.since.0) as f64 * self.dt,
        };
        let wanted = self.told_hz.unwrap_or_else(|| self.config.carrier_at(t));
        if wanted == self.carrier_hz {
            return;
        }
        self.carrier_hz = wanted;
        if self.swinging.is_some() {
            return;
        }
        self.since = (self.index, t);
        self.spindle_hz = wanted;
        self.dt = 1.0 / (wanted * self.cells.len() as f64);
        for m in &mut self.modes {
            m.step = FohStep::new(&m.shape.mode, self.dt);
        }
        if let Some(noise) = &mut self.noise {
            noise.retime(self.config.noise.bandwidth_hz, self.dt);
        }
    }

    /// The time after one more step, s, whose length follows the speed where that swings.
    fn advance_time(&mut self) -> f64 {
        let (Some(variation), Some((now_s, tables))) = (&self.config.variation, &mut self.swinging)
        else {
            return self.since.1 + (self.index - self.since.0) as f64 * self.dt;
        };
        let turns = 1.0 / self.cells.len() as f64;
        let swing_hz = variation.frequency_hz(self.config.spindle_hz);
        self.dt = variation.time_for_s(self.carrier_hz, swing_hz, *now_s, turns);
        *now_s += self.dt;
        self.spindle_hz = turns / self.dt;
        for (m, table) in self.modes.iter_mut().zip(tables) {
            m.step = table.at(self.dt);
        }
        if let Some(noise) = &mut self.noise {
            noise.retime(self.config.noise.bandwidth_hz, self.dt);
        }
        *now_s
    }

    fn now(&mut self, t: f64, turn: usize) -> Now {
        let noise = self.noise.as_mut().map_or([0.0; 4], SmoothNoise::advance);
        let c = &self.config;
        let worn = 1.0 + c.wear.cutting_per_s * t;
        let rubbed = if c.contact == Contact::Linear {
            0.0
        } else {
            1.0 + c.wear.edge_per_s * t
        };
        Now {
            turn,
            feed: self.feed_per_step * self.index as f64,
            depth: c.depth.at(t),
            kt: c.kt_n_per_m2 * worn,
            kn: c.kn_n_per_m2 * worn,
            edge: [c.kt_edge_n_per_m * rubbed, c.kn_edge_n_per_m * rubbed],
            rub: c
                .process_damping
                .map(|p| (p.per_speed(self.spindle_hz), p.friction)),
            factor: [
                1.0 + c.noise.relative * noise[0],
                1.0 + c.noise.relative * noise[1],
            ],
            background: [
                c.noise.background_n * noise[2],
                c.noise.background_n * noise[3],
            ],
        }
    }

    /// Force and moment on the tool, and the largest chip, for this motion. Leaves
    /// the surface behind if `WRITE`.
    fn cut<const WRITE: bool>(&mut self, m: &Motion, now: &Now) -> ([f64; 3], f64) {
        let count = self.cells.len();
        let linear = self.config.contact == Contact::Linear;
        let radius = 0.5 * self.config.diameter_m;
        let x = m.q[0] + now.feed - self.feed_ahead * m.turn;
        let mut force = [now.background[0], now.background[1], 0.0];
        let mut chip = 0.0_f64;
        for (slice, lag) in self.slice_lag.iter().enumerate() {
            let b = (now.depth - slice as f64 * self.slice_m).min(self.slice_m);
            let row = &mut self.surface[slice * count..(slice + 1) * count];
            for (start, runout) in self.tooth_cell.iter().zip(&self.runout) {
                let place = wrap(wrap(start + now.turn, count) + count - lag, count);
                let cell = &self.cells[place];
                if cell.weight <= 0.0 {
                    continue;
                }
                let tip = x * cell.sin + m.q[1] * cell.cos + runout;
                let h = tip - row[place];
                if WRITE && (h > 0.0 || linear) {
                    row[place] = tip;
                }
                if b <= 0.0 || (h <= 0.0 && !linear) {
                    continue;
                }
                if let Some(piece) = &self.config.workpiece
                    && !piece.holds(now.feed + radius * cell.sin, radius * cell.cos)
                {
                    continue;
                }
                chip = chip.max(h);
                let mut tangential = now.kt * h + now.edge[0];
                let mut radial = now.kn * h + now.edge[1];
                if let Some((c_over_v, friction)) = now.rub {
                    let rub = c_over_v * (m.v[0] * cell.sin + m.v[1] * cell.cos);
                    radial += rub;
                    tangential += friction * rub;
                }
                tangential *= b * cell.weight * now.factor[0];
                radial *= b * cell.weight * now.factor[1];
                force[0] -= tangential * cell.cos + radial * cell.sin;
                force[1] += tangential * cell.sin - radial * cell.cos;
                force[2] -= tangential * radius;
            }
        }
        (force, chip)
    }

    /// The surface one revolution before time 0 would have left, tool at rest.
    fn lay_first_surface(&mut self) {
        let count = self.cells.len();
        for back in (0..count).rev() {
            let turn = (count - back) % count;
            let x = -(back as f64) * self.feed_per_step;
            for (slice, lag) in self.slice_lag.iter().enumerate() {
                for (start, runout) in self.tooth_cell.iter().zip(&self.runout) {
                    let place = wrap(wrap(start + turn, count) + count - lag, count);
                    let tip = x * self.cells[place].sin + runout;
                    let left = &mut self.surface[slice * count + place];
                    if tip > *left || self.config.contact == Contact::Linear {
                        *left = tip;
                    }
                }
            }
        }
    }
}

#[inline]
fn wrap(index: usize, count: usize) -> usize {
    if index >= count { index - count } else { index }
}

#[cfg(test)]
#[path = "milling_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "milling_general_tests.rs"]
mod general_tests;
