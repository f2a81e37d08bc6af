//! Promise: `rarma monitor --json` says what docs/interfaces.md lists, field by field,
//! and nothing else.

use host_tests::files::Folder;
use host_tests::json::{keys, number, word};
use host_tests::process::Ended;
use host_tests::{rarma, signal};
use serde_json::Value;
use std::path::Path;

const FS: u32 = 8000;
const SECONDS: usize = 3;
const SAMPLES: usize = SECONDS * FS as usize;
/// Decisions of the monitor are this far apart at 8 kHz, s.
const DECISION: f64 = 0.002;
const STATES: [&str; 6] = [
    "starting", "idle", "stable", "warning", "chatter", "invalid",
];
const LABELS: [&str; 3] = ["self-excited", "structural", "forced"];
const ORIGINS: [&str; 5] = ["free", "rotation", "overtone", "background", "unknown"];
const SOURCES: [&str; 4] = ["unknown", "told", "sound", "tacho"];
const VERDICTS: [&str; 5] = [
    "too-short",
    "forced",
    "suspicious",
    "self-excited",
    "not-stationary",
];
const REASONS: [&str; 14] = [
    "none",
    "estimator-starting",
    "roots-lost",
    "level-at-idle",
    "excited",
    "undamped",
    "losing-damping",
    "forced-only",
    "origin-unknown",
    "entering",
    "samples-not-finite",
    "samples-missing",
    "samples-stuck",
    "samples-clipped",
];

fn monitor(file: &Path, options: &str) -> Ended {
    rarma!().on("monitor", file, &format!("{options} --json"))
}

/// A tone in noise: 900 Hz is the 30th multiple of 30 Hz, 915 Hz is none.
fn tone_in_noise(folder: &Folder, f_hz: f64) -> std::path::PathBuf {
    let tone = signal::tone(f_hz, f64::from(FS));
    let noise = signal::white(5);
    let x: Vec<f64> = tone
        .zip(noise)
        .map(|(t, n)| 0.2 * t + 0.01 * n)
        .take(SAMPLES)
        .collect();
    folder.pcm16("tone.wav", FS, &x)
}

/// A tone beside the teeth of a cut, six of them at 30 turns a second, after a second of noise
/// alone: what was always there may be a fan, and one line by itself tells no speed.
fn tone_in_a_cut(folder: &Folder, f_hz: f64) -> std::path::PathBuf {
    let idle = FS as usize;
    let mut x: Vec<f64> = signal::white(5).map(|n| 0.01 * n).take(SAMPLES).collect();
    let mut add = |f_hz: f64, amplitude: f64| {
        for (x, tone) in x
            .iter_mut()
            .skip(idle)
            .zip(signal::tone(f_hz, f64::from(FS)))
        {
            *x += amplitude * tone;
        }
    };
    add(f_hz, 0.2);
    for k in 1..=8 {
        add(180.0 * f64::from(k), 0.05);
    }
    folder.pcm16("tone.wav", FS, &x)
}

fn damped(folder: &Folder) -> std::path::PathBuf {
    let modes = signal::modes(&[(900.0, 0.04), (1700.0, 0.03)], f64::from(FS), 7);
    let x: Vec<f64> = modes.map(|x| 0.1 * x).take(SAMPLES).collect();
    folder.pcm16("damped.wav", FS, &x)
}

/// Every field of a line, its kind and its range.
fn check_line(line: &Value) {
    let wanted = ["amplitude", "modes", "reason", "spindle", "state", "t"];
    // Advice comes in the line after a call alone; what it holds is asked in advise_command.rs.
    let own = keys(line).into_iter().filter(|key| *key != "advice");
    assert!(own.eq(wanted), "{line}");
    assert!(REASONS.contains(&word(line, "reason")), "{line}");
    let spindle = &line["spindle"];
    assert_eq!(keys(spindle), ["locked", "notch_hz", "rpm", "source"]);
    assert!(SOURCES.contains(&word(spindle, "source")), "{line}");
    let speed = spindle["rpm"].as_f64();
    assert_eq!(speed.is_none(), spindle["source"] == "unknown", "{line}");
    assert!(speed.is_none_or(|rpm| rpm > 0.0), "{line}");
    let locked = spindle["locked"].as_bool().expect("true or false");
    assert_eq!(number(spindle, "notch_hz") > 0.0, locked, "{line}");
    if !line["amplitude"].is_null() {
        let amplitude = &line["amplitude"];
        assert_eq!(keys(amplitude), ["f", "s", "verdict", "z"]);
        assert!(number(amplitude, "f") > 0.0, "{line}");
        assert!(number(amplitude, "s") >= 0.0, "{line}");
        let verdict = word(amplitude, "verdict");
        assert!(VERDICTS.contains(&verdict), "{line}");
        let z = number(amplitude, "z");
        assert!(verdict != "self-excited" || z < -2.32, "{line}");
    }
    assert!(STATES.contains(&word(line, "state")), "{line}");
    let modes = line["modes"].as_array().expect("modes is an array");
    let mut before = 0.0;
    for mode in modes {
        assert_eq!(
            keys(mode),
            [
                "amplitude",
                "f",
                "f_sd",
                "harmonic",
                "label",
                "origin",
                "time_left",
                "zeta",
                "zeta_sd"
            ]
        );
        let f = number(mode, "f");
        assert!(f >= before, "modes are not sorted: {line}");
        before = f;
        assert!(f <= f64::from(FS), "{line}");
        for key in ["f_sd", "zeta_sd", "amplitude"] {
            assert!(number(mode, key) >= 0.0, "{key} of {line}");
        }
        assert!(number(mode, "zeta").abs() <= 1.0, "{line}");
        let label = word(mode, "label");
        assert!(LABELS.contains(&label), "{line}");
        assert!(ORIGINS.contains(&word(mode, "origin")), "{line}");
        let left = &mode["time_left"];
        assert!(left.is_null() || number(mode, "time_left") >= 0.0, "{line}");
        match &mode["harmonic"] {
            Value::Null => {}
            k => assert!(k.as_u64().is_some_and(|k| k > 0), "{line}"),
        }
    }
}

fn check_summary(summary: &Value, order: [u64; 2]) {
    assert_eq!(
        keys(summary),
        [
            "alarms",
            "fs",
            "notices",
            "order",
            "removed_db",
            "samples",
            "spindle",
            "state_seconds"
        ]
    );
    assert_eq!(summary["notices"], serde_json::json!([]));
    let spindle = &summary["spindle"];
    assert_eq!(
        keys(spindle),
        ["locked_s", "notch_hz", "rpm_first", "rpm_last"]
    );
    let locked_s = number(spindle, "locked_s");
    assert!((0.0..=SECONDS as f64).contains(&locked_s), "{summary}");
    assert_eq!(summary["removed_db"].is_null(), locked_s == 0.0);
    assert_eq!(number(summary, "fs"), f64::from(FS));
    assert_eq!(summary["samples"].as_u64(), Some(SAMPLES as u64));
    assert_eq!(summary["order"], serde_json::json!(order));
    for alarm in summary["alarms"].as_array().expect("alarms is an array") {
        // What advice holds is asked in advise_command.rs; a short alarm has no median.
        let of_lines = ["zeta_deviation", "zeta_median"];
        let own = keys(alarm).into_iter();
        let own = own.filter(|key| *key != "advice" && !of_lines.contains(key));
        assert!(own.eq(["f", "off", "on", "zeta"]), "{alarm}");
        let there = of_lines.map(|key| alarm.get(key).is_some());
        assert_eq!(there[0], there[1], "{alarm}");
        if there[0] {
            assert!(number(alarm, "zeta_deviation") >= 0.0, "{alarm}");
            assert!(number(alarm, "zeta_median") < 0.04, "{alarm}");
        }
        let on = number(alarm, "on");
        match &alarm["off"] {
            Value::Null => {}
            off => assert!(off.as_f64().is_some_and(|off| off > on), "{alarm}"),
        }
        number(alarm, "f");
        number(alarm, "zeta");
    }
    let states = summary["state_seconds"].as_object().expect("an object");
    let mut sum = 0.0;
    for (state, seconds) in states {
        assert!(STATES.contains(&state.as_str()), "{state}");
        sum += seconds.as_f64().expect("seconds");
    }
    let duration = SAMPLES as f64 / f64::from(FS);
    assert!(
        (duration - sum).abs() <= DECISION + 1e-9,
        "states sum up to {sum} of {duration} s"
    );
}

#[test]
fn monitor_says_every_field_and_nothing_else() {
    let folder = Folder::default();
    let file = damped(&folder);
    for (p, q) in [
        (2, 1),
        (2, 2),
        (4, 3),
        (4, 4),
        (6, 5),
        (6, 6),
        (8, 7),
        (8, 8),
    ] {
        let ended = monitor(&file, &format!("--order {p},{q}"));
        assert_eq!(
            (ended.code, ended.stderr.as_str()),
            (Some(0), ""),
            "{p},{q}"
        );
        let (lines, summary) = ended.monitored();
        lines.iter().for_each(check_line);
        check_summary(&summary, [p, q]);
        let most = lines
            .iter()
            .map(|l| l["modes"].as_array().map_or(0, Vec::len))
            .max();
        assert!(
            most.is_some_and(|n| n >= 1 && n <= p as usize / 2),
            "{p},{q}: {most:?}"
        );
        assert_eq!(word(&lines[0], "state"), "starting");
        assert_eq!(word(&lines[lines.len() - 1], "state"), "stable");
    }
}

#[test]
fn lines_come_every_hundredth_second_and_as_often_as_asked() {
    let folder = Folder::default();
    let file = damped(&folder);
    for (options, every) in [
        ("", 0.01),
        ("--every 0.05", 0.05),
        ("--every 0.5", 0.5),
        // No more often than decisions are made.
        ("--every 0.0001", DECISION),
    ] {
        let (lines, _) = monitor(&file, options).monitored();
        let wanted = SAMPLES as f64 / f64::from(FS) / every;
        assert!(
            (lines.len() as f64 - wanted).abs() <= 1.0,
            "{} lines for {wanted}",
            lines.len()
        );
        for (k, line) in lines.iter().enumerate() {
            let late = number(line, "t") - (k + 1) as f64 * every;
            assert!(
                (-1e-9..DECISION).contains(&late),
                "{options}: line {k}: {line}"
            );
        }
    }
}

#[test]
fn alarm_is_in_the_summary_and_in_the_exit_code() {
    let folder = Folder::default();
    let file = tone_in_a_cut(&folder, 915.0);
    let ended = monitor(&file, "--rpm 1800 --teeth 6");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(1), ""));
    let (lines, summary) = ended.monitored();
    lines.iter().for_each(check_line);
    check_summary(&summary, [8, 7]);
    let alarms = summary["alarms"].as_array().expect("alarms");
    assert_eq!(alarms.len(), 1, "{summary}");
    let advised = lines.iter().filter(|line| line.get("advice").is_some());
    let at: Vec<f64> = advised.map(|line| number(line, "t")).collect();
    let on = number(&alarms[0], "on");
    assert!(
        at.len() == 1 && (on..on + 0.02).contains(&at[0]),
        "{on} {at:?}"
    );
    assert!((number(&alarms[0], "f") - 915.0).abs() < 1.0, "{summary}");
    assert_eq!(alarms[0]["off"], Value::Null, "the tone never ends");
    assert!(number(&alarms[0], "zeta") < 0.01);
    let last = &lines[lines.len() - 1];
    assert_eq!(word(last, "state"), "chatter");
    let mode = nearest(last, 915.0);
    assert_eq!(word(mode, "label"), "self-excited");
    assert_eq!(mode["harmonic"], Value::Null);
    assert_eq!(word(mode, "origin"), "free");
    assert_eq!(last["amplitude"]["verdict"], "self-excited", "{last}");
    let s = number(&last["amplitude"], "s");
    assert!(s > 0.0 && s < 0.1, "{last}");
    // Peak amplitude in fractions of full scale.
    assert!((number(mode, "amplitude") - 0.2).abs() < 0.02, "{mode}");
}

#[test]
fn multiple_of_the_speed_is_forced_and_no_alarm() {
    let folder = Folder::default();
    let file = tone_in_noise(&folder, 900.0);
    // Without the speed nothing tells it from chatter: undamped from the first sample
    // on it may be either, and the monitor says so instead of calling it.
    let ended = monitor(&file, "");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["alarms"], serde_json::json!([]));
    for (line, mode) in forced_late(&lines) {
        assert_eq!(word(line, "state"), "warning", "{line}");
        assert_eq!(word(line, "reason"), "origin-unknown", "{line}");
        assert_eq!(word(mode, "origin"), "unknown", "{line}");
    }
    for options in ["--rpm 1800 --teeth 6", "--rpm 1800"] {
        let ended = monitor(&file, options);
        assert_eq!(ended.code, Some(0), "{options}");
        let (lines, summary) = ended.monitored();
        assert_eq!(summary["alarms"], serde_json::json!([]));
        for (line, mode) in forced_late(&lines) {
            assert_eq!(mode["harmonic"], 30, "{line}");
            assert_eq!(word(mode, "origin"), "rotation", "{line}");
            assert_eq!(word(line, "reason"), "forced-only", "{line}");
            assert_eq!(word(line, "state"), "stable", "{line}");
        }
    }
}

/// After a second, every line and its mode at 900 Hz, which is forced.
fn forced_late(lines: &[Value]) -> Vec<(&Value, &Value)> {
    let late: Vec<&Value> = lines.iter().filter(|l| number(l, "t") > 1.0).collect();
    assert!(late.len() > 190);
    late.into_iter()
        .map(|line| {
            let mode = nearest(line, 900.0);
            assert!((number(mode, "f") - 900.0).abs() < 2.0, "{line}");
            assert_eq!(word(mode, "label"), "forced", "{line}");
            (line, mode)
        })
        .collect()
}

fn nearest(line: &Value, f_hz: f64) -> &Value {
    let modes = line["modes"].as_array().expect("modes");
    let distance = |m: &&Value| (number(m, "f") - f_hz).abs();
    modes
        .iter()
        .min_by(|x, y| distance(x).total_cmp(&distance(y)))
        .unwrap_or_else(|| panic!("no mode in {line}"))
}
