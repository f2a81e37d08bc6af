use super::*;
use crate::cers::Geometry;

/// What the magnet really is: iron, a gap zero that is off by 6 µm, 7 % more gain.
fn truth() -> Magnet<f64> {
    let iron = Geometry::<f64> {
        iron_path_m: 0.12,
        saturation_t: 1.3,
        ..Geometry::textbook()
    }
    .magnet();
    Magnet {
        gain: 1.07 * iron.gain,
        gap_offset_m: iron.gap_offset_m + 6e-6,
        ..iron
    }
}

fn guess() -> Magnet<f64> {
    Geometry::textbook().magnet()
}

/// Approximately normal, from twelve uniforms.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        (0..12)
            .map(|_| {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (self.0 >> 11) as f64 / (1u64 << 53) as f64
            })
            .sum::<f64>()
            - 6.0
    }
}

/// Currents to `most_a` at five gaps, with the noise of a load cell and of the sensors.
fn pairs(most_a: f64, noise: f64, seed: u64) -> Vec<ForcePair<f64>> {
    let mut rng = Noise(seed);
    let mut out = Vec::new();
    for gap in [100e-6, 125e-6, 150e-6, 175e-6, 200e-6] {
        for k in 1..=8 {
            let current_a = most_a * f64::from(k) / 8.0;
            let f = truth().force(current_a, gap).newton;
            let force_n = f + noise * (0.05 * rng.next() + 0.005 * f * rng.next());
            out.push(ForcePair {
                current_a,
                gap_m: gap,
                force_n,
            });
        }
    }
    out
}

#[test]
fn exact_pairs_give_the_constants_back() {
    let c = calibrate(&pairs(3.0, 0.0, 1), guess(), &CalibrationConfig::default()).unwrap();
    let (found, is) = (c.magnet, truth());
    assert!((found.gain / is.gain - 1.0).abs() < 1e-7, "{c:?}");
    assert!((found.gap_offset_m / is.gap_offset_m - 1.0).abs() < 1e-7);
    assert!((found.saturation_a_per_m / is.saturation_a_per_m - 1.0).abs() < 1e-7);
    assert!(c.knee_found && c.residual_rms_n < 1e-7 && c.rounds < 15);
}

#[test]
fn deviations_are_those_of_the_draws() {
    let draws: Vec<_> = (0..200)
        .map(|seed| {
            calibrate(
                &pairs(3.0, 1.0, 77 + seed),
                guess(),
                &CalibrationConfig::default(),
            )
            .unwrap()
        })
        .collect();
    let is = truth();
    let of = |m: &Magnet<f64>| [m.gain, m.gap_offset_m, m.saturation_a_per_m];
    for k in 0..3 {
        let z: Vec<f64> = draws
            .iter()
            .map(|c| (of(&c.magnet)[k] - of(&is)[k]) / c.deviations[k])
            .collect();
        let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        println!("constant {k}: rms error {rms:.3} stated deviations");
        // 200 draws: ±5 %; deviations are widened by χ² where it is above 1.
        assert!((0.8..1.1).contains(&rms), "{k}: {rms}");
    }
    let chi = draws.iter().map(|c| c.chi_square).sum::<f64>() / 200.0;
    assert!((0.95..1.05).contains(&chi), "{chi}");
    let sd = draws[0].deviations[0] / is.gain;
    assert!((1e-3..1e-2).contains(&sd), "{sd}");
}

/// What the calibration is for, over gaps 110 to 190 µm and 0.1 to 2 A.
#[test]
fn several_points_reconstruct_better_than_one() {
    let error = |m: &Magnet<f64>| {
        let (mut sum, mut n) = (0.0, 0.0);
        for gap in 0..=16 {
            for amps in 1..=20 {
                let (i, s) = (0.1 * f64::from(amps), 110e-6 + 5e-6 * f64::from(gap));
                let e = m.force(i, s).newton / truth().force(i, s).newton - 1.0;
                sum += e * e;
                n += 1.0;
            }
        }
        100.0 * f64::sqrt(sum / n)
    };
    let none = error(&guess());
    // One point: ideal iron scaled to agree at 0.8 A and 150 µm.
    let one = Magnet {
        gain: guess().gain * truth().force(0.8, 150e-6).newton / guess().force(0.8, 150e-6).newton,
        ..guess()
    };
    let single = error(&one);
    let several: Vec<f64> = (0..20)
        .map(|seed| {
            let c = calibrate(
                &pairs(3.0, 1.0, seed),
                guess(),
                &CalibrationConfig::default(),
            );
            error(&c.unwrap().magnet)
        })
        .collect();
    let worst = several.iter().copied().fold(0.0, f64::max);
    println!(
        "not calibrated {none:.1} %, one point {single:.1} %, forty points {worst:.2} % at worst"
    );
    assert!((25.0..34.0).contains(&none), "{none}");
    assert!((3.5..6.5).contains(&single), "{single}");
    assert!((0.01..0.7).contains(&worst), "{worst}");
}

#[test]
fn pairs_below_the_knee_leave_it_alone() {
    let c = calibrate(&pairs(1.0, 1.0, 3), guess(), &CalibrationConfig::default()).unwrap();
    assert!(!c.knee_found);
    assert_eq!(c.magnet.saturation_a_per_m, guess().saturation_a_per_m);
    assert_eq!(c.deviations[2], 0.0);
    assert!((c.magnet.gap_offset_m - truth().gap_offset_m).abs() < 4.0 * c.deviations[1]);
}

#[test]
fn an_outlier_is_named() {
    let mut all = pairs(3.0, 1.0, 5);
    all[17].force_n *= 1.1;
    let c = calibrate(&all, guess(), &CalibrationConfig::default()).unwrap();
    assert_eq!(c.worst_index, 17);
    assert!(c.worst > 8.0 && c.chi_square > 3.0, "{c:?}");
}

#[test]
fn refusals_have_their_reasons() {
    let config = CalibrationConfig::default();
    let of = |p: &[ForcePair<f64>]| calibrate(p, guess(), &config).unwrap_err();
    let all = pairs(3.0, 1.0, 5);
    assert_eq!(of(&all[..4]), CersError::TooFew { needed: 5 });
    // One gap only: K and δ are one constant. Below the knee nothing else tells them apart.
    let one_gap: Vec<_> = pairs(1.0, 1.0, 5)[..8].to_vec();
    assert_eq!(of(&one_gap), CersError::Singular);
    let mut broken = all.clone();
    broken[6].gap_m = f64::NAN;
    assert_eq!(of(&broken), CersError::NotFinite { index: 6 });
    let careless = CalibrationConfig {
        relative_sd: 0.5,
        ..config
    };
    assert_eq!(
        calibrate(&all, guess(), &careless),
        Err(CersError::OutOfRange {
            name: "relative_sd"
        })
    );
}

#[test]
fn single_precision_calibrates_too() {
    let single: Vec<ForcePair<f32>> = pairs(3.0, 1.0, 9)
        .iter()
        .map(|p| ForcePair {
            current_a: p.current_a as f32,
            gap_m: p.gap_m as f32,
            force_n: p.force_n as f32,
        })
        .collect();
    let a = calibrate(
        &single,
        Geometry::textbook().magnet(),
        &CalibrationConfig::default(),
    )
    .unwrap();
    let b = calibrate(&pairs(3.0, 1.0, 9), guess(), &CalibrationConfig::default()).unwrap();
    assert!((f64::from(a.magnet.gain) / b.magnet.gain - 1.0).abs() < 1e-3);
    assert!((f64::from(a.residual_rms_part) / b.residual_rms_part - 1.0).abs() < 1e-2);
}
