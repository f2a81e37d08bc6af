use super::*;
use crate::plant::milling::{Engagement, MillingConfig};
use crate::plant::modal::Mode;
use crate::plant::process::{Contact, ForceNoise, ProcessDamping, Schedule};
use crate::plant::turning::TurningConfig;
use core::f64::consts::TAU;
use nalgebra::Complex;

const MODE: Mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);

fn lathe(rpm: f64) -> TurningConfig {
    TurningConfig {
        spindle_hz: rpm / 60.0,
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

fn benchmark(engagement: Engagement, rpm: f64) -> MillingConfig {
    let mode = Mode::from_mass(922.0, 0.011, 0.03993);
    MillingConfig {
        engagement,
        spindle_hz: rpm / 60.0,
        modes_x: vec![mode],
        modes_y: vec![mode],
        ..MillingConfig::default()
    }
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
    let zero_order = crate::plant::stability::milling_limit(&helical)
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
