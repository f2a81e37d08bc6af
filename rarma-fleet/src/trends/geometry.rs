//! Loops and errors of a machine, test by test.

use super::series::{Series, SeriesKind, by_test, series, tensor, test};
use crate::record::Quantity;
use crate::store::MachineReading;
use std::collections::{BTreeMap, HashSet};

/// Loops that are narrower in the mean are not compared, µm. The rig leaves 0.01 to 0.05 µm of a mean loop open:
/// of 0.3 µm a tenth, more than tests of a wide loop differ by. With half of it small loops could change by their noise;
/// with double of it a good machine (0.5 µm) is not looked at.
const LEAST_LOOP_UM: f64 = 0.3;

/// Errors are compared at the smallest force of a test, which must be this near to what it is in most tests, N: errors
/// grow with load, 10 µrad/kN on `ldbb-m5`. 25 N are 0.25 µrad then, a sixth of what tests differ by; double of it a third;
/// half of it would leave out tests whose pressure was set by hand.
const NEAR_N: f64 = 25.0;

/// Loops of a plane: ln of their mean over all directions, of the fit that has it as the first number (five directions at
/// least: a mean over other directions would be another one).
pub(super) fn loops(readings: &[MachineReading]) -> Option<Series> {
    let tests: Vec<_> = (by_test(readings).iter())
        .filter_map(|rays| {
            let mean = tensor(rays)?[0];
            (mean >= LEAST_LOOP_UM).then(|| test(rays[0], [mean.ln(), 0.0, 0.0]))
        })
        .collect();
    (!tests.is_empty()).then(|| series(readings, SeriesKind::Hysteresis, 0.0, tests))
}

/// What an error is called in a record, without the number of its axis, and what it becomes. Not the centre: it says where
/// the balls stood (11 to 16 µm from test to test on the rig). Not the cyclic error: few look for it.
const NAMES: [(&str, SeriesKind); 6] = [
    ("scale_mismatch_um", SeriesKind::ScaleMismatch),
    ("squareness_urad", SeriesKind::Squareness),
    ("straightness_um", SeriesKind::Straightness),
    ("backlash_um", SeriesKind::Backlash),
    ("lateral_play_um", SeriesKind::LateralPlay),
    (SERVO, SeriesKind::ServoMismatch),
];
const SERVO: &str = "servo_mismatch_ms";

/// Series of all errors of a machine.
pub(super) fn errors(readings: &[MachineReading]) -> Vec<Series> {
    let errors = || readings.iter().filter(|r| r.quantity == Quantity::Error);
    // A test in one direction has no servo mismatch: it is in the squareness there.
    let both_ways: HashSet<(&str, &Key)> = errors()
        .filter_map(|r| {
            let (plane, name) = r.place.split_once(' ')?;
            (name == SERVO).then_some((plane, &r.id))
        })
        .collect();
    let mut places: BTreeMap<&str, Vec<MachineReading>> = BTreeMap::new();
    for reading in errors() {
        places
            .entry(&reading.place)
            .or_default()
            .push(reading.clone());
    }
    let mut all = Vec::new();
    for (place, of_place) in places {
        let Some((plane, name)) = place.split_once(' ') else {
            continue;
        };
        let base = name.split('.').next().unwrap_or(name);
        let Some(&(_, kind)) = NAMES.iter().find(|n| n.0 == base) else {
            continue;
        };
        let smallest: Vec<&MachineReading> = (by_test(&of_place).iter())
            .filter_map(|of_test| {
                of_test
                    .iter()
                    .min_by(|a, b| a.at.abs().total_cmp(&b.at.abs()))
            })
            .copied()
            .filter(|r| kind != SeriesKind::Squareness || both_ways.contains(&(plane, &r.id)))
            .collect();
        let mut forces: Vec<f64> = smallest.iter().map(|r| r.at).collect();
        forces.sort_by(f64::total_cmp);
        let Some(&usual) = forces.get(forces.len() / 2) else {
            continue;
        };
        let tests: Vec<_> = (smallest.iter())
            .filter(|r| (r.at - usual).abs() <= NEAR_N)
            .map(|r| test(r, [r.value, 0.0, 0.0]))
            .collect();
        all.push(series(&of_place, kind, usual, tests));
    }
    all
}

/// The name of a record in a store.
type Key = (String, i64, i64);

#[cfg(test)]
#[path = "geometry_tests.rs"]
mod tests;
