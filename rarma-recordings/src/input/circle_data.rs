//! Readings of a ball bar as they are evaluated, wherever they come from.

use rarma_rigs::ldbb::{ForceLaw, Held, Sense};

/// Under which conditions a test was made; the same for all its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// The machine's name.
    pub machine: String,
    /// Plane: `XY`, `YZ` or `ZX`; θ runs from the first axis towards the second.
    pub plane: String,
    /// Radius of the circle, m.
    pub radius_m: f64,
    /// Programmed feed, m/s.
    pub feed_m_s: f64,
    /// Inclination of the bar above the plane, rad.
    pub inclination_rad: f64,
}

impl Conditions {
    /// Names of the two axes.
    pub fn axes(&self) -> [&'static str; 2] {
        match self.plane.as_str() {
            "YZ" => ["Y", "Z"],
            "ZX" => ["Z", "X"],
            _ => ["X", "Y"],
        }
    }
}

/// One run: captured readings in the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct RunData {
    /// Number, from 0.
    pub number: u32,
    /// Direction.
    pub sense: Sense,
    /// On the way up, or down.
    pub rising: bool,
    /// Pressure that was asked for at this step, Pa; none where a table does not tell it.
    pub set_pa: Option<f64>,
    /// Mean pressure, Pa.
    pub pressure_pa: f64,
    /// Force in the plane, N: mean of the run.
    pub force_n: f64,
    /// Angle, rad, and length change in the plane, m.
    pub points: Vec<(f64, f64)>,
    /// Force in the plane at every point, N; empty where it stays.
    pub forces_n: Vec<f64>,
}

impl RunData {
    /// How far the force goes on within the run, N: last third less first.
    pub fn creep_n(&self) -> f64 {
        let third = self.forces_n.len() / 3;
        if third == 0 {
            return 0.0;
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / third as f64;
        // Middles of the outer thirds are two thirds of the run apart.
        1.5 * (mean(&self.forces_n[self.forces_n.len() - third..]) - mean(&self.forces_n[..third]))
    }
}

/// One reading of the static test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Static {
    /// Direction, rad.
    pub angle_rad: f64,
    /// On the way up, or down.
    pub rising: bool,
    /// Mean pressure, Pa.
    pub pressure_pa: f64,
    /// Force in the plane, N.
    pub force_n: f64,
    /// Length change in the plane, m.
    pub dr_m: f64,
}

impl Static {
    /// From a reading of the sequence.
    pub fn new(held: &Held, angle_rad: f64, law: &ForceLaw<f64>, inclination_rad: f64) -> Self {
        let cos = inclination_rad.cos();
        let pressure_pa = f64::from(held.pressure_pa);
        Self {
            angle_rad,
            rising: held.run.rising,
            pressure_pa,
            force_n: law.force_n(pressure_pa) * cos,
            dr_m: f64::from(held.gauge_m) / cos,
        }
    }
}
