use super::*;
use crate::converter::ConverterConfig;
use crate::modal::Mode;
use crate::process::{Contact, ForceNoise, Wear};
use crate::sound::Pickup;

fn probe(seed: u64) -> MicrophoneConfig {
    MicrophoneConfig {
        sample_rate_hz: 48_000.0,
        pickup: Pickup::Displacement,
        gain: [1.0, 0.0],
        distance_m: 0.0,
        enclosure: None,
        noise_pa: 0.0,
        tones: Vec::new(),
        converter: ConverterConfig {
            full_scale: 1e-3,
            bits: 24,
            dither: true,
        },
        seed,
    }
}

fn mill() -> MillingConfig {
    MillingConfig {
        modes_x: vec![Mode::from_mass(922.0, 0.011, 0.03993)],
        modes_y: vec![Mode::from_mass(922.0, 0.011, 0.03993)],
        feed_per_tooth_m: 5e-5,
        depth: Schedule::new(&[(0.0, 0.0), (1.0, 0.1e-3)]).expect("valid"),
        noise: ForceNoise {
            relative: 0.05,
            background_n: 0.1,
            ..ForceNoise::default()
        },
        ..MillingConfig::default()
    }
}

fn milling(config: MillingConfig) -> Scenario {
    Scenario {
        name: "test".to_owned(),
        process: Process::Milling(Box::new(config)),
        microphone: probe(2),
        duration_s: 1.0,
    }
}

#[test]
fn onset_is_when_the_ramp_passes_the_limit() {
    let truth = milling(mill()).truth().expect("valid");
    // 0.0714 mm of the published benchmark, on a ramp of 0.1 mm/s.
    let limit = truth.limit_depth_m().expect("limit");
    assert!((limit * 1e3 - 0.0714).abs() < 2e-4, "{limit}");
    let onset = truth.onset_s.expect("onset");
    assert!((onset - limit / 0.1e-3).abs() < 2e-3, "{onset} {limit}");
    assert_eq!((truth.end_s, truth.cut_s), (None, Some((0.0, 1.0))));
    // The least damped root loses its damping on the way and then grows.
    let zeta: Vec<f64> = truth.operational.iter().map(|o| o.roots[0].zeta).collect();
    assert!(
        zeta[0] > 0.008 && zeta.last().is_some_and(|z| *z < -0.001),
        "{zeta:?}"
    );
    for o in &truth.operational {
        assert_eq!(o.roots[0].zeta < 0.0, o.t_s > onset, "{o:?}");
    }
}

#[test]
fn wear_and_speed_move_the_onset() {
    let mut config = mill();
    config.depth = Schedule::constant(0.06e-3);
    assert_eq!(
        milling(config.clone()).truth().expect("valid").onset_s,
        None
    );
    config.wear = Wear {
        cutting_per_s: 0.5,
        edge_per_s: 0.0,
    };
    // Kt·b counts: 0.0714/0.06 = 1 + 0.5·t.
    let onset = milling(config.clone())
        .truth()
        .expect("valid")
        .onset_s
        .expect("onset");
    assert!((onset - 0.38).abs() < 0.01, "{onset}");
    config.wear = Wear::default();
    config.speed = Some(Schedule::new(&[(0.2, 10_000.0 / 60.0), (0.8, 200.0)]).expect("valid"));
    let truth = milling(config).truth().expect("valid");
    // At 12 000 1/min the limit is lower: the ramp passes it.
    assert!(
        truth.onset_s.is_some_and(|t| t > 0.2 && t < 0.8),
        "{:?}",
        truth.onset_s
    );
}

#[test]
fn turning_truth_is_the_closed_form() {
    let scenario = Scenario {
        process: Process::Turning(Box::new(TurningConfig {
            spindle_hz: 10_422.9 / 60.0,
            variation: None,
            feed_m: 1e-4,
            ks_n_per_m2: 2e9,
            edge_n_per_m: 0.0,
            nose_radius_m: 0.8e-3,
            modes: vec![Mode::from_stiffness(980.0, 0.02, 11.8e6)],
            width: Schedule::constant(0.3e-3),
            process_damping: None,
            noise: ForceNoise::default(),
            contact: Contact::Real,
            min_step_rate_hz: 96_000.0,
            seed: 1,
        })),
        ..milling(mill())
    };
    let truth = scenario.truth().expect("valid");
    let limit = truth.limit_depth_m().expect("limit") * 1e3;
    assert!((limit - 0.2407).abs() < 5e-4, "{limit}");
    assert!((truth.chatter_hz().expect("limit") - 999.4).abs() < 0.3);
    assert!((truth.zero_order_m.expect("limit") * 1e3 - 0.2407).abs() < 2e-4);
    assert_eq!((truth.onset_s, truth.teeth), (Some(0.0), 1));
    // And the sound grows.
    let y: Vec<f64> = VirtualCut::new(&scenario)
        .expect("valid")
        .map(|r| f64::from(r.value))
        .collect();
    let rms = |s: &[f64]| {
        let mean = s.iter().sum::<f64>() / s.len() as f64;
        (s.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / s.len() as f64).sqrt()
    };
    assert!(rms(&y[40_000..]) > 3.0 * rms(&y[2000..4000]));
}

#[test]
fn seeds_repeat_to_the_bit_and_differ() {
    let run = |seed, ramp: bool| -> Vec<i32> {
        let mut config = mill();
        if ramp {
            config.speed = Some(Schedule::new(&[(0.0, 160.0), (0.1, 180.0)]).expect("valid"));
        }
        let mut scenario = milling(config).seeded(seed);
        scenario.duration_s = 0.1;
        VirtualCut::new(&scenario)
            .expect("valid")
            .map(|r| r.code)
            .collect()
    };
    for ramp in [false, true] {
        assert_eq!(run(1, ramp), run(1, ramp));
        assert_ne!(run(1, ramp), run(2, ramp));
    }
}

#[test]
fn a_rigid_machine_has_no_limit() {
    let mut config = mill();
    config.modes_x.clear();
    config.modes_y.clear();
    let truth = milling(config).truth().expect("valid");
    assert!(truth.limit.is_none() && truth.onset_s.is_none() && truth.operational.is_empty());
}
