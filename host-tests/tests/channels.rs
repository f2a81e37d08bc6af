//! Promise: `rarma identify --channels` finds frequency, damping and mode shape of a beam from
//! all its sensors, with deviations that hold the truth, says the same in words and in JSON, and
//! refuses in one line what does not go together.

use host_tests::files::Folder;
use host_tests::json::{keys, number, numbers};
use host_tests::{rarma, signal};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::PathBuf;

const FS: f64 = 2000.0;
/// Hz and damping ratio of the bending modes of a supported beam.
const MODES: [(f64, f64); 3] = [(80.0, 0.02), (210.0, 0.012), (430.0, 0.015)];
const SENSORS: usize = 4;

/// What sensor `c` shows of mode `k`: sin((k + 1)·π·x).
fn bends(k: usize, c: usize) -> f64 {
    (std::f64::consts::PI * (k + 1) as f64 * (c + 1) as f64 / (SENSORS + 1) as f64).sin()
}

/// Time and four sensors, the last one in another unit: a thousand times as large.
fn beam(folder: &Folder, samples: usize) -> PathBuf {
    let waves: Vec<Vec<f64>> = (0..3)
        .map(|k| {
            let wave = signal::modes(&[MODES[k]], FS, 40 + k as u64);
            wave.take(samples).collect()
        })
        .collect();
    let mut text = String::from("time,a,b,c,d\n");
    for t in 0..samples {
        let _ = write!(text, "{:.4}", t as f64 / FS);
        for c in 0..SENSORS {
            let unit = if c == SENSORS - 1 { 1000.0 } else { 1.0 };
            let y: f64 = (0..3).map(|k| bends(k, c) * waves[k][t]).sum();
            let _ = write!(text, ",{:.9e}", unit * y);
        }
        text.push('\n');
    }
    folder.file("beam.csv", text.as_bytes())
}

fn likeness(shape: &[Value], truth: impl Fn(usize) -> f64) -> f64 {
    let (mut re, mut im, mut power, mut other) = (0.0, 0.0, 0.0, 0.0);
    for part in shape {
        let channel = number(part, "channel") as usize;
        let (x, y, z) = (number(part, "re"), number(part, "im"), truth(channel));
        re += x * z;
        im += y * z;
        power += x * x + y * y;
        other += z * z;
    }
    (re * re + im * im) / (power * other)
}

#[test]
fn a_beam_is_found_with_its_shapes() {
    let folder = Folder::default();
    let file = beam(&folder, 24_000);
    let ended = rarma!().on("identify", &file, "--channels all --order 6,0 --json");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let lines = ended.json_lines();
    let found = &lines[0];
    assert_eq!(
        keys(found),
        [
            "band",
            "channels",
            "fs",
            "method",
            "modes",
            "n",
            "order",
            "orders",
            "references",
            "rows",
            "singular_values",
            "stretches",
        ]
    );
    assert_eq!(numbers(&found["channels"]), [0.0, 1.0, 2.0, 3.0]);
    let steps: Vec<f64> = found["orders"]
        .as_array()
        .expect("orders")
        .iter()
        .map(|o| number(o, "order"))
        .collect();
    assert_eq!(steps, [2.0, 4.0, 6.0]);
    let modes = found["modes"].as_array().expect("modes");
    assert_eq!(modes.len(), 3, "{modes:?}");
    for (k, (mode, (f, zeta))) in modes.iter().zip(MODES).enumerate() {
        let off = |name: &str, truth: f64| {
            (number(mode, name) - truth).abs() / number(mode, &format!("{name}_sd"))
        };
        assert!(off("f", f) < 4.5 && off("zeta", zeta) < 4.5, "{mode}");
        // Neither is the deviation so large that it would hold anything.
        assert!(number(mode, "f_sd") < 0.01 * f && number(mode, "zeta_sd") < 0.3 * zeta);
        let shape = mode["shape"].as_array().expect("a shape");
        let unit = |c: usize| if c == SENSORS - 1 { 1000.0 } else { 1.0 };
        assert!(likeness(shape, |c| unit(c) * bends(k, c)) >= 0.99, "{mode}");
        let largest = shape.iter().map(|p| number(p, "magnitude"));
        assert!((largest.fold(0.0, f64::max) - 1.0).abs() < 1e-12);
    }
    // Words say the same three modes.
    let words = rarma!().on("identify", &file, "--channels all --order 6,0");
    assert_eq!(words.stdout.matches("   damping ").count(), 3, "{words:?}");
    assert_eq!(words.stdout.matches("channel 2 ").count(), 3, "{words:?}");
}

#[test]
fn one_reference_and_some_channels_do() {
    let folder = Folder::default();
    let file = beam(&folder, 24_000);
    let options = "--channels 2,0 --references 0 --order 6,0 --rows 30 --stretches 60 --json";
    let ended = rarma!().on("identify", &file, options);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let found = &ended.json_lines()[0];
    assert_eq!(numbers(&found["channels"]), [2.0, 0.0]);
    assert_eq!(numbers(&found["references"]), [0.0]);
    for (k, mode) in found["modes"].as_array().expect("modes").iter().enumerate() {
        let shape = mode["shape"].as_array().expect("a shape");
        assert!(likeness(shape, |c| bends(k, c)) >= 0.99, "{mode}");
    }
}

#[test]
fn what_does_not_go_together_is_refused_in_a_line() {
    let folder = Folder::default();
    let file = beam(&folder, 3000);
    for (options, code, word) in [
        ("--channels all --order 6,5", 2, "N,0"),
        ("--channels 0,9 --order 6,0", 3, "channel 9"),
        (
            "--channels 0,1 --references 3 --order 6,0",
            2,
            "--references",
        ),
        ("--channels 0,0 --order 6,0", 2, "twice"),
        ("--channels 0,1 --order 50,0 --rows 5", 3, "between 1 and 8"),
        (
            "--channels all --order 6,0 --stretches 1000",
            3,
            "too few samples",
        ),
        ("--references 0 --order 6,0", 2, "--channels"),
        (
            "--channels all --order 6,0 --method pem",
            2,
            "cannot be used",
        ),
    ] {
        let ended = rarma!().on("identify", &file, options);
        assert_eq!(ended.code, Some(code), "{options}: {ended:?}");
        assert!(ended.stderr.contains(word), "{options}: {ended:?}");
        assert_eq!(ended.stdout, "", "{options}");
    }
}
