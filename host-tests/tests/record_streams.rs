//! Promise: what a box said in two runs, or with a gap in between, is never woven into one:
//! `decode` and `monitor` keep streams apart and say so, and a number that jumps costs a line.

use host_tests::files::Folder;
use host_tests::frames::Sender;
use host_tests::process::{Ended, Rarma};
use host_tests::{rarma, signal};
use std::fs;
use std::path::{Path, PathBuf};

const FS: u32 = 8000;

fn program() -> Rarma {
    rarma!()
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a name")
}

/// So many samples of a vibration that is healthy to listen to.
fn vibration(f_hz: f64, seed: u64, n: usize) -> Vec<i16> {
    signal::modes(&[(f_hz, 0.05)], f64::from(FS), seed)
        .map(|x| (3000.0 * x) as i16)
        .take(n)
        .collect()
}

fn record(folder: &Folder, parts: &[Vec<u8>]) -> PathBuf {
    folder.file("box.frames", &parts.concat())
}

fn decoded(record: &Path, wav: &Path, more: &str) -> Ended {
    let options = format!("--json --wav {} {more}", text(wav));
    program().on("decode", record, &options)
}

fn samples(wav: &Path) -> (u32, Vec<i16>) {
    let reader = hound::WavReader::open(wav).unwrap_or_else(|why| panic!("{}: {why}", text(wav)));
    let fs = reader.spec().sample_rate;
    let samples = reader.into_samples().map(|x| x.expect("a sample"));
    (fs, samples.collect())
}

/// Two runs of a box whose numbers both begin at 0: what used to be woven.
fn restarted(folder: &Folder) -> (PathBuf, [Vec<i16>; 2]) {
    let codes = [
        vibration(900.0, 1, 2 * FS as usize),
        vibration(1400.0, 2, FS as usize),
    ];
    let (mut first, mut second) = (Sender::new(0xA1), Sender::new(0xB2));
    let record = record(
        folder,
        &[
            first.started(f64::from(FS)),
            first.raw(0, &codes[0]),
            second.started(f64::from(FS)),
            second.raw(0, &codes[1]),
        ],
    );
    (record, codes)
}

#[test]
fn a_restart_begins_a_new_stream_in_a_file_of_its_own() {
    let folder = Folder::default();
    let (record, codes) = restarted(&folder);
    let wav = folder.path().join("out.wav");
    let ended = decoded(&record, &wav, "");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(samples(&wav), (FS, codes[0].clone()));
    assert_eq!(
        samples(&folder.path().join("out-2.wav")),
        (FS, codes[1].clone())
    );
    for says in ["stream 1: 2.000 s", "stream 2: 1.000 s", "started anew"] {
        assert!(ended.stderr.contains(says), "{says}: {}", ended.stderr);
    }
    // Every line of JSON says of which run it is.
    let lines = ended.json_lines();
    let of = |session: u32| lines.iter().filter(|l| l["session"] == session).count();
    assert_eq!(of(0xA1) + of(0xB2), lines.len());
    assert!(of(0xB2) > 60 && of(0xA1) > 130);
    // One of them by its number.
    let only = folder.path().join("only.wav");
    assert_eq!(decoded(&record, &only, "--stream 2").code, Some(0));
    assert_eq!(samples(&only).1, codes[1]);
    let ended = decoded(&record, &folder.path().join("none.wav"), "--stream 3");
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert!(!folder.path().join("none.wav").exists());
    // A file that nobody named is not replaced.
    let again = decoded(&record, &wav, "");
    assert_eq!(again.code, Some(4), "{again:?}");
    assert!(again.stderr.contains("out-2.wav"), "{again:?}");
}

#[test]
fn monitor_asks_which_stream_and_hears_that_one_only() {
    let folder = Folder::default();
    let (record, codes) = restarted(&folder);
    let ended = program().on("monitor", &record, "--json");
    assert_eq!(ended.code, Some(3), "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    let [line] = lines[..] else {
        panic!("not one line: {ended:?}")
    };
    for says in ["2 streams", "1 of 2.000 s", "2 of 1.000 s", "--stream"] {
        assert!(line.contains(says), "{line} does not say {says}");
    }
    for (stream, codes) in ["1", "2"].iter().zip(&codes) {
        let options = format!("--json --stream {stream}");
        let (heard, summary) = program().on("monitor", &record, &options).monitored();
        // The same numbers as raw floats, which have no streams.
        let bytes: Vec<u8> = codes
            .iter()
            .flat_map(|code| ((f64::from(*code) / 32_767.0) as f32).to_le_bytes())
            .collect();
        let alone = folder.file("alone.f32", &bytes);
        let (expected, whole) = program()
            .on("monitor", &alone, &format!("--json --fs {FS}"))
            .monitored();
        assert_eq!(summary["samples"], whole["samples"]);
        assert_eq!(heard.len(), expected.len());
        let f = |line: &serde_json::Value| line["modes"][0]["f"].as_f64();
        let (a, b) = (f(&heard[heard.len() - 1]), f(&expected[heard.len() - 1]));
        let (a, b) = (a.expect("a mode"), b.expect("a mode"));
        assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
    }
    let wav = folder.pcm16("a.wav", FS, &[0.1, -0.1, 0.2]);
    let ended = program().on("monitor", &wav, "--stream 1");
    assert_eq!(ended.code, Some(3), "{ended:?}");
}

/// One run with samples missing in the middle: `gap` of them.
fn with_gap(folder: &Folder, gap: u64) -> (PathBuf, Vec<i16>) {
    let codes = vibration(900.0, 1, 2 * FS as usize);
    let mut sender = Sender::new(7);
    let half = FS as usize;
    let record = record(
        folder,
        &[
            sender.started(f64::from(FS)),
            sender.raw(4000, &codes[..half]),
            sender.raw(4000 + u64::from(FS) + gap, &codes[half..]),
        ],
    );
    (record, codes)
}

#[test]
fn a_short_gap_is_zeros_that_are_told_and_the_monitor_knows() {
    let folder = Folder::default();
    let gap = FS as usize / 2;
    let (record, codes) = with_gap(&folder, gap as u64);
    let wav = folder.path().join("out.wav");
    let ended = decoded(&record, &wav, "");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let mut expected = codes.clone();
    let half = FS as usize;
    expected.splice(half..half, std::iter::repeat_n(0, gap));
    assert_eq!(samples(&wav).1, expected);
    for says in ["4000 samples are missing", "0.5000 s at 1.000 s"] {
        assert!(ended.stderr.contains(says), "{says}: {}", ended.stderr);
    }
    let ended = program().on("monitor", &record, "--json");
    assert!(ended.stderr.contains("0.5000 s at 1.000 s"), "{ended:?}");
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["samples"], expected.len());
    // Nothing is said of the gap itself; the 0.1 s after it say why.
    let t = |line: &serde_json::Value| line["t"].as_f64().expect("t");
    let within = lines.iter().filter(|l| (1.005..1.495).contains(&t(l)));
    assert_eq!(within.count(), 0);
    let missing: Vec<f64> = lines
        .iter()
        .filter(|l| l["reason"] == "samples-missing")
        .map(t)
        .collect();
    let (first, last) = (missing[0], missing[missing.len() - 1]);
    assert!((1.5..1.52).contains(&first), "{first}");
    assert!((1.58..1.61).contains(&last), "{last}");
    // Zeros would have been heard as a stuck sensor.
    assert!(lines.iter().all(|l| l["reason"] != "samples-stuck"));
}

#[test]
fn a_long_gap_begins_a_stream_and_its_length_is_told() {
    let folder = Folder::default();
    for (gap, says) in [
        (u64::from(FS) + 1, "after a gap of 1.000 s"),
        (10 * u64::from(FS), "after a gap of 10.000 s"),
        // 4.4 years: what used to be 8 TB of zeros.
        (1 << 40, "after a gap of 137438953.472 s"),
    ] {
        let (record, codes) = with_gap(&folder, gap);
        let wav = folder.path().join(format!("{gap}.wav"));
        let ended = decoded(&record, &wav, "");
        assert_eq!(ended.code, Some(0), "{ended:?}");
        assert!(ended.stderr.contains(says), "{says}: {}", ended.stderr);
        assert_eq!(samples(&wav).1, codes[..FS as usize]);
        let second = folder.path().join(format!("{gap}-2.wav"));
        assert_eq!(samples(&second).1, codes[FS as usize..]);
    }
}

#[test]
fn a_number_that_cannot_be_costs_one_line() {
    let folder = Folder::default();
    let codes = vibration(900.0, 1, 2 * FS as usize);
    let mut sender = Sender::new(7);
    for first in [1 << 60, u64::MAX - 10, u64::MAX] {
        let half = FS as usize;
        let record = record(
            &folder,
            &[
                sender.started(f64::from(FS)),
                sender.raw(0, &codes[..half]),
                sender.raw(first, &codes[..100]),
                sender.raw(u64::from(FS), &codes[half..]),
            ],
        );
        let wav = folder.path().join("out.wav");
        let ended = decoded(&record, &wav, "");
        assert_eq!(ended.code, Some(0), "{ended:?}");
        let lines: Vec<&str> = ended.stderr.lines().collect();
        assert!(
            matches!(lines[..], [line] if line.contains("blocks of raw samples left out, for their numbers cannot be: 1")),
            "{lines:?}"
        );
        assert_eq!(samples(&wav).1, codes);
        let ended = program().on("monitor", &record, "--json");
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        assert_eq!(ended.monitored().1["samples"], codes.len());
    }
}

#[test]
fn a_box_that_loses_power_is_told_from_itself() {
    let folder = Folder::default();
    let scenario = folder.file(
        "cut.toml",
        b"name = \"cut\"\nabout = \"power goes and comes\"\nduration_s = 3.0\nhears = \"quiet\"\nfault = [{ kind = \"power-cut\", at_s = 1.0 }]\nhost = [{ at_s = 0.05, say = \"stream 0.8\" }, { at_s = 1.6, say = \"stream 1\" }]\n",
    );
    let record = folder.path().join("cut.frames");
    let ended = program().run(["box", "--sim", text(&scenario), "--record", text(&record)]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let wav = folder.path().join("cut.wav");
    let ended = decoded(&record, &wav, "");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stderr.contains("2 runs of the box"), "{ended:?}");
    let lengths = [wav, folder.path().join("cut-2.wav")].map(|wav| samples(&wav).1.len());
    assert_eq!(lengths, [38_400, 48_000]);
    // As many files as streams: the folder holds nothing that is half done.
    let names = fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(names, 4);
}
