//! Promise: a machine's hysteresis is found through the box: standing by its own static test,
//! with the stiffness of four directions, and moving by a circle test that comes down again.
//!
//! `cargo test --release -p host-tests --test ldbb_box_hysteresis -- --nocapture`

use host_tests::bars::{all_judged, holds};
use host_tests::ldbb::m3;
use host_tests::ldbb_box::{job, ready, run};
use host_tests::rig::answer;
use rarma_box::guard::{Denial, Stage};
use rarma_box::wire::{Answer, CircleMessage, Command, Refused, StandJob, Telemetry};
use rarma_plants::ldbb::Around;

/// The static test by the box: figure 17's hysteresis, table 2's stiffness, four directions.
#[test]
fn static_test() {
    let mut bench = m3();
    bench.machine.hysteresis_m = Around {
        mean: 4.5e-6,
        waves: [(1.5e-6, 0.0), (0.0, 0.0), (0.0, 0.0)],
    };
    bench.machine.standing = Around::constant(0.05);
    let mut all = ready(bench, Vec::new());
    let mut pressures_pa = [0.0; 8];
    for (k, p) in pressures_pa.iter_mut().enumerate() {
        *p = if k == 0 { 4e4 } else { 1e5 * k as f32 };
    }
    let stand = StandJob {
        pressures_pa,
        directions: 4,
    };
    let to = all.send(&Command::Go);
    all.run_for(0.1);
    let not_now = Answer::Refused(Refused::Denied(Denial::NotReady));
    assert_eq!(answer(&all, to), Some(not_now), "nothing waits for it");
    for bad in [
        StandJob {
            directions: 0,
            ..stand
        },
        StandJob {
            pressures_pa: [8e5; 8],
            ..stand
        },
        StandJob {
            pressures_pa: [2e4, 1e5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            ..stand
        },
    ] {
        let to = all.send(&Command::Stand(bad));
        all.run_for(0.1);
        let refused = Answer::Refused(Refused::Denied(Denial::Limit));
        assert_eq!(answer(&all, to), Some(refused), "{bad:?}");
    }
    let to = all.send(&Command::Stand(stand));
    all.run_for(0.02);
    assert_eq!(answer(&all, to), Some(Answer::Done));
    let (mut held, mut cycles) = (0, Vec::new());
    let until_us = all.rig.world_us() + 1_200_000_000;
    while cycles.len() < 4 && all.rig.world_us() < until_us {
        all.step();
        for heard in std::mem::take(&mut all.host.heard) {
            match heard.message {
                Telemetry::Circle(CircleMessage::Go { direction }) => {
                    let theta = f64::from(direction) * std::f64::consts::FRAC_PI_2;
                    all.rig.bar_mut().expect("a machine").stand(theta);
                    all.send(&Command::Go);
                }
                Telemetry::Circle(CircleMessage::Held { step, rising, .. }) => {
                    assert_eq!(rising, step < 8);
                    held += 1;
                }
                Telemetry::Circle(found @ CircleMessage::Cycle { .. }) => cycles.push(found),
                Telemetry::Circle(CircleMessage::Failed { why, .. }) => panic!("{why:?}"),
                Telemetry::Fault(f) => panic!("{f:?}"),
                _ => {}
            }
        }
    }
    assert_eq!(held, 60);
    for (k, cycle) in cycles.iter().enumerate() {
        let CircleMessage::Cycle {
            direction,
            left_m,
            stiffness_n_per_m: (n_per_m, sd),
            ..
        } = cycle
        else {
            continue;
        };
        let theta = k as f64 * std::f64::consts::FRAC_PI_2;
        let left = bench.machine.hysteresis_m.at(theta);
        let want = bench.machine.stiffness_n_per_m.at(theta) / 1.05;
        println!(
            "{:3.0}°: left {:.2} µm ({:.2}), {:.2} ± {:.2} N/µm ({:.2})",
            theta.to_degrees(),
            1e6 * left_m,
            1e6 * left,
            1e-6 * n_per_m,
            1e-6 * sd,
            1e-6 * want
        );
        assert_eq!(usize::from(*direction), k);
        assert!((f64::from(*left_m) - left).abs() < 0.4e-6);
        assert!((f64::from(*n_per_m) / want - 1.0).abs() < 0.01 && *sd > 0.0);
    }
    // The bar is held at rest, and the box goes on.
    all.run_for(3.0);
    let pa = all.rig.plant().pressure_pa;
    assert!((3.8e4..4.2e4).contains(&pa), "{pa}");
    assert_eq!(all.app.supervisor().stage(), Stage::Ready);
}

/// A test by the box that comes down again: hysteresis while moving.
#[test]
fn hysteresis_while_moving_by_the_box() {
    let mut bench = m3();
    bench.machine.hysteresis_m = Around::constant(4.5e-6);
    let mut all = ready(bench, Vec::new());
    let told = run(&mut all, &job(&[0.4, 1.5, 3.0], true, true), None);
    assert_eq!((told.failed, told.runs.len()), (None, 10));
    let f = told.findings();
    let moving = f.moving.expect("up and down");
    // The box's converter steps by 0.6 µm with as much noise: a direction by itself is off by
    // that noise, eleven next to each other are not.
    let off: Vec<f64> = moving.iter().map(|c| c.left_um - 4.5).collect();
    let rms = (off.iter().map(|o| o * o).sum::<f64>() / off.len() as f64).sqrt();
    let worst = off
        .windows(11)
        .map(|w| (w.iter().sum::<f64>() / 11.0).abs())
        .fold(0.0, f64::max);
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    println!("moving: {mean:+.3} µm off, {rms:.3} rms, worst of eleven {worst:.2}");
    let single = off.iter().fold(0.0f64, |m, o| m.max(o.abs()));
    holds(
        "ldbb box: hysteresis while moving, a direction by itself, µm",
        single,
        1e-3..=0.3,
    );
    all_judged("ldbb box");
    assert!(mean.abs() < 0.1 && (1e-3..0.3).contains(&worst));
    assert!((0.02..0.2).contains(&rms));
}
