//! Promise: what the monitor says of every real recording of machining is known, and
//! how often it is wrong.
//!
//! One line for each file: what its meta.json says and who labelled it, the verdict
//! with the stated speed and teeth and without, the time from the labelled onset to the
//! alarm, and the false alarms. `cargo test --release -p host-tests --test
//! recordings_table -- --nocapture` prints it.

use host_tests::bars::holds;
use host_tests::rarma;
use host_tests::resources::{Known, shared_or_skip};
use serde_json::Value;
use std::path::Path;

/// Who says what, and where chatter is known to be or to be absent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Label {
    /// Chatter in the segments that meta.json names; none elsewhere.
    Chatter,
    /// No chatter.
    Stable,
    /// Two operators, path by path; times of another sensor.
    Paths,
    /// Nobody has said.
    Unknown,
}

const FILES: [(&str, Label, &str); 12] = [
    ("hafez_mill_sound/chatter", Label::Chatter, "author, by ear"),
    ("hafez_mill_sound/stable", Label::Stable, "author, by ear"),
    ("hafez_mill_sound/idle_sound", Label::Stable, "author: air"),
    (
        "purdue_mt_cutting_video_audio/Exp0-1_video_audio",
        Label::Paths,
        "two operators",
    ),
    (
        "shamaseen_tool_sound/RPM635BASE0001",
        Label::Unknown,
        "file name: fresh tool",
    ),
    (
        "shamaseen_tool_sound/RPM635BASE0013",
        Label::Unknown,
        "file name: fresh tool",
    ),
    (
        "yang_hurco_accel/EBI_F18IN_T50_D0p125_3000RPM_5A_ON_VICE_X",
        Label::Unknown,
        "nobody; synchronous by spectrum",
    ),
    (
        "yang_hurco_accel/EBI_F18IN_T75_D0p125_3000RPM_5AXYZ_X",
        Label::Unknown,
        "nobody; synchronous by spectrum",
    ),
    (
        "yang_hurco_accel/EBI_F20IN_T50_D0p05IN_4000RPM_X",
        Label::Unknown,
        "nobody; synchronous by spectrum",
    ),
    (
        "yang_hurco_accel/EBI_T25_0p125IN_6000RPMto6900RPM_X",
        Label::Unknown,
        "nobody; speed changes",
    ),
    (
        "yang_hurco_accel/EBI_T50_0p25IN_6900RPM_X",
        Label::Unknown,
        "nobody; asynchronous 275 and 735 Hz by spectrum",
    ),
    (
        "yang_hurco_accel/EBI_T50_0p25IN_6900RPM_Y",
        Label::Unknown,
        "nobody; asynchronous 275 and 735 Hz by spectrum",
    ),
];

/// What the operators said of an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    Stable,
    Disputed,
    Chatter,
    NotCutting,
}

/// One alarm: on, off (s), frequency (Hz).
fn alarms(path: &Path, options: &str) -> Vec<(f64, Option<f64>, f64)> {
    let ended = rarma!().on("monitor", path, &format!("{options} --every 1 --json"));
    let (_, summary) = ended.monitored();
    let alarms = summary["alarms"].as_array().expect("alarms").iter();
    let number = |alarm: &Value, key: &str| alarm[key].as_f64();
    alarms
        .map(|a| {
            let (on, f) = (number(a, "on"), number(a, "f"));
            (on.expect("on"), number(a, "off"), f.expect("f"))
        })
        .collect()
}

/// `--rpm` and `--teeth` as the meta.json states them; none if it does not.
fn stated(meta: &Value) -> Option<String> {
    let rpm = match &meta["spindle_rpm"] {
        Value::Array(speeds) => speeds.first()?.as_f64()?,
        one => one.as_f64()?,
    };
    let teeth = meta["teeth"].as_u64();
    let teeth = teeth.map_or_else(String::new, |z| format!(" --teeth {z}"));
    Some(format!("--rpm {rpm}{teeth}"))
}

/// What the operators said of the instant `t`, s, of the video's sound.
fn operators(meta: &Value, t: f64) -> Said {
    let offset = meta["video_minus_sensor_time_s"]
        .as_f64()
        .expect("an offset");
    let paths = meta["labels_from_repo"].as_array().expect("paths");
    let number = |path: &Value, key: &str| path[key].as_f64().expect("a number");
    let at = paths
        .iter()
        .find(|path| (number(path, "start") + offset..number(path, "end") + offset).contains(&t));
    let Some(path) = at else {
        return Said::NotCutting;
    };
    match (
        number(path, "Chatter (operator 1)") > 0.0,
        number(path, "Chatter (operator 2)") > 0.0,
    ) {
        (false, false) => Said::Stable,
        (true, true) => Said::Chatter,
        _ => Said::Disputed,
    }
}

/// One run of one file.
fn line(known: &Known, name: &str, label: Label, by: &str, options: &str) {
    let alarms = alarms(&known.path, options);
    let minutes = known.recording.seconds / 60.0;
    let words = match alarms.len() {
        0 => "no alarm".to_owned(),
        n => {
            let of: Vec<String> = alarms
                .iter()
                .take(3)
                .map(|(on, off, f)| {
                    let off = off.map_or("end".to_owned(), |t| format!("{t:.2}"));
                    format!("{f:.1} Hz {on:.2}–{off} s")
                })
                .collect();
            format!("{n} alarms: {}", of.join("; "))
        }
    };
    let bar = |what: &str| format!("recordings: {what}, {name} `{options}`");
    let (onset, wrong) = match label {
        Label::Chatter => {
            let (entry, _) = known.segment("entry_transition");
            let (from, to) = known.segment("chatter");
            let right = |on: f64| (entry..to).contains(&on);
            let first = alarms
                .iter()
                .find(|a| right(a.0))
                .map(|a| 1e3 * (a.0 - from));
            // The label is by ear, and the entry before it lasts a second.
            holds(
                &bar("onset, ms"),
                first.unwrap_or(f64::NAN),
                -1000.0..=500.0,
            );
            let wrong = alarms.iter().filter(|a| !right(a.0)).count();
            (
                first.map_or("missed".to_owned(), |ms| format!("{ms:.0}")),
                Some(wrong),
            )
        }
        Label::Stable => ("-".to_owned(), Some(alarms.len())),
        Label::Paths => {
            let said: Vec<Said> = alarms.iter().map(|a| operators(&known.meta, a.0)).collect();
            let count = |wanted| said.iter().filter(|s| **s == wanted).count();
            let [stable, idle, disputed] =
                [Said::Stable, Said::NotCutting, Said::Disputed].map(count);
            (
                format!(
                    "- (in stable paths {stable}, between paths {idle}, disputed path {disputed})"
                ),
                Some(stable + idle),
            )
        }
        Label::Unknown => ("-".to_owned(), None),
    };
    let false_alarms = match wrong {
        None => "not labelled".to_owned(),
        Some(n) => {
            holds(&bar("false alarms"), n as f64, 0.0..=0.0);
            format!("{n} in {minutes:.2} min")
        }
    };
    println!(
        "| {name} | {label:?}: {by} | {} | {words} | {onset} | {false_alarms} |",
        if options.is_empty() { "-" } else { options }
    );
}

#[test]
fn every_recording_of_machining() {
    let Some(shared) = shared_or_skip("every_recording_of_machining") else {
        return;
    };
    println!("| file | label: by whom | told | said | onset to alarm, ms | false alarms |");
    println!("|---|---|---|---|---|---|");
    for (name, label, by) in FILES {
        let known = Known::read(&shared, name);
        let short = name.rsplit('/').next().expect("a name");
        if let Some(options) = stated(&known.meta) {
            line(&known, short, label, by, &options);
        }
        line(&known, short, label, by, "");
    }
}
