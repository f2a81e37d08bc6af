//! Promise: the reversals of a machine's axes tell the direction of its very first run and a
//! feed that is right on average only; where they do not stand out, the second run tells that the
//! first was turned. No machine that runs as told is accused.
//!
//! `cargo test --release -p host-tests --test ldbb_reversals -- --nocapture`

use host_tests::ldbb::{at_feed, m3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_plants::ldbb::drive::{Test, Trouble, circles};
use rarma_plants::ldbb::{BenchConfig, Geometry, MotionFault};
use rarma_rigs::ldbb::{Proof, RunFault, Schedule, ValveConfig};

/// Machines by chance, of each kind.
const MACHINES: u64 = 40;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Plain,
    Backlash,
    Cyclic,
    Spikes,
    All,
}

const KINDS: [Kind; 5] = [
    Kind::Plain,
    Kind::Backlash,
    Kind::Cyclic,
    Kind::Spikes,
    Kind::All,
];

/// Centre, scale, squareness, bow, play and lag by chance, and what the kind adds.
fn machine(kind: Kind, seed: u64) -> BenchConfig {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut pair = |most: f64| [rng.random_range(-most..most), rng.random_range(-most..most)];
    let mut g = Geometry {
        centre_m: pair(30e-6),
        scale: pair(30e-6),
        squareness_rad: pair(40e-6)[0],
        bow_m: pair(3e-6),
        play_m: pair(1e-6),
        lag_s: pair(1e-3),
        ..Geometry::default()
    };
    let (backlash, spikes) = (pair(2e-6), pair(3e-6));
    if matches!(kind, Kind::Backlash | Kind::All) {
        g.backlash_m = backlash;
    }
    if matches!(kind, Kind::Cyclic | Kind::All) {
        g.cyclic_m = [1.5e-6, 0.8e-6];
    }
    if matches!(kind, Kind::Spikes | Kind::All) {
        g.spike_m = spikes;
    }
    let mut bench = m3();
    bench.machine.geometry = g;
    bench.seed = seed;
    bench
}

fn run(bench: BenchConfig, seed: u64, motion: Option<(u16, MotionFault)>) -> Test {
    let schedule = Schedule::new(&[4e4, 2e5], true, false).expect("rising");
    let config = at_feed(if seed.is_multiple_of(2) {
        1000.0
    } else {
        2000.0
    });
    let trouble = Trouble { motion, air: None };
    circles(bench, config, ValveConfig::default(), schedule, &trouble).expect("sound")
}

#[test]
fn no_machine_is_accused() {
    for kind in KINDS {
        let (mut runs, mut proofs, mut off_deg) = (0, [0; 3], 0.0f32);
        for seed in 0..MACHINES {
            let test = run(machine(kind, seed), seed, None);
            assert_eq!(test.fault, None, "{kind:?} {seed}");
            for r in &test.runs {
                runs += 1;
                proofs[r.done.proof as usize] += 1;
                if r.done.proof == Proof::Reversals {
                    off_deg = off_deg.max(r.done.reversals.off_rad.to_degrees());
                }
            }
        }
        let [none, like, own] = proofs;
        println!(
            "{kind:?}: {runs} runs, direction proven by their reversals {own}, like the one before {like}, open {none}; a reversal off by {off_deg:.2}° at most"
        );
        assert_eq!(runs, 4 * MACHINES);
        match kind {
            Kind::Backlash => assert!(own > 140 && off_deg > 0.05, "{own}"),
            Kind::Plain => assert_eq!(own, 0),
            _ => {}
        }
    }
}

#[test]
fn a_first_run_that_is_turned() {
    for kind in KINDS {
        let (mut at_once, mut by_next, mut never) = (0, 0, 0);
        for seed in 0..MACHINES {
            let turned = Some((0, MotionFault::Reversed));
            let test = run(machine(kind, 100 + seed), seed, turned);
            match (test.fault, test.fault_run) {
                (Some(RunFault::WrongDirection), Some(0)) => at_once += 1,
                (Some(RunFault::WrongDirectionBefore), Some(1)) => by_next += 1,
                (None, _) => never += 1,
                other => panic!("{kind:?} {seed}: {other:?}"),
            }
        }
        println!(
            "{kind:?}, first run turned, of {MACHINES}: told at once {at_once}, by the second run {by_next}, not {never}"
        );
        assert!(at_once + by_next >= 38, "{kind:?}");
        if kind == Kind::Backlash {
            assert!(at_once >= 35, "{at_once}");
        }
    }
}

#[test]
fn a_feed_that_is_right_on_average_only() {
    for (percent, least, most) in [(1.0, 0, 5), (2.0, 20, 40), (3.0, 33, 40), (6.0, 33, 40)] {
        let mut told = 0;
        for seed in 0..MACHINES {
            let swings = Some((0, MotionFault::FeedSwings(0.01 * percent)));
            let test = run(machine(Kind::Backlash, 200 + seed), seed, swings);
            match test.fault {
                Some(RunFault::FeedWithin(_)) => told += 1,
                None => {}
                other => panic!("{percent} % {seed}: {other:?}"),
            }
        }
        println!("half a turn {percent} % faster, half slower, of {MACHINES}: told {told}");
        assert!((least..=most).contains(&told), "{percent} %: {told}");
    }
    // Nothing marks the angle of a machine without backlash.
    let swings = Some((0, MotionFault::FeedSwings(0.05)));
    assert_eq!(run(machine(Kind::Plain, 1), 1, swings).fault, None);
}
