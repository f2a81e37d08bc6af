//! Promise: whatever samples `rarma identify`, `order` and `psd` are given, they end with
//! figures that are numbers, or with exit code 3 and one line that names the file and a
//! remedy; never with an infinity or a NaN on standard output, nor a panic.

use host_tests::files::Folder;
use host_tests::process::Ended;
use host_tests::rarma;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::Value;
use std::path::Path;

/// Calls that do not depend on the samples to be right usage.
const CALLS: [(&str, &str); 16] = [
    ("identify", "--order 2,1"),
    ("identify", "--order 0,0"),
    ("identify", "--order 4,4 --detrend linear --method ml"),
    ("identify", "--order 3,2 --detrend none --method rpem"),
    ("identify", "--order 2,2 --method tones"),
    ("identify", "--order 4,3 --method esprit"),
    ("identify", "--order 4,3 --method riv"),
    ("identify", "--order 4,3 --method iv"),
    ("identify", "--order 12,0 --method iv"),
    ("identify", "--order 20,0 --method lattice"),
    ("identify", "--order 6,0 --method burg"),
    ("identify", "--order 2,1 --method gradient"),
    ("order", "--max 2"),
    ("psd", "--method periodogram"),
    ("psd", "--method welch"),
    ("psd", "--method arma --order 2,1"),
];
const BANDS: [&str; 2] = ["", "--band full"];
/// Fields that are null where there is nothing to say (docs/interfaces.md).
const MAY_BE_NULL: [&str; 4] = ["f_sd", "zeta_sd", "whiteness_p", "band"];

/// Every number is one.
fn assert_numbers(value: &Value, name: &str, of: &str) {
    match value {
        Value::Null => assert!(MAY_BE_NULL.contains(&name), "{name} is null: {of}"),
        Value::Array(items) => items.iter().for_each(|x| assert_numbers(x, name, of)),
        Value::Object(fields) => fields.iter().for_each(|(k, v)| assert_numbers(v, k, of)),
        _ => {}
    }
}

fn assert_sane(ended: &Ended, file: &Path, json: bool, of: &str) {
    match ended.code {
        Some(0) => {
            assert_eq!(ended.stderr, "", "{of}");
            if json {
                assert_numbers(&ended.json(), "", &format!("{of}: {}", ended.stdout));
            } else {
                let bad = ended.stdout.split(|c: char| !c.is_alphanumeric());
                let bad = bad.filter(|w| ["inf", "NaN", "nan"].contains(w)).count();
                assert_eq!(bad, 0, "{of}: {}", ended.stdout);
            }
        }
        Some(3) => {
            assert_eq!(ended.stdout, "", "{of}");
            let lines: Vec<&str> = ended.stderr.lines().collect();
            let [line] = lines[..] else {
                panic!("not one line, {of}: {ended:?}");
            };
            assert!(line.starts_with("rarma: "), "{of}: {line}");
            assert!(line.contains(&file.display().to_string()), "{of}: {line}");
            // Place, what, remedy.
            assert!(
                line.ends_with(')') && line.matches(": ").count() >= 3,
                "{of}: {line}"
            );
            assert!(
                !line.contains("panicked") && !line.contains("defect"),
                "{of}: {line}"
            );
        }
        _ => panic!("{of}: {ended:?}"),
    }
}

fn call_all(name: &str, fs: f64, samples: &[f64]) {
    let folder = Folder::default();
    let file = folder.raw("hard.f64", samples);
    for (command, options) in CALLS {
        for band in BANDS {
            for json in ["", "--json"] {
                let options = format!("--fs {fs} {options} {band} {json}");
                let ended = rarma!().on(command, &file, &options);
                let of = format!("{command} {options} of {name}");
                assert_sane(&ended, &file, !json.is_empty(), &of);
            }
        }
    }
}

/// The ones that a person thinks of.
#[test]
fn known_hard_series_end_in_numbers_or_one_line() {
    let wave = |size: f64| {
        (0..400)
            .map(|n| size * (0.7 * f64::from(n)).sin())
            .collect()
    };
    let cases: [(&str, Vec<f64>); 17] = [
        ("one sample", vec![1.0]),
        ("two samples", vec![1.0, 2.0]),
        (
            "forty samples",
            (0..40).map(|n| (f64::from(n * n)).sin()).collect(),
        ),
        ("nine samples", (0..9).map(f64::from).collect()),
        ("zeros", vec![0.0; 400]),
        ("a constant", vec![0.1; 400]),
        ("a large constant", vec![1e300; 400]),
        (
            "a constant and rounding",
            (0..400).map(|n| 1e9 + 1e-8 * f64::from(n % 2)).collect(),
        ),
        ("a ramp", (0..400).map(f64::from).collect()),
        ("a pure sine", wave(1.0)),
        ("a sine of 1e300", wave(1e300)),
        (
            "a sine of single precision's largest",
            wave(f64::from(f32::MAX)),
        ),
        ("a sine of 1e18", wave(1e18)),
        ("a sine of 1e-99", wave(1e-99)),
        ("a sine of 1e-200", wave(1e-200)),
        ("smallest numbers", wave(5e-324 * 64.0)),
        ("one step at the end", [vec![0.0; 399], vec![1.0]].concat()),
    ];
    for (name, samples) in cases {
        for fs in [100.0, 8000.0] {
            call_all(name, fs, &samples);
        }
    }
}

/// What is too large is named: where it stands, and what to do.
#[test]
fn sizes_that_overflow_are_named() {
    let folder = Folder::default();
    let mut samples: Vec<f64> = (0..400).map(|n| (0.7 * f64::from(n)).sin()).collect();
    for (size, word) in [
        (1e300, "1e300"),
        (f64::from(f32::MAX), "3.4"),
        (-f64::MAX, "-1.79"),
    ] {
        samples[250] = size;
        let file = folder.raw("large.f64", &samples);
        for (command, options) in CALLS {
            let ended = rarma!().on(command, &file, &format!("--fs 1000 {options}"));
            assert_sane(&ended, &file, false, command);
            assert_eq!(ended.code, Some(3), "{ended:?}");
            for word in [word, "sample 250 (0.25 s)", "overflow"] {
                assert!(ended.stderr.contains(word), "{word}: {ended:?}");
            }
        }
    }
}

/// Pieces of series, each in its own way hard.
fn piece() -> impl Strategy<Value = Vec<f64>> {
    let odd = prop_oneof![
        Just(0.0),
        Just(1e19),
        Just(1.1e19),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
        Just(f64::NAN),
        Just(f64::INFINITY),
        any::<f64>(),
        -1.0..1.0f64,
    ];
    let size = prop_oneof![Just(1.0), (-120..25i32).prop_map(|e| 10f64.powi(e))];
    prop_oneof![
        proptest::collection::vec(odd.clone(), 0..5),
        (odd, 0..60usize).prop_map(|(x, n)| vec![x; n]),
        (size.clone(), -2.0..2.0f64, 0..150usize).prop_map(|(size, rate, n)| {
            (0..n).map(|k| size * (rate * k as f64).sin()).collect()
        }),
        (size.clone(), 0.9..1.3f64, 0..150usize)
            .prop_map(|(size, r, n)| (0..n).map(|k| size * f64::powi(r, k as i32)).collect()),
        (size, proptest::collection::vec(-1.0..1.0f64, 0..150))
            .prop_map(|(size, x)| x.iter().map(|x| size * x).collect()),
    ]
}

#[test]
fn any_series_ends_in_numbers_or_one_line() {
    let config = Config {
        cases: 60,
        failure_persistence: None,
        ..Config::default()
    };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[17; 32]);
    // From one end of what --fs takes to the other.
    let rates = prop_oneof![
        Just(1e-3),
        Just(1.0),
        Just(5000.0),
        Just(8000.0),
        Just(48_000.0),
        Just(1e9),
    ];
    let series = (
        proptest::collection::vec(piece(), 1..4),
        rates,
        0..CALLS.len(),
        any::<bool>(),
    );
    TestRunner::new_with_rng(config, rng)
        .run(&series, |(pieces, fs, k, json)| {
            let folder = Folder::default();
            let file = folder.raw("hard.f64", &pieces.concat());
            let (command, options) = CALLS[k];
            for band in BANDS {
                let json_word = if json { "--json" } else { "" };
                let options = format!("--fs {fs} {options} {band} {json_word}");
                let ended = rarma!().on(command, &file, &options);
                assert_sane(&ended, &file, json, &format!("{command} {options}"));
            }
            Ok(())
        })
        .unwrap_or_else(|why| panic!("{why}"));
}
