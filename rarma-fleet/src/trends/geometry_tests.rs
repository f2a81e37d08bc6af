//! Which tests of loops and errors are compared with each other.

use super::*;
use crate::record::Utc;
use crate::trends::gathered;

fn reading(day: i64, quantity: Quantity, place: &str, at: f64, value: f64) -> MachineReading {
    let start: Utc = "2026-01-01T00:00:00Z".parse().unwrap();
    MachineReading {
        machine: "M".to_owned(),
        quantity,
        place: place.to_owned(),
        at,
        time: start.plus_s(86_400.0 * day as f64),
        id: ("bar".to_owned(), day, 0),
        tool: None,
        operator: None,
        value,
        sd: 0.0,
    }
}

fn sorted(mut all: Vec<MachineReading>) -> Vec<MachineReading> {
    all.sort_by(|a, b| {
        (&a.place, a.quantity, a.time)
            .cmp(&(&b.place, b.quantity, b.time))
            .then(a.at.total_cmp(&b.at))
    });
    all
}

fn of(kind: SeriesKind, all: Vec<MachineReading>) -> Vec<Series> {
    let mut found = gathered(&sorted(all));
    found.retain(|s| s.kind == kind);
    found
}

#[test]
fn an_error_is_that_at_the_smallest_force_and_at_the_usual_one() {
    let mut all = Vec::new();
    for day in 0..6 {
        // The third test began at a larger force: another error.
        let least = if day == 2 { 200.0 } else { 50.0 + day as f64 };
        for force in [least, 800.0] {
            all.push(reading(
                day,
                Quantity::Error,
                "XY backlash_um.1",
                force,
                force / 100.0,
            ));
        }
    }
    let found = of(SeriesKind::Backlash, all);
    assert_eq!(found.len(), 1);
    let values: Vec<f64> = found[0].tests.iter().map(|t| t.y[0]).collect();
    assert_eq!(values, [0.50, 0.51, 0.53, 0.54, 0.55]);
    assert_eq!(found[0].place, "XY backlash_um.1");
}

#[test]
fn a_squareness_that_holds_the_servo_mismatch_is_not_compared() {
    let mut all = Vec::new();
    for day in 0..6 {
        all.push(reading(
            day,
            Quantity::Error,
            "XY squareness_urad",
            50.0,
            20.0,
        ));
        // Of the last test there is one direction only.
        if day < 5 {
            all.push(reading(
                day,
                Quantity::Error,
                "XY servo_mismatch_ms",
                50.0,
                0.2,
            ));
        }
        all.push(reading(day, Quantity::Error, "XY centre_um.0", 50.0, 1.0));
        all.push(reading(
            day,
            Quantity::Error,
            "XY of_a_later_version",
            50.0,
            1.0,
        ));
    }
    let found = gathered(&sorted(all));
    let kinds: Vec<(SeriesKind, usize)> = found.iter().map(|s| (s.kind, s.tests.len())).collect();
    assert_eq!(
        kinds,
        [(SeriesKind::Squareness, 5), (SeriesKind::ServoMismatch, 5)]
    );
}

#[test]
fn loops_are_their_mean_over_all_directions_whichever_were_run() {
    let loops = |directions: &[f64], mean: f64| {
        let mut all = Vec::new();
        for day in 0..5 {
            for &at in directions {
                let um = mean * (1.0 + 0.3 * (2.0 * at.to_radians()).cos());
                all.push(reading(day, Quantity::Hysteresis, "XY", at, um));
            }
        }
        of(SeriesKind::Hysteresis, all)
    };
    for directions in [
        vec![0.0, 30.0, 60.0, 90.0, 120.0, 150.0],
        // More of them where loops are wide: the plain mean would be 5.2.
        vec![0.0, 10.0, 20.0, 170.0, 60.0, 120.0, 350.0],
    ] {
        let found = loops(&directions, 4.5);
        assert!((found[0].tests[0].y[0].exp() / 4.5 - 1.0).abs() < 1e-9);
    }
    // Four do not tell the mean from the wave; small loops are not told from noise.
    assert!(loops(&[0.0, 90.0, 180.0, 270.0], 4.5).is_empty());
    assert!(loops(&[0.0, 30.0, 60.0, 90.0, 120.0, 150.0], 0.29).is_empty());
    assert_eq!(loops(&[0.0, 30.0, 60.0, 90.0, 120.0, 150.0], 0.31).len(), 1);
}
