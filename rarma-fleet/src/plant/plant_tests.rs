//! The plant is what it says it is.

use super::*;
use crate::record::{Kind, to_line};
use std::collections::HashSet;

fn config(machines: usize, days: u32, fate: Fate) -> PlantConfig {
    let start = "2025-01-01T00:00:00Z".parse().unwrap();
    PlantConfig {
        machines,
        days,
        start,
        seed: 5,
        fate,
        tests_only: false,
    }
}

fn all(plant: &mut Plant) -> Vec<Record> {
    std::iter::from_fn(|| plant.next_day()).flatten().collect()
}

#[test]
fn the_same_seed_gives_the_same_plant_and_another_another() {
    let lines = |seed| {
        let config = PlantConfig {
            seed,
            ..config(2, 40, Fate::Usual)
        };
        all(&mut Plant::new(config))
            .iter()
            .map(|r| to_line(r).unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(lines(5), lines(5));
    assert_ne!(lines(5), lines(6));
}

#[test]
fn records_are_right_named_once_and_come_late_and_twice() {
    let mut plant = Plant::new(config(4, 200, Fate::Usual));
    let records = all(&mut plant);
    let names: HashSet<_> = records.iter().map(|r| &r.id).collect();
    let twice = records.len() - names.len();
    assert!(records.iter().all(|r| r.check().is_ok()));
    // One in a thousand, of some 45 000.
    assert!((10..100).contains(&twice), "{twice} of {}", records.len());
    let late = records
        .windows(2)
        .filter(|w| w[1].time.since_s(w[0].time) < -86_400.0)
        .count();
    assert!(late > 0, "nothing out of order");
    for kind in Kind::ALL {
        assert!(
            records.iter().any(|r| r.body.kind() == kind),
            "{kind:?} is missing"
        );
    }
}

#[test]
fn an_outcome_speaks_of_an_advice_and_that_of_an_alarm() {
    let records = all(&mut Plant::new(config(1, 60, Fate::Usual)));
    let kind_of = |record: &Record, seq: u64| {
        let named = |r: &&Record| {
            r.id.session == record.id.session && r.id.seq == seq && r.id.sender == record.id.sender
        };
        records.iter().find(named).map(|r| r.body.kind())
    };
    let mut seen = 0;
    for record in &records {
        match &record.body {
            crate::record::Body::Outcome(o) => {
                assert_eq!(kind_of(record, o.advice), Some(Kind::Advice));
                seen += 1;
            }
            crate::record::Body::AlarmReleased(a) => {
                assert_eq!(kind_of(record, a.called), Some(Kind::AlarmCalled));
            }
            _ => {}
        }
    }
    assert!(seen > 10, "{seen}");
}

#[test]
fn a_loss_takes_that_part_of_the_stiffness_in_its_direction_only() {
    let plant = Plant::new(config(
        1,
        100,
        Fate::Loss {
            day: 50.0,
            part: 0.05,
        },
    ));
    let cell = &plant.cells[0];
    let life::What::Crash { direction_deg, .. } = cell.life.events[0].what else {
        panic!()
    };
    let stiffness =
        |day: f64, deg: f64| 1.0 / cell.life.at(&cell.drawn, day).plane.along(deg.to_radians());
    let ratio = |deg| stiffness(50.0, deg) / stiffness(49.999, deg);
    assert!(
        (ratio(direction_deg) - 0.95).abs() < 1e-4,
        "{}",
        ratio(direction_deg)
    );
    assert!((ratio(direction_deg + 90.0) - 1.0).abs() < 1e-4);
}

#[test]
fn a_joint_that_wears_and_a_knock_change_what_they_say_and_nothing_else() {
    let at = |plant: &Plant, day: f64| {
        let cell = &plant.cells[0];
        // Without the season, which is the same on both days but for a little.
        let mut now = cell.life.at(&cell.drawn, day);
        now.geometry.warmer(-cell.life.warmer_k(day));
        now.geometry
    };
    let joint = Plant::new(config(
        1,
        200,
        Fate::Joint {
            day: 50.0,
            over: 100.0,
            part: 0.4,
            backlash_um: 0.8,
        },
    ));
    let life::What::Joint { axis, .. } = joint.cells[0].life.events[0].what else {
        panic!()
    };
    let (before, half, after) = (at(&joint, 49.0), at(&joint, 100.0), at(&joint, 180.0));
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(near(half.loop_um, 1.2 * before.loop_um) && near(after.loop_um, 1.4 * before.loop_um));
    assert!(near(half.backlash_um[axis], before.backlash_um[axis] + 0.4));
    assert!(near(
        after.backlash_um[axis],
        before.backlash_um[axis] + 0.8
    ));
    assert!(near(
        after.backlash_um[1 - axis],
        before.backlash_um[1 - axis]
    ));
    assert!(near(after.squareness_urad, before.squareness_urad));

    let knock = Plant::new(config(
        1,
        100,
        Fate::Knock {
            day: 50.0,
            squareness_urad: 10.0,
        },
    ));
    let (before, after) = (at(&knock, 49.0), at(&knock, 50.0));
    assert!(near(
        (after.squareness_urad - before.squareness_urad).abs(),
        10.0
    ));
    assert!(near(after.loop_um, before.loop_um));
    assert_eq!(after.backlash_um, before.backlash_um);
    let plane = |day: f64| {
        knock.cells[0]
            .life
            .at(&knock.cells[0].drawn, day)
            .plane
            .along(1.0)
    };
    assert!((plane(50.0) / plane(49.999) - 1.0).abs() < 1e-6);
}
