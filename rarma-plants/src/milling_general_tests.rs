//! Helix, mode shapes, torsion, pitch, gaps, wear and speed, against the delay
//! equation or against what must come out.

use super::super::delay::milling_delay;
use super::super::growth::milling_growth;
use super::super::modal::{Mode, ShapedMode};
use super::super::process::{ProcessDamping, Schedule, Wear};
use super::*;
use core::f64::consts::PI;

/// Everything at once: skew and torsional modes, helix, unequal pitch, rubbing.
fn general() -> MillingConfig {
    MillingConfig {
        teeth: 3,
        pitch_rad: vec![2.0, 2.1, TAU - 4.1],
        spindle_hz: 80.0,
        feed_per_tooth_m: 0.25e-3,
        kt_n_per_m2: 8e8,
        kn_n_per_m2: 3e8,
        diameter_m: 0.02,
        helix_rad: 0.5,
        engagement: Engagement::down(0.6),
        modes_x: vec![Mode::from_stiffness(980.0, 0.02, 2e7)],
        modes_y: vec![Mode::from_stiffness(452.0, 0.03, 1.5e7)],
        modes_other: vec![ShapedMode {
            mode: Mode::from_stiffness(639.0, 0.02, 2e7),
            x: 0.5,
            y: -0.6,
            turn_rad_per_m: 40.0,
            at_sensor: 1.0,
        }],
        process_damping: Some(ProcessDamping {
            c_n_per_m: 1e5,
            friction: 0.3,
            diameter_m: 0.02,
        }),
        min_step_rate_hz: 150_000.0,
        ..MillingConfig::default()
    }
}

#[test]
fn growth_is_that_of_the_dominant_root_with_everything_at_once() {
    let config = general();
    for depth in [0.3e-3, 1.5e-3, 6e-3] {
        let system = milling_delay(&config, depth, 100.0).expect("valid");
        let root = system.roots(1)[0];
        // Long enough for the others to die, short enough to stay above rounding.
        let duration = (25.0 / root.growth_per_s.abs()).clamp(0.1, 1.0);
        let rate = milling_growth(&config, depth, duration).expect("runs");
        assert!(
            (rate - root.growth_per_s).abs() < 0.02 * root.growth_per_s.abs() + 0.5,
            "{depth}: {rate} against {root:?}"
        );
    }
}

#[test]
fn torsion_matters_to_both_methods_alike() {
    let mut stiff = general();
    stiff.modes_other[0].turn_rad_per_m = 0.0;
    let rate =
        |c: &MillingConfig| milling_delay(c, 6e-3, 60.0).expect("valid").roots(1)[0].growth_per_s;
    let (with, without) = (rate(&general()), rate(&stiff));
    assert!((with - without).abs() > 0.5, "{with} {without}");
    let in_time = milling_growth(&stiff, 6e-3, 0.8).expect("runs");
    assert!(
        (in_time - without).abs() < 0.02 * without.abs() + 0.5,
        "{in_time} {without}"
    );
}

fn rigid() -> MillingConfig {
    MillingConfig {
        teeth: 2,
        feed_per_tooth_m: 1e-4,
        depth: Schedule::constant(1e-3),
        ..MillingConfig::default()
    }
}

#[test]
fn a_helix_keeps_the_mean_force_and_smooths_it() {
    let (straight, mut helical) = (rigid(), rigid());
    helical.depth = Schedule::constant(10e-3);
    helical.helix_rad = 0.9;
    let run = |config: MillingConfig, depth: f64| {
        let mut mill = Milling::new(config).expect("valid");
        let n = 2 * mill.steps_per_tooth();
        // The first revolution still meets the surface that was laid for it.
        (0..n).for_each(|_| {
            mill.step();
        });
        let f: Vec<f64> = (0..n).map(|_| mill.step().force_n[1] / depth).collect();
        let mean = f.iter().sum::<f64>() / n as f64;
        (
            mean,
            f.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64,
        )
    };
    let (a, b) = (run(straight, 1e-3), run(helical, 10e-3));
    assert!((a.0 / b.0 - 1.0).abs() < 5e-3, "{a:?} {b:?}");
    // sin² over a lag of 1.26 rad: (sin 1.26/1.26)² = 0.57.
    assert!((b.1 / a.1 - 0.57).abs() < 0.02, "{a:?} {b:?}");
}

#[test]
fn torque_is_the_tangential_force_times_the_radius() {
    // A torsional mode far above everything: its static twist shows the moment.
    let mut config = rigid();
    config.kn_n_per_m2 = 0.0;
    config.modes_other = vec![ShapedMode {
        mode: Mode::from_stiffness(5000.0, 0.5, 1e9),
        x: 1e-9,
        y: 0.0,
        turn_rad_per_m: 1.0,
        at_sensor: 1.0,
    }];
    let mut mill = Milling::new(config.clone()).expect("valid");
    let n = 2 * mill.steps_per_tooth();
    let mut mean = 0.0;
    for k in 0..3 * n {
        let x = mill.step().position_m[0] / 1e-9;
        if k >= n {
            mean += x / (2 * n) as f64;
        }
    }
    // Slot of two teeth: mean Σ Ft = Kt·b·fz·(2/π)·(1 tooth in the arc at a time).
    let want = -config.kt_n_per_m2 * 1e-3 * 1e-4 * (2.0 / PI) * 0.01 / 1e9;
    assert!((mean / want - 1.0).abs() < 1e-2, "{mean} {want}");
}

#[test]
fn gaps_take_the_force_away_and_give_it_back() {
    let mut config = rigid();
    // 33.3 mm/s of feed; the axis is over the slot from 0.6 to 0.9 s; R = 10 mm.
    config.workpiece = Some(Workpiece {
        x_m: [-1.0, 0.05],
        gaps: vec![Gap::Slot {
            x_m: [0.0, 0.03],
            y_m: [-1.0, 1.0],
        }],
    });
    let mut mill = Milling::new(config.clone()).expect("valid");
    let mut force = vec![0.0_f64; 16];
    while mill.step().t < 1.59 {
        let s = mill.step();
        let tenth = &mut force[(s.t * 10.0) as usize];
        *tenth = tenth.max(s.force_n[1]);
    }
    let full = force[10];
    // Half a revolution of material ahead of the slot is only left at 0 s.
    assert!(force[1] == 0.0 && force[4] == 0.0, "{force:?}");
    // The front of the cutter (10 mm ahead) leaves the slot at x = 20 mm, 0.6 s.
    assert!(force[7] > 0.3 * full && full > 50.0, "{force:?}");
    // Beyond the end of the stock nothing is cut: 40 mm + 10 mm, at 1.5 s.
    assert!(force[15] < 1e-9, "{force:?}");
    // Re-entry meets a chip of about the feed, not the whole wall.
    let most = force.iter().copied().fold(0.0, f64::max);
    assert!(most < 1.1 * full, "{force:?}");
}

#[test]
fn wear_raises_the_force_slowly() {
    let mut config = rigid();
    config.kt_edge_n_per_m = 1e4;
    config.kn_edge_n_per_m = 1e4;
    config.wear = Wear {
        cutting_per_s: 0.2,
        edge_per_s: 1.0,
    };
    let mut mill = Milling::new(config).expect("valid");
    let turn = 2 * mill.steps_per_tooth();
    let mut peak = |from: f64| {
        while mill.step().t < from {}
        (0..turn)
            .map(|_| mill.step().force_n[1])
            .fold(0.0, f64::max)
    };
    let (fresh, worn) = (peak(0.05), peak(1.0));
    // Peak near φ = 90°: b·(Kt·fz + Kte) = 60 N·1.2 + 10 N·2 against 60·1.01 + 10·1.05.
    let want = (60.0 * 1.2 + 20.0) / (60.0 * 1.01 + 10.5);
    assert!((worn / fresh / want - 1.0).abs() < 0.02, "{fresh} {worn}");
}

#[test]
fn a_speed_ramp_keeps_time_and_frequency() {
    let mode = Mode::from_stiffness(980.0, 0.001, 1e7);
    let mut config = rigid();
    config.depth = Schedule::constant(0.0);
    config.modes_x = vec![mode];
    config.speed = Some(Schedule::new(&[(0.1, 100.0), (0.4, 150.0)]).expect("valid"));
    config.spindle_hz = 120.0;
    let mut mill = Milling::new(config).expect("valid");
    mill.disturb(0, 0, 1e-6, 0.0);
    // Zero crossings of the free vibration, wherever the speed is.
    let (mut crossings, mut before, mut last) = (0, 1.0, MillSample::default());
    while last.t < 0.5 {
        last = mill.step();
        crossings += u32::from(before < 0.0 && last.position_m[0] >= 0.0);
        before = last.position_m[0];
    }
    assert!((f64::from(crossings) - 490.0).abs() <= 1.0, "{crossings}");
    assert!((last.spindle_hz - 150.0).abs() < 1e-9);
    // 100·0.1 + 125·0.3 + 150·0.1 revolutions of two teeth.
    let want = 1e-4 * 2.0 * 62.5;
    assert!(
        (last.feed_m / want - 1.0).abs() < 0.01,
        "{} {want}",
        last.feed_m
    );
    assert!(mill.tooth_angle_rad(0) < TAU);
}

#[test]
fn the_sensor_sits_where_its_modes_say() {
    let mode = Mode::from_stiffness(980.0, 0.02, 1e7);
    let mut config = rigid();
    config.modes_x = vec![mode];
    config.modes_other = vec![ShapedMode {
        at_sensor: -0.25,
        ..ShapedMode::along_y(mode)
    }];
    let mut mill = Milling::new(config).expect("valid");
    for _ in 0..500 {
        let s = mill.step();
        for (k, tool) in [s.position_m, s.velocity_m_s, s.acceleration_m_s2]
            .iter()
            .enumerate()
        {
            assert!((s.sensor[k][0] - tool[0]).abs() <= 1e-12 * tool[0].abs());
            assert!((s.sensor[k][1] + 0.25 * tool[1]).abs() <= 1e-12 * tool[1].abs());
        }
    }
    assert!(mill.step().position_m[1].abs() > 1e-9);
}
