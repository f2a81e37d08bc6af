//! Promise: the normalised gradient goes from the start-up to the neighbourhood of the
//! bound, and no signal makes it produce what is not a number or an unstable C.

use host_tests::bound::Bound;
use host_tests::health::stable;
use host_tests::hostile::{EVERYDAY, RARE};
use host_tests::signal;
use host_tests::statistics::rms;
use rarma_core::estimate::{Gain, RarmaConfig, RecursiveArma};
use rarma_core::spectrum::{FactorTracker, modal};

const FS: f64 = 5000.0;
const F: f64 = 980.0;
const ZETA: f64 = 0.02;
const MODES: [(f64, f64); 3] = [(F, ZETA), (450.0, 0.03), (1500.0, 0.025)];
const SAMPLES: usize = 5000;

/// rms error of the damping ratio over the bound, 100 seeds.
fn score<const P: usize, const Q: usize, const N: usize>(gain: Gain<f64>) -> f64 {
    let modes = &MODES[..P / 2];
    let bound = Bound::of_modes(&signal::modes(modes, FS, 100)).mode(F, ZETA, FS);
    let limit = bound.damping / (SAMPLES as f64).sqrt();
    let config = RarmaConfig {
        gain,
        ..RarmaConfig::default()
    };
    let off: Vec<f64> = (0..100)
        .map(|seed| {
            let mut model = RecursiveArma::<f64, P, Q, N>::new(config);
            for y in signal::modes(modes, FS, 100 + seed).take(SAMPLES) {
                model.update(y);
            }
            let mut roots = FactorTracker::<f64, P>::new();
            roots.solve(model.a(), 500).expect("roots");
            let found = roots.factors(P).iter().filter_map(|f| modal(f, FS));
            let mode = found
                .min_by(|x, y| (x.frequency - F).abs().total_cmp(&(y.frequency - F).abs()))
                .expect("a mode");
            (mode.damping - ZETA) / limit
        })
        .collect();
    let score = rms(&off);
    println!("({P},{Q}) {gain:?}: {score:.2}");
    score
}

#[test]
fn it_goes_from_the_start_up_towards_the_bound() {
    // Measured 1.98 and 2.40; the start-up alone 3.31 and 3.38.
    let (one, three) = (
        score::<2, 1, 3>(Gain::normalised()),
        score::<6, 5, 11>(Gain::normalised()),
    );
    assert!((1.5..2.5).contains(&one), "{one}");
    assert!((1.8..3.0).contains(&three), "{three}");
    let idle = Gain::Normalised { step: 0.0 };
    assert!(score::<2, 1, 3>(idle) > 1.2 * one);
    assert!(score::<6, 5, 11>(idle) > 1.1 * three);
}

#[test]
fn hard_signals_leave_it_healthy() {
    for step in [0.001, 1.0] {
        let config = RarmaConfig {
            gain: Gain::Normalised { step },
            ..RarmaConfig::default()
        };
        for hostile in EVERYDAY.iter().chain(&RARE) {
            let mut model = RecursiveArma::<f32, 8, 7, 15>::new(config);
            for (k, y) in (hostile.start)().take(100_000).enumerate() {
                let innovation = model.update(y).innovation;
                let finite = model.theta().iter().all(|x| x.is_finite());
                assert!(innovation.is_finite() && finite, "{} {k}", hostile.name);
                assert!(stable(model.c()), "{} {k}", hostile.name);
            }
        }
    }
}
