//! Promise: the standard deviations that the estimators state are true: ±1.96 of them
//! hold the true frequency and damping in 92 to 97 % of the cases, batch and recursive,
//! with and without forgetting.
//!
//! 980 Hz, 2 %, 400 series each. Print the table with
//! `cargo test --release -p host-tests --test coverage -- --nocapture --test-threads 1`.

use host_tests::bars::{all_judged, holds};
use host_tests::modal_case::{Case, F, Reading, SAMPLES};
use host_tests::statistics::rms;
use rarma_core::estimate::RarmaConfig;

const RUNS: u64 = 400;
/// Samples before the reading with forgetting.
const LONG: usize = 10_000;
/// Bars of the recursion that forgets.
const FORGETTING: &str = "coverage, forgetting";
/// Wanted.
const LOW: f64 = 0.92;
const HIGH: f64 = 0.97;

/// Prints and asserts one line; `worth` is the memory in samples.
fn check(
    form: &str,
    case: &Case,
    method: &str,
    worth: f64,
    reading: impl Fn(u64) -> Option<Reading>,
) {
    let found: Vec<Reading> = (0..RUNS)
        .map(|seed| reading(seed).unwrap_or_else(|| panic!("{method}, seed {seed}: no mode")))
        .collect();
    let share = |inside: &dyn Fn(&Reading) -> bool| {
        found.iter().filter(|x| inside(x)).count() as f64 / RUNS as f64
    };
    let zeta = share(&|x| (x.damping - case.zeta()).abs() <= 1.96 * x.damping_sd);
    let f = share(&|x| (x.frequency - F).abs() <= 1.96 * x.frequency_sd);
    let limit = case.bound(worth);
    let of = |error: &dyn Fn(&Reading) -> f64| rms(&found.iter().map(error).collect::<Vec<_>>());
    println!(
        "| {} | {method} | {zeta:.3} | {f:.3} | {:.2} | {:.2} | {:.2} | {:.2} |",
        case.name(),
        of(&|x| x.damping - case.zeta()) / limit.damping,
        of(&|x| x.frequency - F) / limit.frequency,
        of(&|x| x.damping_sd) / limit.damping,
        of(&|x| x.frequency_sd) / limit.frequency
    );
    for (what, covered) in [("ζ", zeta), ("f", f)] {
        let bar = format!("{form}: {what}, {}, {method}", case.name());
        holds(&bar, covered, LOW..=HIGH);
    }
}

fn header() {
    println!(
        "| case, {RUNS} series | method | ζ covered | f covered | rms error over bound, ζ | f | stated over bound, ζ | f |"
    );
    println!("|---|---|---|---|---|---|---|---|");
}

fn recursive(form: &str, case: &Case, forgetting: f64) {
    let config = RarmaConfig {
        forgetting,
        ..RarmaConfig::default()
    };
    let (samples, worth, name) = if forgetting == 1.0 {
        (SAMPLES, SAMPLES as f64, "recursive".to_string())
    } else {
        let worth = (1.0 + forgetting) / (1.0 - forgetting);
        (LONG, worth, format!("recursive, λ {forgetting}"))
    };
    check(form, case, &name, worth, |seed| {
        case.recursive(config, samples, seed)
    });
}

#[test]
fn batch_states_its_uncertainty() {
    header();
    for case in [Case::of(1, 0.02, None), Case::of(3, 0.02, None)] {
        check("coverage, batch", &case, "batch", SAMPLES as f64, |seed| {
            case.batch(SAMPLES, seed)
        });
    }
}

#[test]
fn recursion_states_its_uncertainty() {
    header();
    for case in [
        Case::of(1, 0.02, None),
        Case::of(3, 0.02, None),
        Case::of(3, 0.02, Some(20.0)),
    ] {
        recursive("coverage", &case, 1.0);
    }
}

#[test]
fn recursion_with_forgetting_states_its_uncertainty() {
    header();
    for case in [
        Case::of(1, 0.02, None),
        Case::of(3, 0.02, None),
        Case::of(3, 0.02, Some(20.0)),
    ] {
        for forgetting in [0.999, 0.998] {
            recursive(FORGETTING, &case, forgetting);
        }
    }
    all_judged(FORGETTING);
}
