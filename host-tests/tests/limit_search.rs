//! Promise: the search for a stability limit ends, with the limit or with the truth about
//! why there is none.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_plants::cut::Process;
use rarma_plants::delay::DepthSearch;
use rarma_plants::error::PlantError;
use rarma_plants::growth::milling_growth;
use rarma_plants::milling::{Engagement, MillingConfig};
use rarma_plants::modal::{Mode, ShapedMode};
use rarma_plants::process::Schedule;
use rarma_plants::truth::{Truth, limit_of};
use rayon::prelude::*;

/// Three skew modes in a slot at a low speed: many roots of nearly equal size.
fn cut(seed: u64) -> MillingConfig {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let modes = [650.0, 890.0, 1_750.0].map(|f| {
        let angle: f64 = rng.random_range(0.0..std::f64::consts::PI);
        ShapedMode {
            mode: Mode::from_stiffness(
                f * rng.random_range(0.9..1.1),
                rng.random_range(0.02..0.04),
                1e6 * rng.random_range(30.0..60.0),
            ),
            x: angle.cos(),
            y: angle.sin(),
            at_sensor: 1.0,
            turn_rad_per_m: 0.0,
        }
    });
    MillingConfig {
        teeth: 3,
        spindle_hz: rng.random_range(1_500.0..2_500.0) / 60.0,
        feed_per_tooth_m: 1e-4,
        kt_n_per_m2: 2.2e9,
        kn_n_per_m2: 0.87e9,
        engagement: Engagement::SLOT,
        diameter_m: 13.6e-3,
        modes_other: modes.to_vec(),
        depth: Schedule::constant(2.5e-3),
        ..MillingConfig::default()
    }
}

#[test]
fn skew_modes_at_low_speed_have_limits_and_time_agrees() {
    let found: Vec<(u64, f64)> = (0..6)
        .into_par_iter()
        .map(|seed| {
            let config = cut(seed);
            let truth = Truth::of(&Process::Milling(Box::new(config.clone())), 0.05)
                .unwrap_or_else(|why| panic!("{seed}: {why}"));
            let limit = truth.limit_depth_m().unwrap_or_else(|| {
                panic!("{seed}: {:?}", truth.no_limit);
            });
            assert_eq!(truth.no_limit, None);
            // Another discretisation, with the surface in memory: decays a little below the
            // limit, grows a little above it.
            for (part, grows) in [(0.94, false), (1.06, true)] {
                let growth = milling_growth(&config, part * limit, 1.2).expect("a cut");
                assert_eq!(
                    growth > 0.0,
                    grows,
                    "{seed}: {growth} 1/s at {part} of {limit}"
                );
            }
            (seed, limit)
        })
        .collect();
    for (seed, limit) in &found {
        assert!((1e-4..1e-2).contains(limit), "{seed}: {limit}");
    }
}

#[test]
fn none_in_the_range_and_given_up_are_told_apart() {
    let process = Process::Milling(Box::new(cut(1)));
    let search = |low_m: f64, high_m: f64, ratio: f64| DepthSearch {
        low_m,
        high_m,
        ratio,
        tolerance: 1e-4,
    };
    let limit = limit_of(&process, f64::INFINITY, &search(1e-5, 1e-2, 1.2)).expect("a limit");
    let below = search(1e-5, 0.5 * limit.depth_m, 1.2);
    let none = limit_of(&process, f64::INFINITY, &below);
    assert_eq!(none, Err(PlantError::NoLimit));
    // A scan in steps of a millionth would go on for days.
    let fine = search(0.9 * limit.depth_m, 1e-2, 1.000_000_1);
    let given_up = limit_of(&process, f64::INFINITY, &fine);
    assert_eq!(given_up, Err(PlantError::GivenUp));
}

#[test]
fn a_cut_beyond_all_bounds_is_refused_at_once() {
    let mut config = cut(1);
    config.spindle_hz = 1e-3;
    let too_large = Truth::of(&Process::Milling(Box::new(config)), 0.05);
    assert!(
        matches!(too_large, Err(PlantError::TooLarge { .. })),
        "{too_large:?}"
    );
}
