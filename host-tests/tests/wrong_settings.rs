//! Promise: settings that contradict the signal raise no alarm, and the monitor does
//! not keep it to itself.
//!
//! `--nocapture` prints what is said.

use host_tests::bars::{all_judged, holds};
use host_tests::files::Folder;
use host_tests::forced::{Forced, ForcedConfig};
use host_tests::rarma;
use host_tests::stepping::{Constant, Course, DOWN_S, END_S, FS_HZ, MODE_HZ, Stepping, UP_S};
use host_tests::watch::{Watched, each, watch};
use rarma_core::Order;
use rarma_core::condition::Band;
use rarma_core::decide::State;
use rarma_core::monitor::MonitorConfig;

const SEEDS: u64 = 6;

/// Reasons by their part of the time, of many runs.
fn said(runs: &[Watched], from: f64, to: f64) -> String {
    let mut by = std::collections::BTreeMap::<String, f64>::new();
    for (reason, s) in runs.iter().flat_map(|run| run.reasons(from, to)) {
        *by.entry(reason).or_default() += s / (runs.len() as f64 * (to - from));
    }
    let words: Vec<String> = by.iter().map(|(r, s)| format!("{r} {s:.2}")).collect();
    words.join(", ")
}

#[test]
fn no_teeth_and_no_speed_are_wrong_usage() {
    let folder = Folder::default();
    let samples: Vec<f64> = Stepping::new(Course::Steady(50), Constant::Force, 1, 1)
        .take(10_000)
        .collect();
    let file = folder.pcm16("good.wav", FS_HZ as u32, &samples);
    for options in ["--teeth 0", "--rpm 0", "--rpm 3000 --teeth 0", "--teeth=-1"] {
        let ended = rarma!().on("monitor", &file, options);
        assert_eq!(ended.code, Some(2), "{options}: {ended:?}");
        assert_eq!(ended.stdout, "", "{options}");
        let option = if options.contains("--teeth") {
            "--teeth"
        } else {
            "--rpm"
        };
        assert!(ended.stderr.contains(option), "{options}: {ended:?}");
    }
    // Teeth without a speed are no contradiction.
    assert_eq!(rarma!().on("monitor", &file, "--teeth 4").code, Some(0));
}

#[test]
fn a_mode_outside_the_band_is_not_called() {
    println!("| band, Hz | chatter at {MODE_HZ} Hz: called in {SEEDS} | said meanwhile |");
    println!("|---|---|---|");
    for (low_hz, high_hz) in [(1200.0, 2100.0), (250.0, 800.0), (600.0, 1400.0)] {
        let runs = each((0..SEEDS).collect(), |seed| {
            let config = MonitorConfig {
                order: Order::O43,
                band: Some(Band { low_hz, high_hz }),
                ..MonitorConfig::new(FS_HZ)
            };
            let signal = Stepping::new(Course::Step, Constant::Force, 1, seed);
            watch(&config, signal.take((END_S * FS_HZ) as usize))
        });
        let called = runs.iter().filter(|r| r.called(0.0, END_S) > 0).count();
        println!(
            "| {low_hz}:{high_hz} | {called} | {} |",
            said(&runs, DOWN_S, UP_S)
        );
        let inside = (low_hz..high_hz).contains(&MODE_HZ);
        let expected = if inside { SEEDS as f64 } else { 0.0 };
        holds(
            &format!("settings: called, band {low_hz}:{high_hz}"),
            called as f64,
            expected..=expected,
        );
    }
}

#[test]
fn a_speed_that_contradicts_the_spectrum_raises_no_alarm() {
    const SECONDS: f64 = 8.0;
    println!("| told | signals with an alarm | in chatter, s | said |");
    println!("|---|---|---|---|");
    // No small ratio of whole numbers, so that few multiples of the told speed are true.
    for off in [0.137, -0.291, 0.618] {
        let runs = each((0..SEEDS).collect(), |seed| {
            let signal = ForcedConfig::drawn(seed);
            let config = MonitorConfig {
                spindle_hz: Some(signal.spindle_hz * (1.0 + off)),
                teeth: Some(signal.teeth),
                ..MonitorConfig::new(signal.fs_hz)
            };
            let samples = (SECONDS * signal.fs_hz) as usize;
            watch(&config, Forced::new(signal).take(samples))
        });
        let chatter = |r: &Watched| r.seconds(1.0, SECONDS, |s, _| s == State::Chatter);
        let with = runs.iter().filter(|r| chatter(r) > 0.0).count();
        let seconds: f64 = runs.iter().map(chatter).sum();
        println!(
            "| {:+.1} % | {with} of {SEEDS} | {seconds:.1} | {} |",
            100.0 * off,
            said(&runs, 1.0, SECONDS)
        );
        holds(
            &format!("told: alarms, speed {:+.1} % off", 100.0 * off),
            with as f64,
            0.0..=0.0,
        );
    }
    all_judged("told");
}

#[test]
fn a_wrong_speed_hides_no_chatter() {
    // The told speed has a multiple at the mode; the true one has none near it.
    const FROM_S: f64 = 4.0;
    const SECONDS: f64 = 8.0;
    let runs = each((0..SEEDS).collect(), |seed| {
        let signal = ForcedConfig {
            fs_hz: 5000.0,
            modes: vec![(MODE_HZ, 0.02)],
            spindle_hz: 26.0,
            teeth: 5,
            fading: Some((0, FROM_S, 0.3, 0.0005)),
            ..ForcedConfig::drawn(seed)
        };
        let config = MonitorConfig {
            spindle_hz: Some(MODE_HZ / 35.0),
            teeth: Some(signal.teeth),
            ..MonitorConfig::new(signal.fs_hz)
        };
        let samples = (SECONDS * signal.fs_hz) as usize;
        watch(&config, Forced::new(signal).take(samples))
    });
    let near = Some((MODE_HZ, 15.0));
    let seen = |r: &&Watched| {
        r.first(FROM_S, SECONDS, near).is_some() || r.declared(FROM_S, SECONDS).is_some()
    };
    let found = runs.iter().filter(seen).count();
    println!(
        "chatter at the 35th multiple of a wrong speed: found or declared {found} of {SEEDS}; said {}",
        said(&runs, FROM_S, SECONDS)
    );
    holds(
        "settings: chatter found under a wrong speed",
        found as f64,
        SEEDS as f64..=SEEDS as f64,
    );
}
