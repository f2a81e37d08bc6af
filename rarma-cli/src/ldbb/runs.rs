//! Runs as they are evaluated, wherever they come from.

use hal_sim::plant::ldbb::drive::Recorded;
use rarma_rigs::ldbb::{AngleMap, ForceLaw, Held, Sense};

/// Runs of a table without set pressures whose forces are nearer than this are at one step, N.
const SAME_N: f64 = 10.0;

/// Set pressures nearer than this are the same, Pa: the digits of a table.
const SAME_SET_PA: f64 = 1.0;

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

    /// Whether both were made at one step of the load: on one way, at one set pressure. Where
    /// that is not told, as near as a regulator sets them, or as the way of a force that goes
    /// on from run to run.
    fn is_level_with(&self, other: &Self) -> bool {
        if self.rising != other.rising {
            return false;
        }
        if let (Some(a), Some(b)) = (self.set_pa, other.set_pa) {
            return (a - b).abs() < SAME_SET_PA;
        }
        let way = 0.5 * (self.creep_n().abs() + other.creep_n().abs());
        (self.force_n - other.force_n).abs() < SAME_N + 1.5 * way
    }
}

/// Runs by steps of the load: those of a step together, in the order they were made; the steps
/// in the order of their first runs.
pub fn steps<'a>(runs: impl IntoIterator<Item = &'a RunData>) -> Vec<Vec<&'a RunData>> {
    let mut out: Vec<Vec<&RunData>> = Vec::new();
    for run in runs {
        // The last run of a step is the nearest to one that goes on from it.
        let level = |step: &&mut Vec<&RunData>| step.last().is_some_and(|r| r.is_level_with(run));
        match out.iter_mut().rev().find(level) {
            Some(step) => step.push(run),
            None => out.push(vec![run]),
        }
    }
    out
}

/// Either every step was run both ways, or none was; else the run that stands alone.
pub fn without_its_other(runs: &[RunData]) -> Option<&RunData> {
    let both = [Sense::Ccw, Sense::Cw];
    if !both.iter().all(|s| runs.iter().any(|r| r.sense == *s)) {
        return None;
    }
    let lone = |step: &Vec<&RunData>| !both.iter().all(|s| step.iter().any(|r| r.sense == *s));
    steps(runs).into_iter().find(lone).map(|step| step[0])
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

/// A recorded run, cut to its capture.
pub fn from_recorded(
    recorded: &Recorded,
    law: &ForceLaw<f64>,
    overshoot_rad: f64,
    inclination_rad: f64,
) -> RunData {
    let done = &recorded.done;
    let map = AngleMap {
        start_rad: f64::from(done.map.start_rad),
        sweep_rad: f64::from(done.map.sweep_rad),
        sense: done.map.sense,
        from_s: f64::from(done.map.from_s),
        to_s: f64::from(done.map.to_s),
    };
    let cos = inclination_rad.cos();
    let captured = recorded
        .points
        .iter()
        .filter_map(|p| Some((map.captured(p.t_s, overshoot_rad)?, p)));
    let (mut points, mut forces_n, mut pressure_pa) = (Vec::new(), Vec::new(), 0.0);
    for (theta, p) in captured {
        points.push((theta, p.gauge_m / cos));
        forces_n.push(law.force_n(p.pressure_pa) * cos);
        pressure_pa += p.pressure_pa;
    }
    pressure_pa /= points.len().max(1) as f64;
    RunData {
        number: u32::from(done.run.number),
        sense: done.run.sense,
        rising: done.run.rising,
        set_pa: Some(f64::from(done.run.pressure_pa)),
        pressure_pa,
        force_n: law.force_n(pressure_pa) * cos,
        points,
        forces_n,
    }
}
