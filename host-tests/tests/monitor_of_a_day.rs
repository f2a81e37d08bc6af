//! Promise: `rarma monitor` listens to any length of sound, from a file or a pipe, in the
//! same memory, and says things as they come.

use host_tests::files::{Folder, HEADER};
use host_tests::piped::{Workday, endless_header, interrupt};
use host_tests::rarma;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::time::Instant;

/// Most memory of a run, bytes.
const MOST: u64 = 60_000_000;
/// Two runs of different length differ by this part of it at most.
const EQUAL: f64 = 0.1;

/// Peak memory of `monitor` on so many seconds made while they are read, bytes.
fn peak(fs_hz: f64, seconds: f64, options: &[&str]) -> u64 {
    heard(Workday::new(fs_hz), fs_hz, seconds, options)
}

fn heard(sound: Workday, fs_hz: f64, seconds: f64, options: &[&str]) -> u64 {
    let arguments = ["monitor", "-"].iter().chain(options);
    let fed = rarma!().fed(arguments, false, move |pipe| sound.write(seconds, pipe));
    assert_eq!(fed.ended.code, Some(1), "{}", fed.ended.stderr);
    eprintln!(
        "monitor on {seconds} s at {fs_hz} Hz, {options:?}: {:.1} MB",
        1e-6 * fed.peak_bytes as f64
    );
    fed.peak_bytes
}

fn assert_equal(short: u64, long: u64) {
    assert!(short.max(long) <= MOST, "{short} and {long} bytes");
    let apart = short.abs_diff(long) as f64 / short.min(long) as f64;
    assert!(apart <= EQUAL, "{short} and {long} bytes");
}

/// That a long run takes as much memory as a short one, as JSON and with a page.
fn equal(fs_hz: f64, short_s: f64, long_s: f64) {
    let folder = Folder::default();
    let page = folder.path().join("page");
    let report = ["--json", "--report", page.to_str().expect("UTF-8")];
    for options in [&report[..1], &report[..]] {
        assert_equal(peak(fs_hz, short_s, options), peak(fs_hz, long_s, options));
    }
    let html = std::fs::read_to_string(page.join("index.html")).expect("a page");
    assert!((20_000..4_000_000).contains(&html.len()), "{}", html.len());
}

#[test]
fn memory_does_not_grow_with_length() {
    equal(8_000.0, 240.0, 1_200.0);
}

/// As many alarms in an hour as a long day has: the summary lists them all.
#[test]
fn memory_does_not_grow_with_alarms() {
    let alarms = |seconds: f64| {
        let sound = Workday::new(8_000.0).hurried(15);
        heard(sound, 8_000.0, seconds, &["--json"])
    };
    assert_equal(alarms(120.0), alarms(3_600.0));
}

/// Without it the runs of an hour and a day have no alarm to keep.
#[test]
fn the_day_holds_chatter_at_its_full_rate() {
    peak(48_000.0, 40.0, &["--json"]);
}

#[test]
#[ignore = "a day of 48 kHz: half an hour of work"]
fn memory_does_not_grow_with_length_long() {
    equal(48_000.0, 3_600.0, 86_400.0);
}

/// What a file takes that is read twice, and how soon it and a pipe say something.
#[test]
fn a_recording_of_200_mb_takes_as_much_memory_as_one_of_20_mb() {
    const FS_HZ: f64 = 48_000.0;
    let folder = Folder::default();
    let of = |megabytes: f64| {
        let path = folder.path().join(format!("{megabytes}.wav"));
        let mut file = BufWriter::new(File::create(&path).expect("a file"));
        let seconds = 1e6 * megabytes / (2.0 * FS_HZ);
        let written = Workday::new(FS_HZ).write(seconds, &mut file);
        written.and_then(|()| file.flush()).expect("written");
        let listen = ["monitor", path.to_str().expect("UTF-8"), "--json"];
        let first_s = first_line_s(listen, None);
        let fed = rarma!().fed(listen, false, |_| Ok(()));
        assert_eq!(fed.ended.code, Some(1), "{}", fed.ended.stderr);
        eprintln!(
            "{megabytes} MB: {:.1} MB of memory, first line after {first_s:.2} s",
            1e-6 * fed.peak_bytes as f64
        );
        fed.peak_bytes
    };
    let (short, long) = (of(20.0), of(200.0));
    let mut second = Vec::new();
    Workday::new(FS_HZ).write(1.0, &mut second).expect("bytes");
    let piped_s = first_line_s(["monitor", "-", "--json"], Some(second));
    eprintln!("a pipe: first line after {piped_s:.2} s");
    assert_equal(short, long);
}

/// Time until it says something, s.
fn first_line_s(arguments: [&str; 3], sound: Option<Vec<u8>>) -> f64 {
    let begun = Instant::now();
    let (mut child, mut pipe, mut lines) = rarma!().talking(arguments);
    if let Some(sound) = sound {
        pipe.write_all(&sound).expect("it listens");
        pipe.flush().expect("it listens");
    }
    assert!(lines.next().is_some_and(|line| line.contains("\"state\"")));
    let first_s = begun.elapsed().as_secs_f64();
    child.kill().and_then(|()| child.wait()).expect("killed");
    first_s
}

/// Samples of a short cut, and the WAV of it.
fn cut(folder: &Folder) -> (Vec<u8>, std::path::PathBuf) {
    let samples: Vec<f64> = Workday::new(8_000.0)
        .take(26 * 8_000)
        .map(|x| f64::from(x) / 32_768.0)
        .collect();
    let path = folder.pcm16("cut.wav", 8_000, &samples);
    let bytes = std::fs::read(&path).expect("the file");
    (bytes[HEADER..].to_vec(), path)
}

#[test]
fn a_pipe_says_what_a_file_says() {
    let folder = Folder::default();
    let (data, path) = cut(&folder);
    let file = rarma!().on("monitor", &path, "--json");
    assert_eq!(file.code, Some(1), "{file:?}");
    let mut whole = std::fs::read(&path).expect("the file");
    let piped = |options: &[&str], head: Vec<u8>, data: Vec<u8>| {
        let arguments = ["monitor", "-", "--json"].iter().chain(options);
        rarma!().fed(arguments, true, move |pipe| {
            pipe.write_all(&head)?;
            // In pieces that end inside a sample.
            data.chunks(777).try_for_each(|piece| {
                pipe.write_all(piece)?;
                pipe.flush()
            })
        })
    };
    let header = whole.drain(..HEADER).collect::<Vec<u8>>();
    let mut unfilled = header.clone();
    unfilled[4..8].fill(0);
    unfilled[40..44].fill(0);
    let cases: [(&str, &[&str], Vec<u8>); 4] = [
        ("its length", &[], header),
        ("all ones", &[], endless_header(8_000)),
        ("zeros", &[], unfilled),
        ("no header", &["--raw", "s16", "--fs", "8000"], Vec::new()),
    ];
    for (what, options, head) in cases {
        let fed = piped(options, head, data.clone());
        assert_eq!(fed.ended.code, file.code, "{what}: {}", fed.ended.stderr);
        assert!(fed.ended.stdout == file.stdout, "{what}");
    }
    let floats: Vec<u8> = data
        .chunks_exact(2)
        .map(|b| f32::from(i16::from_le_bytes([b[0], b[1]])) / 32_768.0)
        .flat_map(f32::to_le_bytes)
        .collect();
    let fed = piped(&["--raw", "f32", "--fs", "8000"], Vec::new(), floats);
    assert_eq!(fed.ended.code, Some(1), "{}", fed.ended.stderr);
}

#[test]
fn lines_come_while_the_pipe_is_open() {
    let (mut child, mut pipe, mut lines) = rarma!().talking(["monitor", "-", "--json"]);
    let mut second = Vec::new();
    Workday::new(8_000.0)
        .write(3.0, &mut second)
        .expect("bytes");
    pipe.write_all(&second).expect("it listens");
    pipe.flush().expect("it listens");
    // Would wait for ever if lines came at the end only.
    for n in 1..=250 {
        let line = lines.next().expect("a line");
        assert!(line.contains("\"state\""), "{n}: {line}");
    }
    drop(pipe);
    assert!(lines.any(|line| line.starts_with("{\"summary\"")));
    assert!(child.wait().expect("its end").code().is_some());
}

/// An endless stream has no other end than Ctrl-C: what was heard until then counts.
#[test]
fn a_pipe_that_stalls_is_told_of_and_an_interrupt_ends_it_in_order() {
    let folder = Folder::default();
    let page = folder.path().join("page");
    let report = page.to_str().expect("UTF-8");
    let (mut child, mut pipe, lines) =
        rarma!().talking(["monitor", "-", "--json", "--report", report]);
    let mut sound = Vec::new();
    Workday::new(8_000.0)
        .write(24.0, &mut sound)
        .expect("bytes");
    let last = std::thread::scope(|scope| {
        // Read all the time: a pipe that is full would stop it.
        let last = scope.spawn(move || lines.last().expect("lines"));
        pipe.write_all(&sound).expect("it listens");
        pipe.flush().expect("it listens");
        let stderr = BufReader::new(child.stderr.take().expect("standard error"));
        let mut said = stderr.lines().map_while(Result::ok);
        assert!(
            said.any(|line| line.contains("nothing has come for 2 s")),
            "it ends without a word"
        );
        interrupt(&child);
        last.join().expect("read")
    });
    assert!(last.starts_with("{\"summary\""), "{last}");
    let summary: serde_json::Value = serde_json::from_str(&last).expect("JSON");
    assert_eq!(summary["summary"]["samples"], 24 * 8_000, "{last}");
    assert_eq!(
        child.wait().expect("its end").code(),
        Some(1),
        "it chatters"
    );
    let html = std::fs::read_to_string(page.join("index.html")).expect("a page");
    assert!(html.contains("Chatter at"));
    drop(pipe);
}

#[test]
fn what_a_file_is_refused_for_a_pipe_is_too_at_its_end() {
    let folder = Folder::default();
    let sine = |n: usize, gain: f64| -> Vec<f64> {
        (0..n)
            .map(|i| (gain * (0.3 * i as f64).sin()).clamp(-1.0, 1.0))
            .collect()
    };
    let cases = [
        (folder.pcm16("silent.wav", 8_000, &[0.0; 40_000]), 3),
        (folder.pcm16("clipped.wav", 8_000, &sine(40_000, 1.5)), 3),
        (folder.pcm16("short.wav", 8_000, &sine(40, 0.5)), 3),
        (folder.pcm16("nothing.wav", 8_000, &[]), 3),
        (folder.float("nan.wav", 8_000, &nan()), 3),
    ];
    for (path, code) in cases {
        let file = rarma!().on("monitor", &path, "");
        assert_eq!(file.code, Some(code), "{file:?}");
        assert_eq!(file.stdout, "", "nothing is said of a file that is not fit");
        let bytes = std::fs::read(&path).expect("the file");
        let fed = rarma!().fed(["monitor", "-"], true, move |pipe| pipe.write_all(&bytes));
        let last = |stderr: &str| stderr.lines().last().unwrap_or_default().to_owned();
        let of_file = last(&file.stderr).replace(&path.display().to_string(), "standard input");
        assert_eq!(
            (fed.ended.code, last(&fed.ended.stderr)),
            (Some(code), of_file)
        );
    }
}

fn nan() -> Vec<f32> {
    let mut samples: Vec<f32> = (0..40_000).map(|i| (0.3 * i as f32).sin()).collect();
    samples[30_000] = f32::NAN;
    samples
}

#[test]
fn what_a_pipe_cannot_be_is_said_in_a_line() {
    let refused = |arguments: &[&str], code: i32, says: &str| {
        let ended = rarma!()
            .fed(arguments, true, |pipe| pipe.write_all(b"0,1\n1,2\n"))
            .ended;
        assert_eq!(ended.code, Some(code), "{ended:?}");
        assert!(ended.stderr.contains(says), "{ended:?}");
    };
    refused(
        &["monitor", "-"],
        3,
        "standard input: byte 0: not a WAV file",
    );
    refused(&["monitor", "-", "--raw", "s16"], 2, "--fs");
    let nothing = rarma!().fed(["monitor", "-"], true, |_| Ok(())).ended;
    assert_eq!(nothing.code, Some(3), "{nothing:?}");
    assert!(nothing.stderr.contains("nothing came"), "{nothing:?}");
    assert!(
        Path::new("/proc/self/status").exists(),
        "memory is read there"
    );
}
