//! Promise: on the thesis' example, ARMA(6,5) on modes at 452, 639 and 980 Hz, the
//! errors of the recursion are below the thesis' figures, and within the sampling error
//! of the physical limit except for a broad mode among sharper ones, where the bands
//! follow what was measured.
//!
//! The thesis states for the mode at 980 Hz an error of 1.1 % in frequency and 7.5 % in
//! damping (2 %), and of 16.9 % in damping with process damping added (10 % read as
//! 8.31 %). It states no damping for the other two: 3 % and 2.5 % here. Print with
//! `cargo test --release -p host-tests --test thesis_modes -- --nocapture --test-threads 1`.

use host_tests::bars::{all_judged, holds};
use host_tests::modal_case::{Case, F, FS, Reading, SAMPLES};
use host_tests::statistics::quantile;
use rarma_core::estimate::RarmaConfig;

/// Median of the size of a normal error over its standard deviation.
const MEDIAN: f64 = 0.6745;
/// Sampling error of the median of n sizes, relative: 1.17/√n.
fn sampling_error(seeds: usize) -> f64 {
    1.17 / (seeds as f64).sqrt()
}

fn three(zeta: f64) -> Case {
    Case {
        modes: vec![(F, zeta), (452.0, 0.03), (639.0, 0.025)],
        snr_db: None,
    }
}

/// What a line of the table must hold.
struct Wanted {
    /// Largest ratio of the medians to the bound's, before the sampling error.
    ratio: f64,
    /// Largest median error of f and of ζ, %.
    medians: (f64, f64),
    /// Most seeds without the mode.
    lost: usize,
}

fn check(
    case: &Case,
    (method, samples, seeds): (&str, usize, usize),
    wanted: &Wanted,
    read: impl Fn(u64) -> Option<Reading>,
) {
    let (zeta, limit) = (case.zeta(), case.bound(samples as f64));
    let least = (
        100.0 * MEDIAN * limit.frequency / F,
        100.0 * MEDIAN * limit.damping / zeta,
    );
    let found: Vec<Option<Reading>> = (0..seeds as u64).map(read).collect();
    let lost = found.iter().filter(|x| x.is_none()).count();
    // A lost mode counts as an infinite error.
    let median = |size: &dyn Fn(&Reading) -> f64| {
        let sizes: Vec<f64> = found
            .iter()
            .map(|x| x.as_ref().map_or(f64::INFINITY, size))
            .collect();
        100.0 * quantile(&sizes, 0.5)
    };
    let f = median(&|x| (x.frequency - F).abs() / F);
    let damping = median(&|x| (x.damping - zeta).abs() / zeta);
    println!(
        "| {} | {} | {method} | {seeds} | {f:.3} | {:.3} | {damping:.1} | {:.1} | {lost} |",
        case.name(),
        samples as f64 / FS,
        least.0,
        least.1
    );
    assert!(lost <= wanted.lost, "{lost} lost");
    let error = 2.0 * sampling_error(seeds);
    for ratio in [f / least.0, damping / least.1] {
        let band = 1.0 - error..=wanted.ratio * (1.0 + error);
        assert!(
            band.contains(&ratio),
            "{ratio} times the bound, not in {band:?}"
        );
    }
    assert!(f <= wanted.medians.0, "{f} % in frequency");
    holds(
        &format!(
            "thesis: ζ off, %, {}, {} s, {method}, {seeds} seeds",
            case.name(),
            samples as f64 / FS
        ),
        damping,
        0.0..=wanted.medians.1,
    );
}

fn header() {
    println!(
        "| case | s | method | seeds | median error of f, % | bound's | of ζ, % of ζ | bound's | lost |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
}

fn both(case: &Case, wanted: &Wanted) {
    header();
    let recursive = |seed| case.recursive::<f32>(RarmaConfig::default(), SAMPLES, seed);
    for seeds in [40, 200] {
        check(case, ("recursive", SAMPLES, seeds), wanted, recursive);
    }
    check(case, ("batch", SAMPLES, 40), wanted, |seed| {
        case.batch(SAMPLES, seed)
    });
}

#[test]
fn mode_of_two_percent() {
    both(
        &three(0.02),
        &Wanted {
            ratio: 1.1,
            medians: (0.20, 6.5),
            lost: 0,
        },
    );
    all_judged("thesis");
}

#[test]
fn process_damping_on_one_mode() {
    for zeta in [0.08, 0.10] {
        both(
            &Case::of(1, zeta, None),
            &Wanted {
                ratio: 1.1,
                medians: (1.1, 4.0),
                lost: 0,
            },
        );
    }
}

/// One second is too short for the bound here, a limit for long series: batch and
/// recursion miss it alike. With ten seconds they come near it.
#[test]
fn process_damping_among_three_modes() {
    for zeta in [0.08, 0.10] {
        let case = three(zeta);
        both(
            &case,
            &Wanted {
                ratio: 2.5,
                medians: (1.3, 16.9),
                lost: 4,
            },
        );
        let long = 10 * SAMPLES;
        let wanted = Wanted {
            ratio: 1.4,
            medians: (1.1, 4.0),
            lost: 0,
        };
        check(&case, ("recursive", long, 200), &wanted, |seed| {
            case.recursive::<f32>(RarmaConfig::default(), long, seed)
        });
    }
}
