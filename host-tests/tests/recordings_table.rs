//! Promise: what the monitor says of every real recording of machining is known, how often it
//! is wrong, and the documentation says the same.
//!
//! The tables of docs/bench.md, docs/verdict.md and docs/limits.md that are about recordings are
//! made here and compared: `RARMA_WRITE_TABLE=1 cargo test --release -p host-tests --test
//! recordings_table` writes them.

use host_tests::bars::{all_judged, holds};
use host_tests::files::Folder;
use host_tests::resources::{Known, shared_or_skip};
use host_tests::statistics::quantile;
use host_tests::watch::each;
use host_tests::{page, rarma};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
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

/// File, label and who labelled it.
const FILES: [(&str, Label, &str); 12] = [
    (
        "hafez_mill_sound/chatter",
        Label::Chatter,
        "the author by ear",
    ),
    (
        "hafez_mill_sound/stable",
        Label::Stable,
        "the author by ear",
    ),
    (
        "hafez_mill_sound/idle_sound",
        Label::Stable,
        "the author: air",
    ),
    (
        "purdue_mt_cutting_video_audio/Exp0-1_video_audio",
        Label::Paths,
        "two operators: 19 of 20 paths stable, one disputed",
    ),
    (
        "shamaseen_tool_sound/RPM635BASE0001",
        Label::Unknown,
        "nobody; a fresh tool by the name",
    ),
    (
        "shamaseen_tool_sound/RPM635BASE0013",
        Label::Unknown,
        "nobody; a fresh tool by the name",
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
        "nobody; the speed changes, synchronous by spectrum",
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

/// What the monitor said of a file.
struct Heard {
    /// On, off (s) and frequency, Hz.
    alarms: Vec<(f64, Option<f64>, f64)>,
    /// Lowest damping ratio in an alarm.
    lowest: Option<f64>,
    /// Parts of the time for which these reasons stood.
    besides: [(&'static str, f64); 2],
}

fn hear(path: &Path, options: &str) -> Heard {
    let (lines, summary) = rarma!()
        .on("monitor", path, &format!("{options} --json"))
        .monitored();
    let alarms = summary["alarms"].as_array().expect("alarms");
    let number = |alarm: &Value, key: &str| alarm[key].as_f64();
    let alarm = |a: &Value| {
        let (on, f) = (number(a, "on"), number(a, "f"));
        (on.expect("on"), number(a, "off"), f.expect("f"))
    };
    Heard {
        alarms: alarms.iter().map(alarm).collect(),
        lowest: alarms
            .iter()
            .filter_map(|a| number(a, "zeta"))
            .min_by(f64::total_cmp),
        besides: ["origin-unknown", "blind-at-multiple"].map(|reason| {
            let told = lines.iter().filter(|line| line["reason"] == reason).count();
            (reason, told as f64 / lines.len() as f64)
        }),
    }
}

impl Heard {
    /// The alarms in words.
    fn words(&self) -> String {
        if self.alarms.is_empty() {
            return "no alarm".to_owned();
        }
        let of = self.alarms.iter().map(|(on, off, f)| {
            let off = off.map_or("the end".to_owned(), |t| format!("{t:.2} s"));
            format!("{f:.1} Hz from {on:.2} to {off}")
        });
        of.collect::<Vec<_>>().join("; ")
    }

    /// What was told besides, where it stood for a hundredth of the time.
    fn besides(&self) -> String {
        let told = self.besides.iter().filter(|(_, part)| *part >= 0.01);
        let words: Vec<String> = told
            .map(|(word, part)| format!("`{word}` {part:.2}"))
            .collect();
        words.join(", ")
    }
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

/// Onset and false alarms of one run, held to none that is wrong, in words.
fn judged(known: &Known, label: Label, heard: &Heard, of: &str) -> (String, String) {
    let bar = |what: &str| format!("recordings: {what}, {of}");
    let alarms = &heard.alarms;
    let mut onset = String::new();
    let wrong = match label {
        Label::Chatter => {
            let (entry, _) = known.segment("entry_transition");
            let (from, to) = known.segment("chatter");
            let right = |on: f64| (entry..to).contains(&on);
            let first = alarms.iter().find(|a| right(a.0));
            let ms = first.map_or(f64::NAN, |a| 1e3 * (a.0 - from));
            // The label is by ear, and the entry before it lasts a second.
            holds(&bar("onset, ms"), ms, -1000.0..=500.0);
            onset = format!("{ms:.0}");
            alarms.iter().filter(|a| !right(a.0)).count()
        }
        Label::Stable => alarms.len(),
        // A disputed path counts neither way.
        Label::Paths => {
            let said = alarms.iter().map(|a| operators(&known.meta, a.0));
            said.filter(|s| matches!(s, Said::Stable | Said::NotCutting))
                .count()
        }
        Label::Unknown => return (onset, "not labelled".to_owned()),
    };
    holds(&bar("false alarms"), wrong as f64, 0.0..=0.0);
    let minutes = known.recording.seconds / 60.0;
    (onset, format!("{wrong} in {minutes:.2} min"))
}

#[test]
fn every_recording_of_machining() {
    let Some(shared) = shared_or_skip("every_recording_of_machining") else {
        return;
    };
    let mut all = "| file | label, by whom | told | order | said | besides, part of the time | onset, ms | false alarms |\n|---|---|---|---|---|---|---|---|\n".to_owned();
    let mut short = "| recording | speed | at (8,7) | at (6,5) |\n|---|---|---|---|\n".to_owned();
    for (name, label, by) in FILES {
        let known = Known::read(&shared, name);
        let file = name.rsplit('/').next().expect("a name");
        for speed in known.stated().into_iter().chain([String::new()]) {
            let (told, word) = match speed.as_str() {
                "" => ("nothing", "not told"),
                speed => (speed, "told"),
            };
            let both = each(vec!["8,7", "6,5"], |order| {
                (
                    order,
                    hear(&known.path, &format!("{speed} --order {order}")),
                )
            });
            for (order, heard) in &both {
                let of = format!("{file}, {told}, ({order})");
                let (onset, wrong) = judged(&known, label, heard, &of);
                let (said, besides) = (heard.words(), heard.besides());
                // Writing to a String cannot fail.
                let _ = writeln!(
                    all,
                    "| {file} | {by} | {told} | ({order}) | {said} | {besides} | {onset} | {wrong} |"
                );
            }
            let words: Vec<String> = both.iter().map(|(_, heard)| heard.words()).collect();
            let _ = writeln!(short, "| {file} | {word} | {} |", words.join(" | "));
        }
    }
    all_judged("recordings");
    page::holds("docs/bench.md", "recordings", &all);
    page::holds("docs/verdict.md", "recordings", &short);
}

/// Orders and bands for the recording of chatter.
const ORDERS: [(&str, &str); 9] = [
    ("2,1", "300:2500"),
    ("2,2", "300:2500"),
    ("4,3", "300:2500"),
    ("4,3", "650:1150"),
    ("4,4", "300:2500"),
    ("6,5", "300:2500"),
    ("6,6", "300:2500"),
    ("8,7", "300:2500"),
    ("8,8", "300:2500"),
];

#[test]
fn what_order_and_band_hear_of_the_chatter() {
    let Some(shared) = shared_or_skip("what_order_and_band_hear_of_the_chatter") else {
        return;
    };
    let hear = |name: &str, options: &str| {
        hear(
            &shared.join(format!("hafez_mill_sound/{name}.wav")),
            options,
        )
    };
    let rows = each(ORDERS.to_vec(), |(order, band)| {
        let not_told = format!("--order {order} --band {band}");
        let told = format!("--rpm 1656 --teeth 6 {not_told}");
        for quiet in ["stable", "idle_sound"] {
            for options in [&told, &not_told] {
                let heard = hear(quiet, options);
                assert!(
                    heard.alarms.is_empty(),
                    "{quiet} {options}: {}",
                    heard.words()
                );
            }
        }
        let (with, without) = (hear("chatter", &told), hear("chatter", &not_told));
        let lowest = with
            .lowest
            .map_or(String::new(), |z| format!("{:.2} %", 100.0 * z));
        let (with, without) = (with.words(), without.words());
        format!("| ({order}) | {band} | {with} | {lowest} | {without} |\n")
    });
    let head = "| order | band, Hz | with the speed | lowest ζ | without the speed |\n|---|---|---|---|---|\n";
    let table = head.to_owned() + &rows.concat();
    page::holds("docs/bench.md", "orders", &table);
    page::holds("docs/limits.md", "orders", &table);
}

#[test]
fn the_chatter_before_during_and_after() {
    let Some(shared) = shared_or_skip("the_chatter_before_during_and_after") else {
        return;
    };
    let file = shared.join("hafez_mill_sound/chatter.wav");
    let ended = rarma!().on("monitor", &file, "--rpm 1656 --teeth 6 --json");
    let (lines, _) = ended.monitored();
    let loudest = |line: &Value| {
        let modes = line["modes"].as_array()?.iter();
        let of = |mode: &Value| (mode["amplitude"].as_f64(), mode["zeta"].as_f64());
        modes
            .map(of)
            .max_by(|a, b| a.0.partial_cmp(&b.0).expect("numbers"))?
            .1
    };
    let mut table = "| part of `chatter` | s | ζ of the loudest mode, median of the lines | amplitude, lines |\n|---|---|---|---|\n".to_owned();
    for (part, from, to) in [
        ("air", 0.3, 1.0),
        ("chatter", 2.5, 15.5),
        ("after it", 16.2, 18.4),
    ] {
        let inside = |line: &&Value| line["t"].as_f64().is_some_and(|t| (from..to).contains(&t));
        let of: Vec<&Value> = lines.iter().filter(inside).collect();
        let zeta: Vec<f64> = of.iter().filter_map(|line| loudest(line)).collect();
        let mut verdicts = BTreeMap::<&str, usize>::new();
        for line in of.iter().filter(|line| line["state"] == "chatter") {
            *verdicts
                .entry(line["amplitude"]["verdict"].as_str().unwrap_or("none"))
                .or_default() += 1;
        }
        let words: Vec<String> = verdicts.iter().map(|(v, n)| format!("`{v}` {n}")).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "| {part} | {from} to {to} | {:.2} % | {} |",
            100.0 * quantile(&zeta, 0.5),
            words.join(", ")
        );
    }
    page::holds("docs/bench.md", "chatter", &table);
}

#[test]
fn an_override_turned_in_steps() {
    let Some(shared) = shared_or_skip("an_override_turned_in_steps") else {
        return;
    };
    let known = Known::read(
        &shared,
        "yang_hurco_accel/EBI_T25_0p125IN_6000RPMto6900RPM_X",
    );
    let folder = Folder::default();
    let rate = known.recording.fs.round() as u32;
    let file = |name: &str, samples: &mut dyn Iterator<Item = &f64>| {
        let samples: Vec<f32> = samples.map(|x| *x as f32).collect();
        folder.float(name, rate, &samples)
    };
    let forth = file("forth.wav", &mut known.recording.samples.iter());
    let back = file("back.wav", &mut known.recording.samples.iter().rev());
    let rows = each(vec!["4,3", "4,4", "6,5", "6,6", "8,7", "8,8"], |order| {
        let runs = [
            (&forth, 6000),
            (&forth, 6090),
            (&forth, 5910),
            (&back, 6900),
        ];
        let parts = runs.map(|(file, rpm)| {
            let options = format!("--rpm {rpm} --order {order} --json");
            let (lines, _) = rarma!().on("monitor", file, &options).monitored();
            let called = lines
                .iter()
                .filter(|line| line["state"] == "chatter")
                .count();
            format!("{:.2}", called as f64 / lines.len() as f64)
        });
        format!("| ({order}) | {} |\n", parts.join(" | "))
    });
    let head = "| order | 6000 1/min told | 1.5 % high | 1.5 % low | played backwards, 6900 told |\n|---|---|---|---|---|\n";
    page::holds(
        "docs/bench.md",
        "override",
        &(head.to_owned() + &rows.concat()),
    );
}
