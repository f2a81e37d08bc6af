//! Promise: the recursive estimator without forgetting reaches the Cramér–Rao bound of
//! frequency and of damping within one second, on one to four modes, with and without
//! measurement noise, in f32 as in f64, and never loses the mode.
//!
//! Figures are rms errors for a 980 Hz mode over the exact bound (1.0 is the physical
//! limit), 5000 samples at 5 kHz. Print them with
//! `cargo test --release -p host-tests --test accuracy -- --nocapture --test-threads 1`.

use host_tests::modal_case::{Case, ERROR_OF_40, ERROR_OF_200, Reading, SAMPLES};
use host_tests::statistics::rms;
use rarma_core::estimate::RarmaConfig;
use rarma_core::real::Real;

/// No estimator is better than the bound but by chance.
const LOW: f64 = 0.8;
/// Sampling errors that are allowed above what is wanted: two of 40 seeds, for 28
/// ratios are looked at, but one of 200.
const ALLOWED: [f64; 2] = [2.0 * ERROR_OF_40, ERROR_OF_200];
/// One to three modes: wanted.
const NEAR: f64 = 1.15;
/// Four modes: wanted.
const FOUR: f64 = 1.30;

/// Errors of a case in one precision over the bound.
struct Score {
    damping: f64,
    frequency: f64,
    /// Mean error of the damping ratio over the ratio itself.
    bias: f64,
    lost: usize,
}

fn score(case: &Case, found: &[Option<Reading>]) -> Score {
    let limit = case.bound(SAMPLES as f64);
    let there: Vec<&Reading> = found.iter().flatten().collect();
    let zeta: Vec<f64> = there.iter().map(|x| x.damping - case.zeta()).collect();
    let f: Vec<f64> = there
        .iter()
        .map(|x| x.frequency - case.modes[0].0)
        .collect();
    Score {
        damping: rms(&zeta) / limit.damping,
        frequency: rms(&f) / limit.frequency,
        bias: zeta.iter().sum::<f64>() / zeta.len() as f64 / case.zeta(),
        lost: found.len() - there.len(),
    }
}

fn check_in<T: Real>(case: &Case, precision: &str) {
    let wanted = if case.modes.len() > 3 { FOUR } else { NEAR };
    let found: Vec<_> = (0..200)
        .map(|seed| case.recursive::<T>(RarmaConfig::default(), SAMPLES, seed))
        .collect();
    let (few, many) = (score(case, &found[..40]), score(case, &found));
    let limit = case.bound(SAMPLES as f64);
    println!(
        "| {} | {precision} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} | {:+.1} | {} |",
        case.name(),
        100.0 * limit.damping / case.zeta(),
        few.damping,
        many.damping,
        few.frequency,
        many.frequency,
        100.0 * many.bias,
        many.lost
    );
    for (score, allowed) in [few, many].into_iter().zip(ALLOWED) {
        let band = LOW..=wanted * (1.0 + allowed);
        assert_eq!(score.lost, 0, "{} {precision}", case.name());
        for ratio in [score.damping, score.frequency] {
            assert!(
                band.contains(&ratio),
                "{} {precision}: {ratio} not in {band:?}",
                case.name()
            );
        }
        // All estimators read damping a little high; half a standard deviation of the
        // bound is far more than any of these does.
        let bias = (score.bias * case.zeta() / limit.damping).abs();
        assert!(bias < 0.5, "{} {precision}: bias {bias}", case.name());
    }
}

fn check(cases: &[Case]) {
    println!(
        "| case | precision | bound, % of ζ | ζ, 40 seeds | ζ, 200 seeds | f, 40 seeds | f, 200 seeds | bias, % of ζ | lost of 200 |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for case in cases {
        check_in::<f64>(case, "f64");
        check_in::<f32>(case, "f32");
    }
}

#[test]
fn one_mode_reaches_the_bound() {
    check(&[0.005, 0.02, 0.08].map(|zeta| Case::of(1, zeta, None)));
}

#[test]
fn one_mode_in_measurement_noise_reaches_the_bound() {
    check(&[30.0, 20.0, 10.0].map(|snr| Case::of(1, 0.02, Some(snr))));
}

#[test]
fn two_modes_reach_the_bound() {
    check(&[Case::of(2, 0.02, None)]);
}

#[test]
fn three_modes_reach_the_bound() {
    check(&[0.005, 0.02, 0.08].map(|zeta| Case::of(3, zeta, None)));
}

#[test]
fn three_modes_in_measurement_noise_reach_the_bound() {
    check(&[30.0, 20.0, 10.0].map(|snr| Case::of(3, 0.02, Some(snr))));
}

#[test]
fn four_modes_come_near_the_bound() {
    check(&[
        Case::of(4, 0.02, None),
        Case::four_close(),
        Case::of(4, 0.02, Some(20.0)),
    ]);
}
