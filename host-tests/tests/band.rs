//! Promise: `rarma identify`, `order` and `psd` look at the monitor's band of a fast
//! recording, or at the one that is asked for: modes, rates and levels are those of the
//! recording, a slow one is taken as it is, and a band that does not fit is refused in
//! the monitor's words.

use host_tests::bound::Bound;
use host_tests::files::Folder;
use host_tests::json::{number, numbers};
use host_tests::process::Ended;
use host_tests::resources::{Known, shared_or_skip};
use host_tests::statistics::rms;
use host_tests::{rarma, signal};
use rarma_fit::{Pem, PemConfig, mean};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};

const FAST: f64 = 48_000.0;
/// The commands, as short as they go.
const COMMANDS: [(&str, &str); 3] = [
    ("identify", "--order 4,3"),
    ("order", "--max 2"),
    ("psd", "--method welch"),
];

fn say(command: &str, file: &Path, options: &str) -> Ended {
    rarma!().on(command, file, options)
}

fn object(command: &str, file: &Path, options: &str) -> Value {
    let ended = say(command, file, &format!("{options} --json"));
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{options}");
    ended.json()
}

/// Two modes at 48 kHz, one in two hundred of it, by the default band: off by no more
/// than stated, and stated not far above what the recording could tell at all.
#[test]
fn modes_of_a_fast_recording_are_found_within_the_stated_deviation() {
    let folder = Folder::default();
    let modes = [(700.0, 0.03), (1600.0, 0.02)];
    let seconds = 4.0;
    let bound = Bound::of_modes(&signal::modes(&modes, FAST, 1));
    let (mut off_f, mut off_zeta) = (Vec::new(), Vec::new());
    for seed in 1..=8 {
        let x: Vec<f64> = signal::modes(&modes, FAST, seed)
            .map(|x| 3.0 + x)
            .take((seconds * FAST) as usize)
            .collect();
        let file = folder.raw("modes.f64", &x);
        let found = object("identify", &file, "--fs 48000 --order 8,7");
        assert_eq!(found["band"], serde_json::json!([300.0, 2500.0]));
        assert_eq!(number(&found, "fs"), 6000.0);
        // All but the filters' beginning.
        let n = number(&found, "n");
        assert!((0.99..1.0).contains(&(n / 6000.0 / seconds)), "{n}");
        assert!((number(&found, "mean") - 3.0).abs() < 0.3);
        let all = found["modes"].as_array().expect("modes");
        for (f, zeta) in modes {
            let nearest = all
                .iter()
                .filter(|m| number(m, "zeta") < 0.2)
                .min_by(|a, b| {
                    let off = |m: &Value| (number(m, "f") - f).abs();
                    off(a).total_cmp(&off(b))
                })
                .unwrap_or_else(|| panic!("no mode in {found}"));
            off_f.push((number(nearest, "f") - f) / number(nearest, "f_sd"));
            off_zeta.push((number(nearest, "zeta") - zeta) / number(nearest, "zeta_sd"));
            let limit = bound.mode(f, zeta, FAST);
            let root_n = (seconds * FAST).sqrt();
            let over = [
                number(nearest, "f_sd") / (limit.frequency / root_n),
                number(nearest, "zeta_sd") / (limit.damping / root_n),
            ];
            println!("seed {seed}, {f} Hz: stated over the bound of 48 kHz: {over:.2?}");
            assert!(over.iter().all(|x| (0.8..1.6).contains(x)), "{over:?}");
        }
    }
    let (f, zeta) = (rms(&off_f), rms(&off_zeta));
    println!("rms error over stated, 16 readings: f {f:.2}, ζ {zeta:.2}");
    // A ratio of 16 readings scatters by 0.18.
    assert!((0.5..1.5).contains(&f) && (0.5..1.5).contains(&zeta));
}

#[test]
fn default_band_is_the_monitors_and_can_be_asked_for() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::modes(&[(900.0, 0.02)], FAST, 5)
        .take(48_000)
        .collect();
    let file = folder.raw("mode.f64", &x);
    for (command, options) in COMMANDS {
        let of = |band: &str| object(command, &file, &format!("--fs 48000 {options} {band}"));
        let usual = of("");
        assert_eq!(usual, of("--band 300:2500"), "{command}");
        assert_eq!(usual["band"], serde_json::json!([300.0, 2500.0]));
        let full = of("--band full");
        assert_eq!((full["band"].is_null(), number(&full, "fs")), (true, FAST));
        assert_eq!(number(&full, "n"), 48_000.0);
        // Another band is another rate: 48 kHz over 2.4 times its upper edge, even.
        let narrow = of("--band 500:1200");
        assert_eq!(number(&narrow, "fs"), 3000.0, "{command}");
        for mode in narrow["modes"].as_array().into_iter().flatten() {
            assert!((500.0..=1200.0).contains(&number(mode, "f")), "{narrow}");
        }
    }
}

/// What has been measured at up to 6 kHz stays as it is, whoever asks.
#[test]
fn slow_recordings_are_taken_as_they_are() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::modes(&[(980.0, 0.02), (1700.0, 0.03)], 5000.0, 3)
        .take(5000)
        .collect();
    let file = folder.raw("mode.f64", &x);
    for fs in [5000.0, 6000.0] {
        for (command, options) in COMMANDS {
            let of = |band: &str| object(command, &file, &format!("--fs {fs} {options} {band}"));
            let usual = of("");
            assert_eq!(usual, of("--band full"), "{command} at {fs} Hz");
            assert_eq!((usual["band"].is_null(), number(&usual, "fs")), (true, fs));
            assert_eq!(number(&usual, "n"), 5000.0);
            assert!(of("--band 300:2000")["band"].is_array());
        }
    }
    let above = object("identify", &file, "--fs 6001 --order 4,3");
    assert!(above["band"].is_array());
    // The estimator itself, on the series without its mean.
    let removed = mean(&x);
    let y: Vec<f64> = x.iter().map(|x| x - removed).collect();
    let fit = Pem::new(PemConfig::default())
        .and_then(|m| m.fit::<7>(&y, 4, 3))
        .expect("a fit");
    let found = object("identify", &file, "--fs 5000 --order 4,3");
    for (told, own) in [(&found["a"], fit.a()), (&found["c"], fit.c())] {
        for (told, own) in numbers(told).iter().zip(own) {
            assert!((told - own).abs() < 1e-9, "{told} {own}");
        }
    }
}

/// Mean of a density between two frequencies, and its integral.
fn level(density: &Value, low: f64, high: f64) -> (f64, f64) {
    let (f, psd) = (numbers(&density["f"]), numbers(&density["psd"]));
    let inside: Vec<f64> = f
        .iter()
        .zip(&psd)
        .filter(|(f, _)| (low..=high).contains(*f))
        .map(|(_, s)| *s)
        .collect();
    let sum: f64 = inside.iter().sum();
    (sum / inside.len() as f64, sum * (f[1] - f[0]))
}

/// White noise of variance 4 and a tone of amplitude 0.5: levels in units² per Hz, right
/// up to the edges, where the conditioning itself takes 3 dB.
#[test]
fn levels_in_the_band_are_those_of_the_recording() {
    let folder = Folder::default();
    for fs in [8000.0, 44_100.0, FAST] {
        let n = (20.0 * fs) as usize;
        let white: Vec<f64> = signal::white(9).map(|x| 2.0 * x).take(n).collect();
        let file = folder.raw("white.f64", &white);
        let truth = 2.0 * 4.0 / fs;
        let full = object(
            "psd",
            &file,
            &format!("--fs {fs} --method welch --band full"),
        );
        for (options, tolerance) in [
            ("--method welch", 0.05),
            ("--method periodogram", 0.05),
            ("--method ar --order 30,0", 0.10),
            ("--method arma --order 8,7", 0.10),
        ] {
            let part = object("psd", &file, &format!("--fs {fs} {options}"));
            let f = numbers(&part["f"]);
            assert!(f.iter().all(|f| (300.0..=2500.0).contains(f)));
            for (low, high) in [(300.0, 420.0), (420.0, 1500.0), (1500.0, 2500.0)] {
                // Poles alone do not follow the zeros of the high-pass.
                let poles_at_the_edge = options.contains("--method ar ") && low == 300.0;
                let tolerance = if poles_at_the_edge { 0.20 } else { tolerance };
                let (own, _) = level(&part, low, high);
                let (other, _) = level(&full, low, high);
                println!(
                    "{fs} Hz, {options}, {low} to {high} Hz: {:.3} of the truth, {:.3} of full",
                    own / truth,
                    own / other
                );
                assert!((own / truth - 1.0).abs() < tolerance, "{own} {truth}");
                assert!((own / other - 1.0).abs() < tolerance, "{own} {other}");
            }
        }
        let tone: Vec<f64> = signal::tone(1000.0, fs)
            .map(|x| 7.0 + 0.5 * x)
            .take(n)
            .collect();
        let file = folder.raw("tone.f64", &tone);
        for band in ["", "--band full"] {
            let density = object("psd", &file, &format!("--fs {fs} --method welch {band}"));
            let (_, power) = level(&density, 950.0, 1050.0);
            assert!(
                (power / 0.125 - 1.0).abs() < 0.01,
                "{fs} Hz {band}: {power}"
            );
        }
        let grid = object("psd", &file, &format!("--fs {fs} --method welch"));
        let f = numbers(&grid["f"])[100];
        let alone = object("psd", &file, &format!("--fs {fs} --method welch --at {f}"));
        let (alone, grid) = (numbers(&alone["psd"])[0], numbers(&grid["psd"])[100]);
        assert!(
            (alone / grid - 1.0).abs() < 1e-3,
            "{alone} {grid} at {f} Hz"
        );
    }
}

#[test]
fn band_that_does_not_fit_is_refused_as_the_monitor_does() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::white(1).take(16_000).collect();
    let file = folder.raw("noise.f64", &x);
    for (band, code) in [
        ("300:200", 2),
        ("0:200", 2),
        ("1:2500", 2),
        ("300:4000", 3),
        ("500", 2),
        ("low:high", 2),
    ] {
        let options = format!("--fs 8000 --band {band}");
        let monitor = say("monitor", &file, &options);
        assert_eq!(monitor.code, Some(code), "{band}: {monitor:?}");
        for (command, more) in COMMANDS {
            let ended = say(command, &file, &format!("{options} {more}"));
            assert_eq!(
                (ended.code, &ended.stdout[..]),
                (Some(code), ""),
                "{ended:?}"
            );
            if band.contains(':') && band != "low:high" {
                assert_eq!(ended.stderr, monitor.stderr, "{command} {band}");
                assert_eq!(ended.stderr.lines().count(), 1);
            } else {
                assert!(ended.stderr.contains("full"), "{command} {band}: {ended:?}");
            }
        }
    }
    for (at, band) in [("200", ""), ("2600", ""), ("4100", "--band full")] {
        let ended = say(
            "psd",
            &file,
            &format!("--fs 8000 --method welch --at {at} {band}"),
        );
        assert_eq!((ended.code, &ended.stdout[..]), (Some(2), ""), "{ended:?}");
        assert!(ended.stderr.contains("--at") && ended.stderr.contains(at));
    }
}

/// A face mill that chatters at 898.6 Hz, by ear and spectrum.
#[test]
fn chatter_of_a_recording_is_found_by_default() {
    let Some(shared) = shared_or_skip("chatter_of_a_recording_is_found_by_default") else {
        return;
    };
    let known = Known::read(&shared, "hafez_mill_sound/chatter");
    let found = object("identify", &known.path, "--order 8,7");
    let chatter = found["modes"]
        .as_array()
        .expect("modes")
        .iter()
        .min_by(|a, b| number(a, "zeta").total_cmp(&number(b, "zeta")))
        .expect("a mode");
    println!("{chatter}");
    assert!((number(chatter, "f") - 898.6).abs() < 3.0, "{chatter}");
    assert!((1e-4..0.01).contains(&number(chatter, "zeta")), "{chatter}");
}

/// Work of many minutes says so beforehand, and ends when it is told to.
#[test]
fn long_work_is_announced_and_can_be_broken_off() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::white(1).take(1_000_000).collect();
    let file = folder.raw("long.f64", &x);
    for command in ["identify --order 30,29", "order --max 30"] {
        let mut words = command.split(' ');
        // Who runs tests in the background has the signal ignored, and so have they.
        let mut child = Command::new("env")
            .args([
                "--default-signal=INT",
                env!("CARGO_BIN_EXE_rarma-under-test"),
            ])
            .arg(words.next().expect("a command"))
            .arg(&file)
            .args(["--fs", "48000", "--band", "full"])
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut errors = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut said = String::new();
        errors.read_line(&mut said).expect("a line");
        assert!(
            said.contains("1000000 samples") && said.contains("--band"),
            "{said}"
        );
        let told = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .expect("kill");
        assert!(told.success());
        let ended = child.wait_with_output().expect("an end");
        assert_eq!(ended.status.signal(), Some(2), "{command}");
        assert!(ended.stdout.is_empty());
        errors.read_to_string(&mut said).expect("text");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}
