use super::envelope::{Cutting, Swing, growth};
use super::*;
use crate::decide::{StructuralMode, Structure};
use crate::real::Real;
use core::f64::consts::TAU;
use proptest::prelude::*;

/// 980 Hz, 2 %, 11.8 N/µm, Ks = 2000 N/mm², turned with this width and speed.
fn cut(width_m: f64, rpm: f64) -> Cutting<f64> {
    Cutting {
        natural_hz: 980.0,
        zeta: 0.02,
        load: 2e9 * width_m / (2.0 * 11.8e6),
        side: Side::Above,
        tooth_hz: rpm / 60.0,
    }
}

/// Growth, 1/s, of the whole equation (second order, no envelope) integrated in time: the table
/// "A speed that swings" of docs/vmse.md.
const IN_TIME: [(f64, f64, f64, f64, f64); 4] = [
    (0.35e-3, 1500.0, 0.1, 0.2, -15.196),
    (0.5e-3, 1500.0, 0.05, 0.5, 3.022),
    (0.5e-3, 1500.0, 0.2, 0.08, -18.379),
    (0.4e-3, 6000.0, 0.2, 0.05, -61.204),
];

#[test]
fn the_envelope_grows_as_the_whole_equation_does() {
    for (width_m, rpm, amplitude, per_tooth, truth) in IN_TIME {
        let swing = Swing {
            amplitude,
            per_tooth,
        };
        let found = TAU * 980.0 * growth(&cut(width_m, rpm), &swing);
        // ζ·ω_m is 123 1/s: what a pole of first order leaves out is a hundredth of it.
        assert!((found - truth).abs() < 2.5, "{found} {truth}");
    }
    // By the characteristic equation, at constant speed.
    let none = Swing {
        amplitude: 1e-9,
        per_tooth: 0.05,
    };
    for (width_m, rpm, truth) in [(0.35e-3, 1500.0, 5.798), (0.5e-3, 1500.0, 14.870)] {
        let found = TAU * 980.0 * growth(&cut(width_m, rpm), &none);
        assert!((found - truth).abs() < 1.0, "{found} {truth}");
    }
    let mut air = cut(0.0, 1500.0);
    air.load = 1e-12;
    assert!((growth(&air, &none) + 0.02).abs() < 1e-4);
}

#[test]
fn single_precision_plays_the_same() {
    for (width_m, rpm, amplitude, per_tooth, _) in IN_TIME {
        let wide = cut(width_m, rpm);
        let single = Cutting {
            natural_hz: wide.natural_hz as f32,
            zeta: wide.zeta as f32,
            load: wide.load as f32,
            side: wide.side,
            tooth_hz: wide.tooth_hz as f32,
        };
        let a = growth(
            &wide,
            &Swing {
                amplitude,
                per_tooth,
            },
        );
        let b = growth(
            &single,
            &Swing {
                amplitude: amplitude as f32,
                per_tooth: per_tooth as f32,
            },
        );
        assert!((a - b.to_f64()).abs() < 2e-4, "{a} {b}");
    }
}

fn heard(f_hz: f64, spindle_hz: f64, teeth: u32) -> HeardChatter<f64> {
    HeardChatter {
        f_hz,
        f_sd_hz: 0.001 * f_hz,
        spindle_hz,
        spindle_sd_hz: 0.0,
        teeth,
    }
}

fn structure(f_hz: f64, zeta: f64) -> Structure<f64> {
    let mode = StructuralMode {
        f_hz,
        f_sd: 0.001 * f_hz,
        zeta,
        zeta_sd: 0.0,
    };
    Structure::new(&[mode]).unwrap()
}

#[test]
fn what_the_drive_can_do_decides() {
    // 16 waves in a turn of a lathe.
    let heard = heard(310.0, 19.3, 1);
    let modes = structure(304.0, 0.02);
    let with = |config: VariationConfig<f64>| vary(&config, &heard, Some(&modes)).unwrap();
    let usual = VariationConfig::default();
    let able = with(usual);
    assert!(able.helps() && able.growth_ratio < 0.0, "{able:?}");
    // A hundredth of it is no swing to speak of.
    let stiff = with(VariationConfig {
        most_amplitude: 0.01,
        ..usual
    });
    assert!(!stiff.helps() && stiff.growth_ratio > 0.2, "{stiff:?}");
    assert!(stiff.phase_swing < 0.06 * able.phase_swing.max(20.0));
}

#[test]
fn phase_and_acceleration_are_those_of_the_sine() {
    let heard = heard(400.0, 20.0, 1);
    let v = vary(&VariationConfig::default(), &heard, None).unwrap();
    let (n, a, f) = (20.0, v.amplitude, v.swing_hz);
    // The turns of the spindle, and by bisection how long the last of them took.
    let turns = |t: f64| n * t + n * a / (TAU * f) * (1.0 - (TAU * f * t).cos());
    let took = |t: f64| {
        let (mut low, mut high) = (0.5 / n, 2.0 / n);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if turns(t) - turns(t - middle) < 1.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    let times: Vec<f64> = (0..2000).map(|i| took(f64::from(i) / 2000.0 / f)).collect();
    let (least, most) = times
        .iter()
        .fold((1.0_f64, 0.0_f64), |(l, m), t| (l.min(*t), m.max(*t)));
    let swings = 0.5 * TAU * 400.0 * (most - least);
    // To first order in the amplitude.
    assert!(
        (v.phase_swing / swings - 1.0).abs() < 0.05,
        "{v:?} {swings}"
    );
    let steepest = (0..2000)
        .map(|i| f64::from(i) / 2000.0 / f)
        .map(|t| (turns(t + 1e-4) - 2.0 * turns(t) + turns(t - 1e-4)) / 1e-8)
        .fold(0.0_f64, f64::max);
    assert!((v.acceleration / (TAU * steepest) - 1.0).abs() < 0.01);
}

#[test]
fn what_is_out_of_range_is_named() {
    let heard = heard(1000.0, 25.0, 1);
    let usual = VariationConfig::default();
    for bad in [
        VariationConfig {
            most_amplitude: 0.6,
            ..usual
        },
        VariationConfig {
            most_amplitude: f64::NAN,
            ..usual
        },
        VariationConfig {
            most_acceleration: 0.0,
            ..usual
        },
        VariationConfig {
            most_hz: f64::INFINITY,
            ..usual
        },
    ] {
        assert_eq!(vary(&bad, &heard, None), Err(AdviceError::Variation));
    }
    let odd = HeardChatter { teeth: 0, ..heard };
    assert_eq!(vary(&usual, &odd, None), Err(AdviceError::Teeth));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever is heard, what is said is a swing that the drive can do.
    #[test]
    fn whatever_is_heard_the_swing_is_within_the_drive(
        f in 1.0f32..30_000.0, n in 0.01f32..2000.0, teeth in 1u32..1000,
        natural in 1.0f32..30_000.0, zeta in -0.9f32..0.9, with in any::<bool>(),
        amplitude in 0.01f32..0.5, acceleration in 0.1f32..1e5, hz in 0.01f32..100.0,
    ) {
        let heard = HeardChatter { f_hz: f, f_sd_hz: 0.0, spindle_hz: n, spindle_sd_hz: 0.0, teeth };
        let mode = StructuralMode { f_hz: natural, f_sd: 0.0, zeta, zeta_sd: 0.0 };
        let structure = Structure::new(&[mode]).unwrap();
        let config = VariationConfig { most_amplitude: amplitude, most_acceleration: acceleration, most_hz: hz };
        let v = vary(&config, &heard, with.then_some(&structure)).unwrap();
        prop_assert!(v.amplitude <= 1.001 * amplitude && v.swing_hz <= 1.001 * hz);
        prop_assert!(v.acceleration <= 1.001 * acceleration && v.swing_hz > 0.0);
        prop_assert!((0.0..=1.0).contains(&v.chance), "{v:?}");
        prop_assert!(v.phase_swing.is_finite() && v.growth_ratio.is_finite(), "{v:?}");
    }
}
