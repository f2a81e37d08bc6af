use super::super::growth::{milling_growth, milling_limit_in_time};
use super::super::modal::Mode;
use super::super::process::{ForceNoise, ProcessDamping, Schedule};
use super::*;
use core::f64::consts::PI;

fn benchmark_mode() -> Mode {
    Mode::from_mass(922.0, 0.011, 0.03993)
}

fn benchmark(engagement: Engagement, two: bool) -> MillingConfig {
    MillingConfig {
        engagement,
        modes_x: vec![benchmark_mode()],
        modes_y: if two {
            vec![benchmark_mode()]
        } else {
            Vec::new()
        },
        ..MillingConfig::default()
    }
}

fn limit_mm(config: &MillingConfig, around_mm: f64) -> f64 {
    let (low, high) = (0.8e-3 * around_mm, 1.25e-3 * around_mm);
    milling_limit_in_time(config, low, high, 0.4, 4e-3).expect("limit in bracket") * 1e3
}

#[test]
fn one_mode_half_immersion_limits() {
    let up = limit_mm(&benchmark(Engagement::up(0.5), false), 0.2135);
    assert!((up / 0.2135 - 1.0).abs() < 0.03, "up {up}");
    // The down-milling limit is a period doubling that the zero-order method misses.
    let down = limit_mm(&benchmark(Engagement::down(0.5), false), 2.103);
    assert!((down / 2.103 - 1.0).abs() < 0.03, "down {down}");
}

#[test]
fn two_mode_slot_limit() {
    let slot = limit_mm(&benchmark(Engagement::SLOT, true), 0.0714);
    assert!((slot / 0.0714 - 1.0).abs() < 0.03, "{slot}");
}

#[test]
fn low_speed_limit_is_converged() {
    let mut config = benchmark(Engagement::SLOT, false);
    config.spindle_hz = 100.0;
    let slot = limit_mm(&config, 0.353);
    assert!((slot / 0.353 - 1.0).abs() < 0.03, "{slot}");
}

#[test]
fn symmetric_structure_does_not_know_up_from_down() {
    let up = limit_mm(&benchmark(Engagement::up(0.5), true), 0.181);
    let down = limit_mm(&benchmark(Engagement::down(0.5), true), 0.181);
    assert!((up / down - 1.0).abs() < 0.008, "{up} {down}");
    assert!((up / 0.181 - 1.0).abs() < 0.03, "{up}");
}

#[test]
fn no_depth_leaves_the_bare_damping() {
    let config = benchmark(Engagement::SLOT, true);
    let mode = benchmark_mode();
    let rate = milling_growth(&config, 0.0, 0.2).expect("runs");
    let want = -mode.zeta * mode.omega();
    assert!((rate / want - 1.0).abs() < 1e-3, "{rate} {want}");
}

#[test]
fn process_damping_raises_the_damping_as_predicted() {
    let mut config = benchmark(Engagement::SLOT, true);
    config.kt_n_per_m2 = 1e-3;
    config.kn_n_per_m2 = 0.0;
    config.process_damping = Some(ProcessDamping {
        c_n_per_m: 2e5,
        friction: 0.0,
        diameter_m: 0.02,
    });
    let mode = benchmark_mode();
    let rate = milling_growth(&config, 1e-4, 0.1).expect("runs");
    // Slot with two teeth: always one tooth in, mean of sin² and cos² is ½.
    let v = PI * 0.02 * config.spindle_hz;
    let km = (mode.stiffness_n_per_m * mode.mass_kg()).sqrt();
    let added = 0.5 * 2e5 * 1e-4 / (2.0 * v * km);
    let want = -(mode.zeta + added) * mode.omega();
    assert!((rate / want - 1.0).abs() < 0.02, "{rate} {want}");
}

fn rigid(teeth: usize) -> MillingConfig {
    MillingConfig {
        teeth,
        feed_per_tooth_m: 1e-4,
        depth: Schedule::constant(1e-3),
        ..MillingConfig::default()
    }
}

#[test]
fn rigid_cutter_gives_the_static_mean_force() {
    // Slot: mean Fx = -N·b·Kn·fz/4, mean Fy = +N·b·Kt·fz/4.
    let config = rigid(3);
    let mut mill = Milling::new(config.clone()).expect("valid");
    let n = 3 * mill.steps_per_tooth();
    let mut mean = [0.0; 2];
    let mut chip = 0.0_f64;
    for _ in 0..n {
        let s = mill.step();
        mean[0] += s.force_n[0] / n as f64;
        mean[1] += s.force_n[1] / n as f64;
        chip = chip.max(s.chip_m);
    }
    let unit = 3.0 * 1e-3 * 1e-4 / 4.0;
    assert!(
        (mean[0] / (-unit * config.kn_n_per_m2) - 1.0).abs() < 1e-3,
        "{mean:?}"
    );
    assert!(
        (mean[1] / (unit * config.kt_n_per_m2) - 1.0).abs() < 1e-3,
        "{mean:?}"
    );
    assert!((chip / 1e-4 - 1.0).abs() < 1e-3);
}

#[test]
fn teeth_that_runout_lifts_leave_their_chip_to_the_next() {
    // Short by more than a feed: the tooth never cuts, the other takes two feeds.
    let mut config = rigid(2);
    config.runout_m = vec![0.0, -1.5e-4];
    let mut mill = Milling::new(config).expect("valid");
    let turn = 2 * mill.steps_per_tooth();
    let chips: Vec<f64> = (0..3 * turn).map(|_| mill.step().chip_m).collect();
    let last = &chips[2 * turn..];
    let top = last.iter().copied().fold(0.0, f64::max);
    assert!((top / 2e-4 - 1.0).abs() < 1e-3, "{top}");
    assert!(last.iter().filter(|h| **h == 0.0).count() >= turn / 2 - 2);
}

#[test]
fn unequal_pitch_shares_the_feed_by_angle() {
    let mut config = rigid(2);
    config.pitch_rad = vec![0.75 * PI, 1.25 * PI];
    let mut mill = Milling::new(config).expect("valid");
    let turn = 2 * mill.steps_per_tooth();
    let chips: Vec<f64> = (0..2 * turn).map(|_| mill.step().chip_m).collect();
    let mut peaks: Vec<f64> = chips[turn..]
        .windows(3)
        .filter(|w| w[1] >= w[0] && w[1] > w[2] && w[1] > 5e-5)
        .map(|w| w[1])
        .collect();
    peaks.sort_by(f64::total_cmp);
    let (low, high) = (peaks[0], peaks[peaks.len() - 1]);
    assert!(
        (low / 0.75e-4 - 1.0).abs() < 0.01 && (high / 1.25e-4 - 1.0).abs() < 0.01,
        "{peaks:?}"
    );
}

#[test]
fn noise_is_seeded() {
    let run = |seed| -> Vec<u64> {
        let mut config = benchmark(Engagement::SLOT, true);
        config.feed_per_tooth_m = 5e-5;
        config.depth = Schedule::constant(5e-5);
        config.noise = ForceNoise {
            relative: 0.05,
            background_n: 0.1,
            ..ForceNoise::default()
        };
        config.seed = seed;
        let mut mill = Milling::new(config).expect("valid");
        (0..5000)
            .map(|_| mill.step().position_m[1].to_bits())
            .collect()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn bad_configurations_are_named() {
    let check = |change: fn(&mut MillingConfig), name| {
        let mut config = rigid(2);
        change(&mut config);
        match Milling::new(config) {
            Err(PlantError::OutOfRange { name: n } | PlantError::WrongLength { name: n }) => {
                assert_eq!(n, name);
            }
            other => panic!("{name}: {other:?}"),
        }
    };
    check(|c| c.teeth = 0, "teeth");
    check(|c| c.runout_m = vec![0.0], "runout_m");
    check(|c| c.pitch_rad = vec![1.0, 1.0], "pitch_rad");
    check(|c| c.kt_n_per_m2 = f64::NAN, "kt_n_per_m2");
    check(|c| c.spindle_hz = 0.0, "spindle_hz");
    check(|c| c.noise.background_n = -1.0, "background_n");
}
