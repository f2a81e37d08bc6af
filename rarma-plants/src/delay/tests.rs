use super::*;
use crate::error::PlantError;
use crate::milling::{Engagement, MillingConfig};
use crate::modal::Mode;
use crate::process::{Contact, ForceNoise, ProcessDamping, Schedule};
use crate::stability::tests::benchmark;
use crate::turning::TurningConfig;
use core::f64::consts::TAU;
use nalgebra::Complex;

const MODE: Mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);

fn lathe(rpm: f64) -> TurningConfig {
    TurningConfig {
        spindle_hz: rpm / 60.0,
        variation: None,
        feed_m: 0.0,
        ks_n_per_m2: 2e9,
        edge_n_per_m: 0.0,
        nose_radius_m: 0.8e-3,
        modes: vec![MODE],
        width: Schedule::constant(0.0),
        process_damping: None,
        noise: ForceNoise::default(),
        contact: Contact::Linear,
        min_step_rate_hz: 50_000.0,
        seed: 0,
    }
}

/// The root of k(1 + 2ζs/ω + s²/ω²) + b·Ks·(1 - e^(-sτ)) = 0 next to `s`, by Newton.
fn newton(b: f64, tau: f64, mut s: Complex<f64>) -> Complex<f64> {
    let (w, k) = (MODE.omega(), MODE.stiffness_n_per_m);
    for _ in 0..50 {
        let e = (-s * tau).exp();
        let f = (s * s / (w * w) + s * (2.0 * MODE.zeta / w) + 1.0) * k
            + (Complex::new(1.0, 0.0) - e) * (2e9 * b);
        let d = (s * (2.0 / (w * w)) + 2.0 * MODE.zeta / w) * k + e * (2e9 * b * tau);
        s -= f / d;
    }
    s
}

#[test]
fn turning_roots_are_those_of_the_characteristic_equation() {
    for (rpm, share) in [
        (12_000.0, 0.5),
        (12_000.0, 0.9),
        (1500.0, 0.7),
        (10_422.9, 1.1),
    ] {
        let (config, tau) = (lathe(rpm), 60.0 / rpm);
        let b = share * 0.2407e-3;
        let roots = turning_delay(&config, b, 100.0).expect("valid").roots(3);
        assert_eq!(roots.len(), 3);
        for root in roots {
            let w = TAU * root.f_hz;
            let near = Complex::new(-root.zeta * w, w * (1.0 - root.zeta * root.zeta).sqrt());
            let s = newton(b, tau, near);
            let (f, zeta) = (s.norm() / TAU, -s.re / s.norm());
            assert!((root.f_hz - f).abs() < 0.1, "{rpm} {share}: {root:?} {f}");
            assert!(
                (root.zeta - zeta).abs() < 2e-5,
                "{rpm} {share}: {root:?} {zeta}"
            );
            assert!(root.purity > 0.999, "{root:?}");
        }
        let exact = turning_roots(&config, b, 3).expect("valid");
        let stepped = turning_delay(&config, b, 100.0).expect("valid").roots(3);
        for (x, y) in exact.iter().zip(&stepped) {
            assert!((x.f_hz - y.f_hz).abs() < 0.1, "{x:?} {y:?}");
            assert!((x.zeta - y.zeta).abs() < 2e-5, "{x:?} {y:?}");
        }
    }
}

#[test]
fn turning_with_two_modes_and_rubbing_both_ways() {
    let mut config = lathe(3000.0);
    config.modes.push(Mode::from_stiffness(1450.0, 0.03, 2e7));
    config.process_damping = Some(ProcessDamping {
        c_n_per_m: 1e6,
        friction: 0.0,
        diameter_m: 0.06,
    });
    for b in [1e-7, 0.1e-3, 0.3e-3, 1e-3] {
        let exact = turning_roots(&config, b, 4).expect("valid");
        let stepped = turning_delay(&config, b, 120.0).expect("valid").roots(4);
        for (x, y) in exact.iter().zip(&stepped) {
            assert!(
                (x.growth_per_s - y.growth_per_s).abs() < 0.3,
                "{b}: {x:?} {y:?}"
            );
        }
        assert_eq!(exact.len(), 4);
    }
}

#[test]
fn turning_limit_is_the_closed_form() {
    let config = lathe(10_422.9);
    let border = limit(&DepthSearch::between(0.05e-3, 1e-3), |b| {
        turning_delay(&config, b, 60.0)
    })
    .expect("limit");
    assert!(
        (border.depth_m / 0.2407e-3 - 1.0).abs() < 2e-3,
        "{border:?}"
    );
    assert!((border.root.f_hz - 999.4).abs() < 0.3, "{border:?}");
    assert_eq!(border.crossing, Crossing::Hopf);
}

fn border_mm(config: &MillingConfig, steps: f64) -> (f64, Crossing) {
    let search = DepthSearch::between(0.02e-3, 10e-3);
    let b = limit(&search, |d| milling_delay(config, d, steps)).expect("limit");
    (b.depth_m * 1e3, b.crossing)
}

#[test]
fn symmetric_structure_does_not_know_up_from_down() {
    for rpm in [6e3, 20e3] {
        let up = border_mm(&benchmark(Engagement::up(0.05), rpm), 60.0);
        let down = border_mm(&benchmark(Engagement::down(0.05), rpm), 60.0);
        assert!(
            (up.0 / down.0 - 1.0).abs() < 1e-4 && up.1 == down.1,
            "{up:?} {down:?}"
        );
    }
}

#[test]
fn error_falls_with_the_square_of_the_step() {
    let config = benchmark(Engagement::up(0.5), 10e3);
    let at = |steps| border_mm(&config, steps).0;
    let (coarse, middle, fine) = (at(25.0), at(50.0), at(100.0));
    let ratio = (coarse - middle) / (middle - fine);
    assert!((3.0..5.5).contains(&ratio), "{coarse} {middle} {fine}");
}

#[test]
fn no_depth_leaves_the_bare_modes() {
    let mut config = benchmark(Engagement::SLOT, 10e3);
    config.modes_y = vec![Mode::from_stiffness(500.0, 0.03, 1e6)];
    let system = milling_delay(&config, 1e-12, 50.0).expect("valid");
    let mut roots = system.roots(2);
    roots.sort_by(|a, b| b.f_hz.total_cmp(&a.f_hz));
    for (root, (f, zeta)) in roots.iter().zip([(922.0, 0.011), (500.0, 0.03)]) {
        assert!((root.f_hz / f - 1.0).abs() < 1e-6, "{root:?}");
        assert!((root.zeta / zeta - 1.0).abs() < 1e-5, "{root:?}");
    }
}

#[test]
fn helix_and_equal_pitches_written_out_change_nothing_they_should_not() {
    let straight = benchmark(Engagement::down(0.5), 15e3);
    let mut written = straight.clone();
    written.pitch_rad = vec![0.5 * TAU; 2];
    let (a, b) = (border_mm(&straight, 50.0), border_mm(&written, 50.0));
    assert!((a.0 / b.0 - 1.0).abs() < 1e-4, "{a:?} {b:?}");
    // A helix whose lag over the limit depth is a whole pitch makes the cut
    // constant: its limit is that of the mean force, the zero-order one.
    let mut helical = straight;
    let zero_order = crate::stability::milling_limit(&helical)
        .expect("limit")
        .depth_m;
    helical.diameter_m = 0.002;
    helical.helix_rad = (0.25 * TAU * helical.diameter_m / zero_order).atan();
    let system = milling_delay(&helical, zero_order, 80.0).expect("valid");
    let radius = system.radius();
    assert!((radius - 1.0).abs() < 2e-3, "{radius}");
}

#[test]
fn process_damping_and_a_fast_variable_pitch_raise_the_limit() {
    let plain = benchmark(Engagement::down(0.5), 5e3);
    let (base, _) = border_mm(&plain, 50.0);
    let mut damped = plain.clone();
    damped.process_damping = Some(ProcessDamping {
        c_n_per_m: 2e5,
        friction: 0.3,
        diameter_m: 0.02,
    });
    assert!(border_mm(&damped, 50.0).0 > 1.1 * base);
    let mut varied = plain;
    // Half a wave between the two delays: 922 Hz at 5000 rpm is 11.06 per turn.
    let shift = 0.25 * TAU / 11.06;
    varied.pitch_rad = vec![0.5 * TAU - shift, 0.5 * TAU + shift];
    assert!(border_mm(&varied, 50.0).0 > 1.3 * base);
}

#[test]
fn a_scan_that_starts_above_the_limit_finds_it() {
    let config = benchmark(Engagement::SLOT, 10e3);
    for low_m in [1e-5, 1e-4, 1e-3, 5e-3] {
        let search = DepthSearch::between(low_m, 10e-3);
        let found = limit(&search, |d| milling_delay(&config, d, 50.0)).expect("a limit");
        // 0.0714 mm; at 50 steps a period 0.3 % more.
        assert!(
            (0.0712e-3..0.0718e-3).contains(&found.depth_m),
            "from {low_m}: {found:?}"
        );
    }
    // A structure that is unstable by itself has no limit, and that is said.
    let mut config = config;
    config.modes_x = vec![Mode {
        zeta: -0.01,
        ..config.modes_x[0]
    }];
    let search = DepthSearch::between(1e-4, 1e-3);
    let found = limit(&search, |d| milling_delay(&config, d, 50.0));
    assert_eq!(found, Err(PlantError::NoLimit));
}

#[test]
fn what_is_no_depth_is_refused_and_no_numbers_are_not_stable() {
    let (mill, lathe) = (benchmark(Engagement::SLOT, 10e3), lathe(1500.0));
    for bad in [f64::NAN, -1e-4, f64::INFINITY] {
        let refused = |name| PlantError::OutOfRange { name };
        assert_eq!(
            milling_delay(&mill, bad, 50.0).err(),
            Some(refused("depth_m"))
        );
        assert_eq!(
            turning_delay(&lathe, bad, 50.0).err(),
            Some(refused("width_m"))
        );
        assert_eq!(
            turning_roots(&lathe, bad, 1).err(),
            Some(refused("width_m"))
        );
    }
    // 40 steps of a tooth's period are few in a cut a hundred times as stiff as the
    // machine; and what no step resolves is refused, not called stable.
    assert_eq!(
        milling_delay(&mill, 1.0, 1.0).err(),
        Some(PlantError::OutOfRange {
            name: "steps_per_period"
        })
    );
    // A map that leaves the range of numbers is not a stable one.
    let unstable = Mode::from_stiffness(20_000.0, -0.9, 1e7);
    let mut slow = benchmark(Engagement::SLOT, 60.0);
    slow.modes_x = vec![unstable];
    let system = milling_delay(&slow, 1e-9, 10.0).expect("valid");
    assert_eq!(system.radius(), f64::INFINITY);
    assert!(system.roots(1).is_empty());
}

/// What the usual steps do not resolve is judged with shorter ones, and comes out as with
/// shorter ones still.
#[test]
fn a_cut_far_stiffer_than_its_machine_is_judged_with_shorter_steps() {
    use crate::cut::Process;
    use crate::truth::{STEPS_PER_PERIOD, roots};
    let mut config = benchmark(Engagement::SLOT, 10e3);
    let coarse = |depth| milling_delay(&config, depth, STEPS_PER_PERIOD).is_err();
    let depth_m = (0..30)
        .map(|k| 1e-3 * f64::powi(1.5, k))
        .find(|&depth| coarse(depth))
        .expect("some depth is too stiff");
    let finest = milling_delay(&config, depth_m, 32.0 * STEPS_PER_PERIOD).expect("fine enough");
    config.depth = Schedule::constant(depth_m);
    let found = roots(&Process::Milling(Box::new(config)), 0.0, depth_m, 1).expect("judged");
    let (found, finest) = (found[0], finest.roots(1)[0]);
    assert!(found.growth_per_s > 0.0, "{found:?}");
    let off = found.growth_per_s / finest.growth_per_s - 1.0;
    assert!(off.abs() < 0.02, "{found:?} {finest:?}");
}

#[test]
fn long_steps_leave_the_bare_modes_exact() {
    // The step is solved exactly: without a cut its length must not matter. 1.4 steps a
    // period are too few for the frequency, but not for the growth.
    for (mode_hz, per_period) in [(922.0, 17.0), (12_000.0, 1.4)] {
        let mut config = benchmark(Engagement::SLOT, 12e3);
        config.modes_x = vec![Mode::from_stiffness(mode_hz, 0.011, 1e6)];
        config.modes_y = Vec::new();
        let system = milling_delay(&config, 0.0, per_period).expect("valid");
        let growth = -0.011 * TAU * mode_hz;
        let root = system.roots(1)[0];
        assert!(
            (root.growth_per_s / growth - 1.0).abs() < 1e-8,
            "{mode_hz}: {root:?}"
        );
    }
}

#[test]
fn period_doubling_is_as_pure_as_it_is() {
    // One mode along x in a slot at 20 000 rpm: flip at 1.418 mm.
    let mut config = benchmark(Engagement::SLOT, 20e3);
    config.modes_y = Vec::new();
    let search = DepthSearch::between(0.2e-3, 4e-3);
    let border = limit(&search, |d| milling_delay(&config, d, 80.0)).expect("a limit");
    assert_eq!(border.crossing, Crossing::Flip, "{border:?}");
    assert!((border.depth_m / 1.418e-3 - 1.0).abs() < 5e-3, "{border:?}");
    // Half of the power lies at -w: the tone is nearly all of the motion.
    assert!((0.9..=1.0).contains(&border.root.purity), "{border:?}");
}
