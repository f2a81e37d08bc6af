//! Runs as they are evaluated, wherever they come from.

use rarma_plants::ldbb::drive::Recorded;
use rarma_recordings::input::RunData;
use rarma_rigs::ldbb::{AngleMap, ForceLaw, Sense};

/// Runs of a table without set pressures whose forces are nearer than this are at one step, N.
const SAME_N: f64 = 10.0;

/// Set pressures nearer than this are the same, Pa: the digits of a table.
const SAME_SET_PA: f64 = 1.0;

/// Whether both were made at one step of the load: on one way, at one set pressure. Where
/// that is not told, as near as a regulator sets them, or as the way of a force that goes
/// on from run to run.
fn are_level(one: &RunData, other: &RunData) -> bool {
    if one.rising != other.rising {
        return false;
    }
    if let (Some(a), Some(b)) = (one.set_pa, other.set_pa) {
        return (a - b).abs() < SAME_SET_PA;
    }
    let way = 0.5 * (one.creep_n().abs() + other.creep_n().abs());
    (one.force_n - other.force_n).abs() < SAME_N + 1.5 * way
}

/// Runs by steps of the load: those of a step together, in the order they were made; the steps
/// in the order of their first runs.
pub fn steps<'a>(runs: impl IntoIterator<Item = &'a RunData>) -> Vec<Vec<&'a RunData>> {
    let mut out: Vec<Vec<&RunData>> = Vec::new();
    for run in runs {
        // The last run of a step is the nearest to one that goes on from it.
        let level = |step: &&mut Vec<&RunData>| step.last().is_some_and(|r| are_level(r, run));
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
