//! Promise: `rarma population` draws the same cuts for the same seeds, judges every
//! detector with every way the speed is told, and writes recordings with a list of what is
//! true of each.

use host_tests::files::Folder;
use host_tests::process::Ended;
use host_tests::rarma;
use serde_json::Value;
use std::fs;
use std::path::Path;

const SEEDS: std::ops::Range<u64> = 0..6;

fn population(options: &str, out: Option<&Path>) -> Ended {
    let seeds = format!("{}:{}", SEEDS.start, SEEDS.end);
    let mut words = vec!["population", "--seeds", &seeds];
    words.extend(options.split_whitespace());
    if let Some(out) = out.and_then(Path::to_str) {
        words.extend(["--out", out]);
    }
    rarma!().run(words)
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number: {value}"))
}

/// Times of the machine that ran it are no figures of the population.
fn without_times(ended: &Ended) -> Vec<Value> {
    let mut lines = ended.json_lines();
    for line in &mut lines {
        if let Some(line) = line.as_object_mut() {
            line.remove("took_s");
        }
    }
    lines
}

#[test]
fn every_cut_is_judged_in_every_way_and_twice_alike() {
    let options = "--told exact,none,live --json";
    let lines = without_times(&population(options, None));
    assert_eq!(lines, without_times(&population(options, None)));
    let count = (SEEDS.end - SEEDS.start) as usize;
    assert_eq!(lines.len(), count + 1);
    for (line, seed) in lines.iter().zip(SEEDS) {
        assert_eq!(line["seed"], seed);
        assert_eq!(line["results"].as_array().expect("results").len(), 3 * 4);
        let quiet = number(&line["quiet_s"]);
        assert!((0.0..=number(&line["length_s"])).contains(&quiet));
    }
    let summary = &lines[count]["summary"];
    assert_eq!(summary["cuts"], count);
    let curve = summary["curve"].as_array().expect("a curve");
    for told in ["exact", "not told", "live"] {
        for detector in ["monitor", "verdict", "plain", "bare damping"] {
            let points = curve
                .iter()
                .filter(|p| p["told"] == told && p["detector"] == detector);
            assert!(points.count() > 0, "{detector}, {told}");
        }
    }
}

#[test]
fn every_number_of_the_verdict_is_heeded() {
    let ended = population("--detectors verdict --told 1 --sensitivity --json", None);
    let summary = ended.json_lines().pop().expect("a summary")["summary"].take();
    let rows = summary["sensitivity"].as_array().expect("rows").clone();
    let figures = |row: &Value| {
        let mut row = row.clone();
        for what in ["name", "value", "told", "detector", "threshold"] {
            row.as_object_mut().expect("a row").remove(what);
        }
        row
    };
    let usual = figures(&summary["curve"][0]);
    let mut names: Vec<&str> = rows.iter().filter_map(|r| r["name"].as_str()).collect();
    names.dedup();
    let numbers = rarma_core::verdict::VerdictConfig::NUMBERS.iter();
    assert_eq!(names, numbers.map(|n| n.name).collect::<Vec<_>>());
    // In six cuts some numbers make no difference, but most do, and each is one of its own.
    let heeded = names.iter().filter(|name| {
        let of_it = rows.iter().filter(|row| row["name"] == **name);
        of_it.clone().any(|row| figures(row) != usual)
    });
    assert!(heeded.count() * 4 >= names.len() * 3, "{rows:?}");
    // The same by `--set`.
    let set = population(
        "--detectors verdict --told 1 --set memory_s=0.18 --json",
        None,
    );
    let set = set.json_lines().pop().expect("a summary")["summary"].take();
    let row = rows
        .iter()
        .find(|row| row["name"] == "memory_s" && row["value"] == 0.18)
        .expect("half");
    assert_eq!(figures(&set["curve"][0]), figures(row));
}

#[test]
fn recordings_have_what_is_true_beside_them() {
    let folder = Folder::default();
    let ended = population("--detectors none --json", Some(folder.path()));
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let text = fs::read_to_string(folder.path().join("labels.json")).expect("labels");
    let labels: Vec<Value> = serde_json::from_str(&text).expect("a list");
    assert_eq!(labels.len(), (SEEDS.end - SEEDS.start) as usize);
    let mut chatters = 0;
    for label in &labels {
        let file = folder.path().join(label["file"].as_str().expect("a name"));
        let wav = hound::WavReader::open(&file).expect("a recording");
        assert_eq!(label["fs"], wav.spec().sample_rate);
        let length_s = f64::from(wav.duration()) / f64::from(wav.spec().sample_rate);
        assert!((length_s - number(&label["sec"])).abs() < 1e-6);
        let stretches = label["stretches"].as_array().expect("stretches");
        let unstable = stretches.iter().any(|s| s[1] == "unstable");
        let chatter = label["chatter"].as_array().expect("a list");
        assert!(unstable || chatter.is_empty());
        assert_eq!(label["ints"].get(0), chatter.first());
        if label["class"] == "chatter" {
            chatters += 1;
            assert!(number(&label["f"][0]) <= number(&label["f"][1]));
        } else {
            assert!(label["undecidable"] == true || chatter.is_empty());
        }
        if label["class"] == "none" {
            let uneventful = ["air", "stable"];
            let all = stretches
                .iter()
                .all(|s| uneventful.contains(&s[1].as_str().unwrap_or_default()));
            assert!(all, "{stretches:?}");
        }
        // What a control tells is the true speed, a little late, in whole 1/min.
        let rpm = number(&label["rpm"]);
        for point in label["live"].as_array().expect("a course") {
            assert!((0.5..1.3).contains(&(number(&point[1]) / rpm)));
        }
    }
    assert!(chatters > 0);
}

#[test]
fn what_cannot_be_meant_is_wrong_usage() {
    for options in [
        "--seeds 5:5",
        "--seeds 7",
        "--seeds 0:99999999",
        "--told 2",
        "--detectors ear",
        "--set nonsense=1",
        "--set call",
        "--set call=loud",
        "--set call=NaN",
        "--set memory_s=0",
    ] {
        let ended = rarma!().run(["population"].into_iter().chain(options.split_whitespace()));
        assert_eq!(ended.code, Some(2), "{options}: {}", ended.stderr);
    }
}
