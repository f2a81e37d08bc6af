//! Promise: what was measured is on disk before anything is made of it; where it cannot be
//! evaluated, the one line that says so names what is kept.
//!
//! `cargo test --release -p host-tests --test measured_is_kept -- --nocapture`

use host_tests::files::Folder;
use host_tests::process::Ended;
use host_tests::rarma;
use rarma_recordings::input::{ReadOptions, read};
use rarma_scenarios::scenario::SHIPPED_LDBB;
use std::ffi::OsStr;
use std::path::Path;

/// Runs a command line whose words are apart by blanks; `{}` is the folder.
fn run(folder: &Folder, line: &str) -> Ended {
    let at = folder.path().display().to_string();
    let words: Vec<String> = line
        .split_whitespace()
        .map(|word| word.replace("{}", &at))
        .collect();
    rarma!().run(words.iter().map(OsStr::new))
}

/// Bad input, one line, with these words in it.
fn refused(ended: &Ended, words: &[String]) {
    assert_eq!(ended.code, Some(3), "{ended:?}");
    one_line(ended, words);
}

fn one_line(ended: &Ended, words: &[String]) {
    println!("{}", ended.stderr.trim_end());
    let refusals: Vec<&str> = ended
        .stderr
        .lines()
        .filter(|line| !line.starts_with("rarma: note: "))
        .collect();
    let [line] = refusals[..] else {
        panic!("not one line: {ended:?}")
    };
    for word in words {
        assert!(line.contains(word), "no `{word}` in: {line}");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|e| {
            let name = e.expect("an entry").file_name();
            name.into_string().expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

/// Three forces that are nearly one: measured, and not to be evaluated.
#[test]
fn the_readings_of_the_ball_bar() {
    let folder = Folder::default();
    let forces = "forces_n = [364, 364.2, 364.4]\ndown = false\nfeed_mm_min";
    let text = SHIPPED_LDBB[0].1.replace("feed_mm_min", forces);
    let _ = folder.file("near.toml", text.as_bytes());
    let out = folder.path().join("out");
    let kept = format!(
        "the readings are kept: rarma ldbb analyse {}",
        out.display()
    );
    let ended = run(
        &folder,
        "ldbb run {}/near.toml --report {}/page --out {}/out",
    );
    refused(&ended, &["forces are all equal".to_owned(), kept]);
    let found = names(&out);
    assert_eq!(found.len(), 7, "six runs and the static test: {found:?}");
    assert!(!found.contains(&"analysis.json".to_owned()), "{found:?}");
    // They are readings like any: read again, they say the same.
    let again = run(&folder, "ldbb analyse {}/out");
    refused(&again, &["forces are all equal".to_owned()]);
    // Without a folder it says what would have kept them.
    let ended = run(&folder, "ldbb run {}/near.toml");
    refused(&ended, &["--out DIR keeps them".to_owned()]);
}

/// The test ends in its third pressure: the runs of the first two are there.
#[test]
fn the_runs_before_a_test_ended() {
    let folder = Folder::default();
    // So soft that the bar is beyond its trigger at the third force.
    let text = b"name = \"T\"\nabout = \"soft\"\ndown = false\n[machine]\nmean_n_per_um = 0.8\n";
    let _ = folder.file("soft.toml", text);
    let ended = run(&folder, "ldbb run {}/soft.toml --out {}/out");
    let kept = folder.path().join("out").display().to_string();
    refused(&ended, &["the test ended in run 4".to_owned(), kept]);
    let found = names(&folder.path().join("out"));
    assert_eq!(found.len(), 4, "{found:?}");
    assert!(found[0].starts_with("run-00"), "{found:?}");
}

/// The modes cannot be written, for the disk is full: the record is there, and the responses
/// are.
#[cfg(target_os = "linux")]
#[test]
fn the_record_of_the_exciter() {
    let folder = Folder::default();
    let scenario = b"name = \"T\"\nabout = \"a test\"\nseconds = 1\n";
    let _ = folder.file("t.toml", scenario);
    let full = folder.path().join("full");
    std::fs::create_dir(&full).expect("a folder");
    std::os::unix::fs::symlink("/dev/full", full.join("structure-x.json")).expect("a link");
    let ended = run(
        &folder,
        "cers run {}/t.toml --quick --out {}/out --csv {}/responses.csv --structure {}/full",
    );
    let kept = folder.path().join("out").display().to_string();
    assert_eq!(ended.code, Some(4), "{ended:?}");
    one_line(
        &ended,
        &[format!("the record is kept: rarma cers analyse {kept}")],
    );
    assert_eq!(names(Path::new(&kept)), ["record.toml", "signals.wav"]);
    let signals = Path::new(&kept).join("signals.wav");
    let read = read(&signals, &ReadOptions::default()).expect("a recording");
    assert!(read.samples.len() as f64 > 0.95 * read.fs, "whole");
    assert!(
        folder
            .path()
            .join("responses.csv")
            .metadata()
            .is_ok_and(|m| m.len() > 1000)
    );
    // The record as any.
    let again = run(&folder, "cers analyse {}/out --quick --json");
    assert_eq!(again.code, Some(0), "{again:?}");
}

/// Static stiffness where there are no lines: the receptance is there.
#[test]
fn the_receptance_of_a_blow() {
    let folder = Folder::default();
    // One mode of 800 Hz hit for 0.4 ms, by its own answer to an impulse.
    let (fs, n) = (20_000, 8000);
    let ring = |k: f64| {
        let t = k / f64::from(fs);
        (-120.0 * t).exp() * (std::f64::consts::TAU * 800.0 * t).sin()
    };
    let (mut force, mut response) = (Vec::new(), Vec::new());
    for k in 0..n {
        force.push(if (100..108).contains(&k) { 1.0 } else { 0.0 });
        let since = (100..108).map(|j| f64::from(k - j)).filter(|d| *d > 0.0);
        response.push(since.map(ring).sum::<f64>() as f32);
    }
    let _ = folder.float("force.wav", fs, &force);
    let _ = folder.float("response.wav", fs, &response);
    let hammer = "els hammer {}/force.wav {}/response.wav --band 300:2000 --uff {}/g.uff";
    let ended = run(&folder, &format!("{hammer} --static 0.1:0.2"));
    refused(&ended, &[]);
    let limit = run(&folder, "els limit {}/g.uff --json");
    assert_eq!(limit.code, Some(0), "{limit:?}");
}
