//! Promise: two tones closer than the Fourier transform of the record tells apart
//! are found by the subspace and the tone estimator; and what the other methods do on
//! the same series is stated, both ways.
//!
//! Equal amplitudes, random phases, white noise of half the standard deviation of the
//! sum; found means two poles, each within 2 Hz of one tone. Print the table with
//! `cargo test --release -p host-tests --test two_tones -- --nocapture --test-threads 1`.

use host_tests::bars::holds;
use host_tests::files::Folder;
use host_tests::rarma;
use host_tests::signal::{polynomial, white};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_core::spectrum::{FactorTracker, modal};
use rarma_fit::windowed_density;
use rarma_fit::{Ml, MlConfig, Pem, PemConfig, burg, esprit, modified_covariance, tones};
use serde_json::Value;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

const SEEDS: u64 = 100;
const NEAR_HZ: f64 = 2.0;

struct Case {
    tones: [f64; 2],
    fs: f64,
    n: usize,
}

const CLOSE: Case = Case {
    tones: [150.0, 155.0],
    fs: 1000.0,
    n: 128,
};

impl Case {
    fn series(&self, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(7000 + seed);
        let phases: [f64; 2] = [rng.random_range(0.0..TAU), rng.random_range(0.0..TAU)];
        let at = |k: usize, i: usize| (TAU * self.tones[i] * k as f64 / self.fs + phases[i]).sin();
        white(seed)
            .take(self.n)
            .enumerate()
            .map(|(k, e)| at(k, 0) + at(k, 1) + 0.5 * e)
            .collect()
    }

    fn found(&self, frequencies: &[f64]) -> bool {
        self.tones
            .iter()
            .all(|tone| frequencies.iter().any(|f| (f - tone).abs() < NEAR_HZ))
    }

    fn count(&self, frequencies: impl Fn(&[f64]) -> Vec<f64>) -> u64 {
        let found = |seed: &u64| self.found(&frequencies(&self.series(*seed)));
        (0..SEEDS).filter(found).count() as u64
    }

    fn poles(&self, a: &[f64]) -> Vec<f64> {
        let mut roots = FactorTracker::<f64, 64>::new();
        roots.solve(a, 3000).expect("roots of a finite polynomial");
        let modes = roots.factors(a.len()).iter();
        modes
            .filter_map(|factor| Some(modal(factor, self.fs)?.frequency))
            .collect()
    }

    /// The two largest peaks of the periodogram without window, eight points a bin.
    fn transform(&self, y: &[f64]) -> Vec<f64> {
        let step = self.fs / (8.0 * self.n as f64);
        let density: Vec<f64> = (0..4 * self.n)
            .map(|k| windowed_density(y, |_| 1.0, step * k as f64, self.fs))
            .collect();
        let mut peaks: Vec<usize> = (1..density.len() - 1)
            .filter(|&k| density[k] > density[k - 1] && density[k] >= density[k + 1])
            .collect();
        peaks.sort_by(|&i, &j| density[j].total_cmp(&density[i]));
        peaks.truncate(2);
        peaks.iter().map(|&k| step * k as f64).collect()
    }

    fn pem(&self, p: usize, q: usize) -> u64 {
        let pem = Pem::new(PemConfig::default()).expect("settings");
        self.count(|y| {
            let fit = pem.fit::<20>(y, p, q);
            fit.map_or(Vec::new(), |fit| self.poles(fit.a()))
        })
    }

    fn ml(&self, p: usize, q: usize) -> u64 {
        let ml = Ml::new(MlConfig::default()).expect("settings");
        self.count(|y| {
            let fit = ml.fit::<20, 12>(y, p, q);
            fit.map_or(Vec::new(), |fit| self.poles(fit.a()))
        })
    }

    fn esprit(&self, p: usize) -> u64 {
        self.count(|y| self.poles(esprit::<f64, 30, 64>(y, p).expect("a model").a()))
    }

    fn burg(&self, p: usize) -> u64 {
        self.count(|y| self.poles(burg::<f64, 64>(y, p).expect("a model").a()))
    }

    fn modified_covariance(&self, p: usize) -> u64 {
        self.count(|y| {
            let fit = modified_covariance::<f64, 64>(y, p).expect("a model");
            self.poles(fit.a())
        })
    }

    fn tones(&self) -> u64 {
        self.count(|y| {
            let Ok(fit) = tones::<f64, 6, 64>(y, 2) else {
                return Vec::new();
            };
            let tone = |k| fit.tone(k, self.fs).expect("two tones").frequency;
            vec![tone(0), tone(1)]
        })
    }

    /// Prints a row and holds the count to the range: what was counted, and four more or
    /// less for another machine's rounding, but where all or none are found by right.
    fn row(&self, name: &str, reference: &str, hits: u64, range: RangeInclusive<f64>) {
        println!("| {name} | {hits} | {reference} |");
        let of = format!(
            "{} and {} Hz at {} Hz",
            self.tones[0], self.tones[1], self.fs
        );
        holds(&format!("tones: {name}, {of}"), hits as f64, range);
    }

    fn head(&self) {
        println!(
            "{} and {} Hz, fs {} Hz, {} samples",
            self.tones[0], self.tones[1], self.fs, self.n
        );
        println!("| method | both found, of {SEEDS} seeds | reference bench, % |");
        println!("|---|---|---|");
    }
}

#[test]
fn close_tones_are_found_by_the_line_estimators() {
    CLOSE.head();
    CLOSE.row("tones(2), exact likelihood", "", CLOSE.tones(), 82.0..=90.0);
    for (p, reference, counted) in [(4, "66", 71.0), (6, "", 74.0), (10, "", 79.0)] {
        let name = format!("esprit({p})");
        let range = counted - 4.0..=counted + 4.0;
        CLOSE.row(&name, reference, CLOSE.esprit(p), range);
    }
}

/// Limits, held so that the documentation stays true in both directions.
#[test]
fn close_tones_by_the_other_methods() {
    CLOSE.head();
    let fft = CLOSE.count(|y| CLOSE.transform(y));
    CLOSE.row("FFT, two largest peaks", "8", fft, 8.0..=16.0);
    CLOSE.row("burg(30)", "", CLOSE.burg(30), 10.0..=18.0);
    CLOSE.row("burg(60)", "60", CLOSE.burg(60), 54.0..=62.0);
    CLOSE.row(
        "modified_covariance(40)",
        "",
        CLOSE.modified_covariance(40),
        37.0..=45.0,
    );
    CLOSE.row(
        "modified_covariance(60)",
        "",
        CLOSE.modified_covariance(60),
        75.0..=83.0,
    );
    CLOSE.row("Pem(4,4)", "", CLOSE.pem(4, 4), 0.0..=2.0);
    CLOSE.row("Pem(10,9)", "0 to 4", CLOSE.pem(10, 9), 0.0..=2.0);
    CLOSE.row("Ml(4,4)", "", CLOSE.ml(4, 4), 40.0..=48.0);
    CLOSE.row("Ml(10,9)", "0 to 4", CLOSE.ml(10, 9), 18.0..=26.0);
}

/// Why likelihood at (10,9) falls short: begun at the true tones it stays with them, but
/// the maximum elsewhere is higher.
#[test]
fn likelihood_of_many_parameters_prefers_the_noise() {
    let circle = |radius: f64| {
        // (f, ζ) of a root of this radius at each tone.
        let modes = CLOSE.tones.map(|f| {
            let (l, theta) = (radius.ln(), TAU * f / CLOSE.fs);
            let r = l.hypot(theta);
            (r * CLOSE.fs / TAU, -l / r)
        });
        polynomial(&modes, CLOSE.fs)
    };
    let mut start = [0.0; 19];
    start[..4].copy_from_slice(&circle(0.999));
    start[10..14].copy_from_slice(&circle(0.95));
    let ml = Ml::new(MlConfig::default()).expect("settings");
    let (mut kept, mut higher, mut fitted) = (0, 0, 0);
    for seed in 0..30 {
        let y = CLOSE.series(seed);
        let free = ml.fit::<20, 12>(&y, 10, 9).expect("a model");
        let Ok(led) = ml.fit_from::<20, 12>(&y, 10, 9, &start) else {
            continue;
        };
        fitted += 1;
        kept += u32::from(CLOSE.found(&CLOSE.poles(led.a())));
        higher += u32::from(free.log_likelihood() > led.log_likelihood());
    }
    println!(
        "begun at the tones, {fitted} fits: {kept} keep them, {higher} are beaten from elsewhere"
    );
    // 27, 26 and 25 were counted; one more or less for another machine's rounding.
    for (what, count, counted) in [
        ("begun at the tones, fitted", fitted, 27.0),
        ("begun at the tones, kept", kept, 26.0),
        ("begun at the tones, beaten from elsewhere", higher, 25.0),
    ] {
        let bar = format!("tones: Ml(10,9) {what}");
        holds(&bar, f64::from(count), counted - 1.0..=counted + 1.0);
    }
}

#[test]
fn half_the_rate_makes_it_easy() {
    let case = Case { fs: 500.0, ..CLOSE };
    case.head();
    let fft = case.count(|y| case.transform(y));
    case.row("FFT, two largest peaks", "84", fft, 70.0..=78.0);
    case.row("tones(2)", "", case.tones(), 98.0..=100.0);
    case.row("esprit(4)", "100", case.esprit(4), 98.0..=100.0);
    case.row("esprit(10)", "", case.esprit(10), 98.0..=100.0);
    case.row("burg(60)", "100", case.burg(60), 98.0..=100.0);
    case.row("Pem(10,9)", "6 to 52", case.pem(10, 9), 37.0..=45.0);
    case.row("Ml(10,9)", "6 to 52", case.ml(10, 9), 72.0..=80.0);
}

#[test]
fn tones_apart_are_found() {
    let case = Case {
        tones: [100.0, 180.0],
        fs: 1000.0,
        n: 512,
    };
    case.head();
    case.row("Pem(6,5)", "88 to 98", case.pem(6, 5), 99.0..=100.0);
    case.row("tones(2)", "", case.tones(), 100.0..=100.0);
    case.row("esprit(6)", "", case.esprit(6), 100.0..=100.0);
}

#[test]
fn command_line_finds_close_tones() {
    let folder = Folder::default();
    let mut hits = [0u32; 3];
    let seeds = 20u64;
    for seed in 0..seeds {
        let file = folder.raw("tones.f64", &CLOSE.series(seed));
        let methods = [("esprit", "10,9"), ("tones", "4,4"), ("burg", "60,0")];
        for (hits, (method, order)) in hits.iter_mut().zip(methods) {
            let options = format!("--fs 1000 --order {order} --method {method} --json");
            let found = rarma!()
                .on("identify", &file, &options)
                .json_lines()
                .remove(0);
            let modes = found["modes"].as_array().expect("modes");
            let number = |m: &Value, key: &str| m[key].as_f64().expect("a number");
            let f: Vec<f64> = modes.iter().map(|m| number(m, "f")).collect();
            *hits += u32::from(CLOSE.found(&f));
            assert_eq!(
                modes.iter().all(|m| m["amplitude"].is_number()),
                method == "tones"
            );
            if method == "tones" {
                let sigma2 = number(&found, "sigma2");
                assert!((0.15..0.35).contains(&sigma2), "{sigma2}");
            }
        }
    }
    println!("rarma identify, of {seeds} seeds: esprit 10,9, tones 4,4, burg 60,0: {hits:?}");
    for (method, hits, range) in [
        ("esprit 10,9", hits[0], 16.0..=20.0),
        ("tones 4,4", hits[1], 17.0..=20.0),
        ("burg 60,0", hits[2], 10.0..=14.0),
    ] {
        holds(
            &format!("tones: rarma identify, {method}"),
            f64::from(hits),
            range,
        );
    }
    let file = folder.raw("tones.f64", &CLOSE.series(0));
    for options in [
        "--method tones --order 3,0",
        "--method tones --order 4,2",
        "--method esprit --order 40,0",
    ] {
        let ended = rarma!().on("identify", &file, &format!("--fs 1000 {options}"));
        assert_eq!(ended.code, Some(2), "{options}: {ended:?}");
    }
}
