//! What moves in milling: modes on their way, the tool they carry, where the teeth
//! start, and what is seen of it all.

use super::error::{PlantError, require};
use super::milling_config::MillingConfig;
use super::modal::{FohStep, ShapedMode};
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
    /// Displacement, velocity and acceleration of the place of the sensor in x and y, m,
    /// m/s, m/s²: that of the tool unless a mode says otherwise.
    pub sensor: [[f64; 2]; 3],
    /// Force on the tool in x and y, N, background noise included.
    pub force_n: [f64; 2],
    /// Axial depth, m.
    pub depth_m: f64,
    /// Largest chip thickness over the teeth in the arc, m; 0 out of contact.
    pub chip_m: f64,
    /// Spindle frequency, Hz.
    pub spindle_hz: f64,
    /// How far the cutter has been fed, m.
    pub feed_m: f64,
}

/// A mode on its way: shape, step, constants of its equation, state and load.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub shape: ShapedMode,
    pub step: FohStep,
    /// 1/m, 2ζω, ω².
    pub law: [f64; 3],
    pub state: [f64; 2],
    pub load: f64,
}

impl Moving {
    pub(super) fn new(shape: ShapedMode, dt: f64) -> Self {
        let (m, w) = (&shape.mode, shape.mode.omega());
        Self {
            step: FohStep::new(m, dt),
            law: [1.0 / m.mass_kg(), 2.0 * m.zeta * w, w * w],
            shape,
            state: [0.0; 2],
            load: 0.0,
        }
    }

    #[inline]
    pub(super) fn generalised(&self, force: [f64; 3]) -> f64 {
        self.shape.x * force[0] + self.shape.y * force[1] + self.shape.turn_rad_per_m * force[2]
    }
}

/// Motion of the tool, as the teeth see it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    pub q: [f64; 2],
    pub v: [f64; 2],
    pub turn: f64,
}

impl Motion {
    #[inline]
    pub(super) fn add(&mut self, shape: &ShapedMode, [q, v]: [f64; 2]) {
        self.q[0] += shape.x * q;
        self.q[1] += shape.y * q;
        self.v[0] += shape.x * v;
        self.v[1] += shape.y * v;
        self.turn += shape.turn_rad_per_m * q;
    }
}

/// Cell of each tooth at time 0: tooth j trails tooth 0 by the pitches before it.
pub(super) fn tooth_cells(config: &MillingConfig, count: usize) -> Result<Vec<usize>, PlantError> {
    let cell = TAU / count as f64;
    let mut angle = 0.0;
    let mut cells = Vec::with_capacity(config.teeth);
    for j in 0..config.teeth {
        let lag = (angle / cell).round() as usize % count;
        cells.push((count - lag) % count);
        angle += config
            .pitch_rad
            .get(j)
            .copied()
            .unwrap_or(TAU / config.teeth as f64);
    }
    let mut sorted = cells.clone();
    sorted.sort_unstable();
    require(sorted.windows(2).all(|w| w[0] != w[1]), "pitch_rad")?;
    Ok(cells)
}
