//! Promise: a speed that a control tells while the cut goes on counts at once: its lines are
//! followed and not called, whatever the speed does; and what is wrong with such a speed is said.

use host_tests::files::Folder;
use host_tests::forced::{Forced, ForcedConfig};
use host_tests::rarma;
use host_tests::watch::each;
use rarma_core::monitor::{Monitor, MonitorConfig, MonitorError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The override is turned up, or down, by this part of the speed a second, from and to, s.
const RATE: f64 = 0.4;
const TURNED_S: (f64, f64) = (4.0, 4.5);
const SECONDS: f64 = 9.0;
/// The control tells so often, and so much later than it happens, s.
const TELLS_S: f64 = 0.02;
const LATE_S: f64 = 0.05;

fn cut(seed: u64) -> ForcedConfig {
    let mut cut = ForcedConfig::drawn(seed);
    let rate = if seed % 4 < 2 { RATE } else { -RATE };
    cut.ramp = Some((TURNED_S.0, TURNED_S.1, rate));
    cut
}

/// Turns a second at a time.
fn turning_hz(cut: &ForcedConfig, t_s: f64) -> f64 {
    let (from, to, rate) = cut.ramp.expect("a ramp");
    cut.spindle_hz * (1.0 + rate * (t_s.clamp(from, to) - from))
}

/// Alarms after the start, and the believed speed over the true one at the end.
fn heard(seed: u64, live: bool) -> (usize, f64) {
    let cut = cut(seed);
    let config = MonitorConfig {
        spindle_hz: Some(cut.spindle_hz),
        teeth: Some(cut.teeth),
        ..MonitorConfig::new(cut.fs_hz)
    };
    let mut monitor = Monitor::<f32>::new(&config).expect("in range");
    let (every, samples) = (
        (TELLS_S * cut.fs_hz) as usize,
        (SECONDS * cut.fs_hz) as usize,
    );
    let (mut alarms, mut last) = (0, f64::NAN);
    for (n, x) in Forced::new(cut.clone()).take(samples).enumerate() {
        let t_s = n as f64 / cut.fs_hz;
        if live && n % every == 0 {
            let told_hz = turning_hz(&cut, t_s - LATE_S);
            monitor.tell_speed(told_hz as f32).expect("in range");
        }
        if let Some(report) = monitor.push(x as f32) {
            let called = matches!(report.event, rarma_core::decide::AlarmEvent::On { .. });
            alarms += usize::from(called && t_s > 1.0);
            last = report.spindle.spindle_hz.map_or(f64::NAN, f64::from);
        }
    }
    (alarms, last / turning_hz(&cut, SECONDS))
}

#[test]
fn lines_of_a_speed_that_is_told_live_are_followed_and_not_called() {
    let seeds: Vec<u64> = (0..8).collect();
    let live = each(seeds.clone(), |seed| heard(seed, true));
    let untold = each(seeds, |seed| heard(seed, false));
    println!("told live {live:?}\nnot told {untold:?}");
    for (seed, (alarms, ratio)) in live.iter().enumerate() {
        assert_eq!(*alarms, 0, "seed {seed}");
        assert!((ratio - 1.0).abs() < 0.003, "seed {seed}: {ratio}");
    }
    // Else the promise would be empty.
    let wrong = |(alarms, ratio): &&(usize, f64)| *alarms > 0 || !((ratio - 1.0).abs() < 0.003);
    assert!(untold.iter().filter(wrong).count() >= 2, "{untold:?}");
}

#[test]
fn a_speed_that_is_none_is_refused_and_changes_nothing() {
    let mut monitor = Monitor::<f32>::new(&MonitorConfig::new(8000.0)).expect("in range");
    for hz in [f32::NAN, f32::INFINITY, 0.0, -50.0, 5001.0] {
        assert_eq!(monitor.tell_speed(hz), Err(MonitorError::Spindle), "{hz}");
    }
    monitor.tell_speed(50.0).expect("in range");
}

fn recording(folder: &Folder) -> (PathBuf, ForcedConfig) {
    let cut = cut(2);
    let samples = (SECONDS * cut.fs_hz) as usize;
    let x: Vec<f64> = Forced::new(cut.clone()).take(samples).collect();
    (folder.pcm16("cut.wav", cut.fs_hz as u32, &x), cut)
}

fn told(folder: &Folder, text: &str) -> PathBuf {
    let path = folder.path().join("speed.csv");
    std::fs::write(&path, text).expect("written");
    path
}

fn options(speeds: &Path, teeth: u32) -> String {
    format!("--speed-from {} --teeth {teeth} --json", speeds.display())
}

#[test]
fn the_program_takes_a_file_of_speeds() {
    let folder = Folder::default();
    let (wav, cut) = recording(&folder);
    let mut text = "# from the control\ntime,rpm\n".to_owned();
    for k in 0..(SECONDS / TELLS_S) as u32 {
        let t_s = f64::from(k) * TELLS_S;
        text += &format!("{t_s:.3},{:.2}\n", 60.0 * turning_hz(&cut, t_s - LATE_S));
    }
    let ended = rarma!().on("monitor", &wav, &options(&told(&folder, &text), cut.teeth));
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["alarms"], serde_json::json!([]));
    let rpm = lines.last().expect("lines")["spindle"]["rpm"].as_f64();
    let true_rpm = 60.0 * turning_hz(&cut, SECONDS);
    assert!(
        (rpm.expect("a speed") / true_rpm - 1.0).abs() < 0.003,
        "{rpm:?}"
    );
}

/// Runs `monitor` with this on standard input.
fn fed(options: &[&str], bytes: &[u8]) -> (Option<i32>, String, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .arg("monitor")
        .args(options)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    // A program that refuses does not read on.
    let _ = child.stdin.take().expect("a pipe").write_all(bytes);
    let output = child.wait_with_output().expect("ended");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn speeds_come_on_standard_input_too() {
    let folder = Folder::default();
    let (wav, cut) = recording(&folder);
    let file = wav.to_str().expect("UTF-8");
    let rpm = 60.0 * cut.spindle_hz;
    let speeds = format!("0,{rpm}\n4.3,{}\n", 0.8 * rpm);
    let teeth = cut.teeth.to_string();
    let told = ["--speed-from", "-", "--teeth", &teeth, "--json"];
    let (code, stdout, stderr) = fed(&[&[file][..], &told].concat(), speeds.as_bytes());
    assert_eq!((code, stderr.as_str()), (Some(0), ""));
    let last = stdout
        .lines()
        .rev()
        .nth(1)
        .expect("a line before the summary");
    let last: serde_json::Value = serde_json::from_str(last).expect("JSON");
    let heard = last["spindle"]["rpm"].as_f64().expect("a speed");
    assert!((heard / (0.8 * rpm) - 1.0).abs() < 0.003, "{heard}");
    let (code, _, stderr) = fed(&[&["-"][..], &told].concat(), b"");
    assert_eq!(code, Some(2));
    assert!(stderr.contains("--speed-from -"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_followed_beside_a_live_sound() {
    let folder = Folder::default();
    let (wav, cut) = recording(&folder);
    let pipe = folder.path().join("speeds");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    let rpm = 60.0 * cut.spindle_hz;
    let writes = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::write(pipe, format!("0,{rpm}\nno speed\n4.3,{}\n", 0.8 * rpm))
    });
    let sound = std::fs::read(wav).expect("a recording");
    let (teeth, pipe) = (cut.teeth.to_string(), pipe.to_str().expect("UTF-8"));
    let options = ["-", "--speed-from", pipe, "--teeth", &teeth, "--json"];
    let (code, stdout, stderr) = fed(&options, &sound);
    writes.join().expect("a thread").expect("written");
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("speeds: line 2"), "{stderr}");
    let last = stdout
        .lines()
        .rev()
        .nth(1)
        .expect("a line before the summary");
    let last: serde_json::Value = serde_json::from_str(last).expect("JSON");
    let heard = last["spindle"]["rpm"].as_f64().expect("a speed");
    assert!((heard / (0.8 * rpm) - 1.0).abs() < 0.003, "{heard}");
}

#[test]
fn what_is_wrong_with_a_file_of_speeds_is_said_before_anything_is_heard() {
    let folder = Folder::default();
    let (wav, cut) = recording(&folder);
    for (text, said) in [
        ("0,4500\n2,4600\n1,4700\n", "line 3: 1 s comes after 2 s"),
        ("0,4500\n1,NaN\n", "line 2: 'NaN' in column 2"),
        ("0,4500\n1,-300001\n", "line 2: 300001 1/min is no speed"),
        ("0\n", "line 1: no value in column 2"),
        ("", "there is no speed in it"),
    ] {
        let ended = rarma!().on("monitor", &wav, &options(&told(&folder, text), cut.teeth));
        assert_eq!(ended.code, Some(3), "{text}: {ended:?}");
        assert!(ended.stderr.contains(said), "{text}: {}", ended.stderr);
        assert!(ended.stdout.is_empty(), "{text}");
    }
    let ended = rarma!().on("monitor", &wav, "--speed-from nowhere.csv");
    assert_eq!(ended.code, Some(3));
    assert!(ended.stderr.contains("nowhere.csv"), "{}", ended.stderr);
}

/// Spindle speeds of the verdicts before and after, Hz, without those that nobody knows.
fn told_by(said: &str, text: &str) -> (Vec<f64>, Vec<f64>) {
    let folder = Folder::default();
    let scenario = folder.path().join("live.toml");
    let text = format!(
        "name = \"live\"\nabout = \"the speed is told while it listens\"\nduration_s = 2.0\nhears = \"chatter-onset\"\nhost = [{text}]\n"
    );
    std::fs::write(&scenario, text).expect("a scenario");
    let ended = rarma!().run(["box", "--sim", scenario.to_str().expect("UTF-8"), "--json"]);
    assert_eq!(ended.code, Some(0), "{said}: {ended:?}");
    let speeds = ended.json_lines().into_iter().filter_map(|line| {
        let verdict = &line["message"]["Verdict"];
        let hz = verdict["spindle"]["hz"].as_f64()?;
        Some((verdict["sample"].as_f64()? / 48_000.0, hz))
    });
    let (before, after): (Vec<_>, Vec<_>) = speeds.partition(|(t_s, _)| *t_s < 1.0);
    let hz = |all: Vec<(f64, f64)>| all.into_iter().map(|(_, hz)| hz).collect();
    (
        hz(before),
        hz(after.into_iter().filter(|(t_s, _)| *t_s > 1.1).collect()),
    )
}

/// The scenario's own setting is 28 Hz; the mode is not started anew.
#[test]
fn the_box_takes_a_speed_while_it_listens() {
    let (before, after) = told_by("set", "{ at_s = 1.0, say = \"set monitor.spindle 40\" }");
    assert!(!before.is_empty() && before.iter().all(|hz| (hz - 28.0).abs() < 0.3));
    assert!(
        !after.is_empty() && after.iter().all(|hz| (hz - 40.0).abs() < 0.3),
        "{after:?}"
    );
    let (_, left) = told_by("another", "{ at_s = 1.0, say = \"set tell.status 0.3\" }");
    assert!(left.iter().all(|hz| (hz - 28.0).abs() < 0.3), "{left:?}");
}
