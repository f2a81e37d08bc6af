//! Promise: on the real recordings of a face mill the monitor calls the chatter
//! within a second, holds it to the end of the cut, drops it within a second after,
//! and calls nothing in the stable cut or in air.
//!
//! What is chatter, and when, is read from the meta.json beside each recording.

use host_tests::process::Ended;
use host_tests::rarma;
use host_tests::resources::{Known, shared_or_skip};
use serde_json::Value;
use std::path::Path;

/// Where the chatter is, ± what is allowed, Hz.
const CHATTER_HZ: (f64, f64) = (898.0, 6.0);

fn hear(file: &Path, options: &str) -> (Ended, Vec<Value>, Value) {
    let ended = rarma!().on("monitor", file, &format!("{options} --json"));
    // Nothing to remark, or a told speed that the sound contradicts, both named.
    let warned = ended.stderr.starts_with("Warning") && ended.stderr.contains("spindle at 448");
    assert!(
        ended.stderr.is_empty() || warned,
        "{options}: {}",
        ended.stderr
    );
    let (lines, summary) = ended.monitored();
    (ended, lines, summary)
}

/// The one alarm of a run: on, off, frequency.
fn only_alarm(summary: &Value) -> (f64, f64, f64) {
    let alarms = summary["alarms"].as_array().expect("alarms");
    let [alarm] = &alarms[..] else {
        panic!("not one alarm: {summary}");
    };
    let number = |key: &str| {
        alarm[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{key}: {alarm}"))
    };
    (number("on"), number("off"), number("f"))
}

#[test]
fn chatter_is_called_held_and_dropped() {
    let Some(shared) = shared_or_skip("chatter_is_called_held_and_dropped") else {
        return;
    };
    let known = Known::read(&shared, "hafez_mill_sound/chatter");
    let (entry, _) = known.segment("entry_transition");
    let (from, to) = known.segment("chatter");
    let speed = format!(
        "--rpm {} --teeth {}",
        known.number("spindle_rpm"),
        known.number("teeth")
    );
    for options in [speed.as_str(), ""] {
        let (ended, lines, summary) = hear(&known.path, options);
        assert_eq!(ended.code, Some(1));
        let (on, off, f) = only_alarm(&summary);
        println!("`{options}`: on {on:.3} s, off {off:.3} s, {f:.2} Hz");
        assert!((entry..=from + 1.0).contains(&on), "called at {on} s");
        assert!((to..=to + 1.0).contains(&off), "released at {off} s");
        assert!((f - CHATTER_HZ.0).abs() <= CHATTER_HZ.1, "{f} Hz");
        // The lines tell the same story as the summary.
        for line in &lines {
            let t = line["t"].as_f64().expect("a time");
            let standing = (on..off).contains(&t);
            assert_eq!(line["state"] == "chatter", standing, "{line}");
        }
    }
}

#[test]
fn idle_before_the_chatter_is_found() {
    let Some(shared) = shared_or_skip("idle_before_the_chatter_is_found") else {
        return;
    };
    // Told where idle is, the monitor calls it so, and calls the chatter all the same.
    let known = Known::read(&shared, "hafez_mill_sound/chatter");
    let (from, to) = known.segment("idle");
    let (chatter, _) = known.segment("chatter");
    let (_, lines, summary) = hear(&known.path, &format!("--idle {from}:{to} --rpm 1656"));
    let idle = lines.iter().filter(|line| line["state"] == "idle");
    let early = idle
        .filter(|line| line["t"].as_f64().is_some_and(|t| t < to))
        .count();
    assert!(early > 60, "{early} idle lines before {to} s");
    let (on, _, _) = only_alarm(&summary);
    assert!(on <= chatter + 1.0, "called at {on} s");
}

#[test]
fn stable_cut_and_air_raise_no_alarm() {
    let Some(shared) = shared_or_skip("stable_cut_and_air_raise_no_alarm") else {
        return;
    };
    for name in ["stable", "idle_sound"] {
        let known = Known::read(&shared, &format!("hafez_mill_sound/{name}"));
        // The speed of these two is not stated: without, and with those in question.
        for options in ["", "--rpm 5955 --teeth 6", "--rpm 1656 --teeth 6"] {
            let (ended, lines, summary) = hear(&known.path, options);
            assert_eq!(ended.code, Some(0), "{name} {options}");
            assert_eq!(summary["alarms"], serde_json::json!([]), "{name} {options}");
            assert!(lines.iter().all(|line| line["state"] != "chatter"));
            // It did listen.
            let judged = |line: &&Value| line["state"] == "stable" || line["state"] == "idle";
            let share = lines.iter().filter(judged).count() as f64 / lines.len() as f64;
            assert!(
                share > 0.9,
                "{name} {options}: judged {share:.2} of the time"
            );
        }
    }
}
