//! Promise: `rarma monitor --tacho` follows the speed that a channel of pulses tells, says
//! what is wrong with bad pulses, and refuses channels that are not there.

use host_tests::files::{FLOAT, Folder, wav};
use host_tests::forced::{Forced, ForcedConfig};
use host_tests::process::Ended;
use host_tests::rarma;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const FS: u32 = 8000;
const SECONDS: f64 = 6.0;
const SPINDLE_HZ: f64 = 50.0;
/// Bad pulses begin here, s.
const BAD_S: f64 = 2.0;

/// A stable cut with forced lines 20 dB above its modes.
fn cut(ramp: Option<(f64, f64, f64)>) -> ForcedConfig {
    ForcedConfig {
        fs_hz: f64::from(FS),
        modes: vec![(980.0, 0.03)],
        spindle_hz: SPINDLE_HZ,
        teeth: 4,
        ramp,
        ..ForcedConfig::drawn(4)
    }
}

/// Speed of such a cut, Hz.
fn speed(config: &ForcedConfig, t: f64) -> f64 {
    let (from, to, rate) = config.ramp.unwrap_or((0.0, 0.0, 0.0));
    config.spindle_hz * (1.0 + rate * (t.clamp(from, to) - from))
}

/// Times of `per_turn` pulses a turn, s.
fn pulses(config: &ForcedConfig, per_turn: u32) -> Vec<f64> {
    let (mut turns, mut times) = (0.3, Vec::new());
    for n in 0..(SECONDS * f64::from(FS)) as u32 {
        let t = f64::from(n) / f64::from(FS);
        let step = speed(config, t) * f64::from(per_turn) / f64::from(FS);
        if turns + step >= 1.0 {
            times.push(t + (1.0 - turns) / step / f64::from(FS));
        }
        turns = (turns + step) % 1.0;
    }
    times
}

/// The cut on channel 0, pulses of 2 ms at these times on channel 1. They rise within
/// four samples, as behind an anti-aliasing filter: edges fall between the samples.
fn file(folder: &Folder, config: ForcedConfig, times: &[f64]) -> PathBuf {
    let mut tacho = vec![0.1f32; (SECONDS * f64::from(FS)) as usize];
    for t in times {
        let begin = t * f64::from(FS);
        let samples = tacho.iter_mut().enumerate().skip(begin.ceil() as usize);
        for (n, x) in samples.take(16) {
            *x = (0.1 + 2.9 * ((n as f64 - begin) / 4.0).min(1.0)) as f32;
        }
    }
    let frames = Forced::new(config).zip(tacho);
    let data: Vec<u8> = frames
        .flat_map(|(x, pulse)| [x as f32, pulse])
        .flat_map(f32::to_le_bytes)
        .collect();
    folder.file("tacho.wav", &wav(FLOAT, 2, FS, 32, &data))
}

fn monitor(file: &Path, options: &str) -> Ended {
    rarma!().on("monitor", file, &format!("--json {options}"))
}

/// Time and speed (1/min) of the lines whose speed the tacho tells.
fn told_by_tacho(lines: &[Value]) -> Vec<(f64, f64)> {
    let by_tacho = lines.iter().filter(|l| l["spindle"]["source"] == "tacho");
    let both = |l: &Value| Some((l["t"].as_f64()?, l["spindle"]["rpm"].as_f64()?));
    by_tacho.filter_map(both).collect()
}

#[test]
fn a_speed_that_changes_is_followed_without_an_alarm() {
    follows_a_ramp(1);
}

#[test]
fn a_speed_that_changes_is_followed_by_four_pulses_a_turn() {
    follows_a_ramp(4);
}

fn follows_a_ramp(per_turn: u32) {
    let folder = Folder::default();
    // From 3000 to 3480 1/min in two seconds.
    let config = cut(Some((2.0, 4.0, 0.08)));
    let times = pulses(&config, per_turn);
    let file = file(&folder, config.clone(), &times);
    // The told speed is 5 % wrong: the tacho goes before it.
    let options = format!("--tacho 1 --pulses {per_turn} --rpm 3150 --teeth 4");
    let ended = monitor(&file, &options);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["alarms"], json!([]));
    let notices = summary["notices"].as_array().expect("notices");
    assert!(notices.iter().all(|n| n["notice"] != "tacho"), "{summary}");
    let read = told_by_tacho(&lines);
    assert!(read.len() > 570, "{} lines of 600", read.len());
    let mut worst: f64 = 0.0;
    for (t, rpm) in read.iter().filter(|(t, _)| *t > 0.5) {
        let off = rpm / (60.0 * speed(&config, *t)) - 1.0;
        worst = worst.max(off.abs());
    }
    println!("{per_turn} pulses a turn: speed at most {worst:.5} off; {notices:?}");
    // A line comes up to a turn after the pulse, 0.16 % of speed at this rate, and where
    // the ramp begins or ends the fit over twelve pulses is off: 0.47 % with one a turn.
    assert!(worst < 0.006, "{worst}");
    let last = summary["spindle"]["rpm_last"].as_f64();
    let right = last.is_some_and(|rpm| (rpm / 3480.0 - 1.0).abs() < 0.003);
    assert!(right, "{summary}");
}

/// The speed (median from the third second on) and the faults that were named.
fn with(times: &[f64]) -> (f64, Vec<(f64, String)>, Ended) {
    let folder = Folder::default();
    let file = file(&folder, cut(None), times);
    let ended = monitor(&file, "--tacho 1 --rpm 3000 --teeth 4");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["alarms"], json!([]));
    let faults = summary["notices"].as_array().expect("notices").iter();
    let named = faults.map(|notice| {
        assert_eq!(notice["notice"], "tacho", "{notice}");
        let fault = notice["fault"].as_str().expect("a word").to_owned();
        (notice["t"].as_f64().expect("a time"), fault)
    });
    let named: Vec<_> = named.collect();
    let late = |l: &&Value| l["t"].as_f64().is_some_and(|t| t > 3.0);
    let mut speeds: Vec<f64> = lines
        .iter()
        .filter(late)
        .filter_map(|l| l["spindle"]["rpm"].as_f64())
        .collect();
    assert!(speeds.len() > 290, "{} lines with a speed", speeds.len());
    speeds.sort_by(f64::total_cmp);
    (speeds[speeds.len() / 2], named, ended)
}

#[test]
fn bad_pulses_are_named_and_the_speed_stays_right() {
    let good = pulses(&cut(None), 1);
    let interval = 1.0 / SPINDLE_HZ;
    let counted = || good.iter().copied().enumerate();
    let missing = counted().filter(|(k, t)| *t < BAD_S || k % 3 != 0);
    let missing: Vec<f64> = missing.map(|(_, t)| t).collect();
    let doubled = counted().flat_map(|(k, t)| {
        let bounces = t > BAD_S && k % 2 == 0;
        [Some(t), bounces.then_some(t + 0.3 * interval)]
    });
    let doubled: Vec<f64> = doubled.flatten().collect();
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let noisy = good.iter().map(|&t| {
        let shaken = t + rng.random_range(-0.15..0.15) * interval;
        if t > BAD_S { shaken } else { t }
    });
    let noisy: Vec<f64> = noisy.collect();
    for (times, fault, words, tolerance) in [
        (missing, "missing", "misses pulses", 1.0),
        (doubled, "doubled", "too many pulses", 1.0),
        (noisy, "noisy", "without a rhythm", 30.0),
    ] {
        let (rpm, named, ended) = with(&times);
        println!("{fault}: {rpm:.2} 1/min, {named:?}");
        assert!((rpm - 3000.0).abs() < tolerance, "{fault}: {rpm}");
        let first = named.first().expect("a notice");
        assert_eq!(first.1, fault);
        assert!((BAD_S..BAD_S + 0.5).contains(&first.0), "{named:?}");
        // One fault is told once, not at every decision.
        assert!(named.len() <= 3, "{named:?}");
        assert!(ended.stderr.contains(words), "{}", ended.stderr);
    }
}

#[test]
fn a_tacho_that_says_nothing_is_named_and_done_without() {
    let (rpm, named, ended) = with(&[]);
    assert!((rpm / 3000.0 - 1.0).abs() < 0.001, "{rpm}");
    let [(t, fault)] = &named[..] else {
        panic!("{named:?}");
    };
    assert_eq!(fault, "silent");
    assert!((0.99..1.1).contains(t), "{t}");
    assert!(ended.stderr.contains("gives no pulses"), "{}", ended.stderr);
}

#[test]
fn channels_that_cannot_be_the_tacho_are_refused() {
    let folder = Folder::default();
    let file = file(&folder, cut(None), &[]);
    for (command, options, code, words) in [
        ("monitor", "--tacho 2", 3, "channel 2"),
        ("monitor", "--tacho 0", 2, "--tacho"),
        ("monitor", "--second 1 --tacho 1", 2, "--tacho"),
        ("monitor", "--pulses 2", 2, "--tacho"),
        ("monitor", "--tacho 1 --pulses 0", 2, "--pulses"),
        ("target", "--tacho 1", 2, "--tacho"),
    ] {
        let ended = rarma!().on(command, &file, options);
        assert_eq!(ended.code, Some(code), "{options}: {ended:?}");
        assert!(ended.stderr.contains(words), "{options}: {ended:?}");
        if code == 3 {
            assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        }
    }
}
