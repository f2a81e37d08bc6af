//! Promise: `decode` and `connect` take as much memory for a day of a box as for a minute.
//!
//! The long form: `cargo test --release -p host-tests --test record_memory -- --ignored
//! --nocapture`.
#![cfg(target_os = "linux")]

use host_tests::files::Folder;
use host_tests::frames::Sender;
use std::fs;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const FS: u64 = 48_000;
const BLOCK: u64 = 120;
/// The most that either may take, KiB.
const MOST_KIB: u64 = 60 << 10;

/// Greatest memory of a program so far, KiB; it has to be running.
fn peak_kib(child: &Child) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).expect("a program");
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1));
    kib.and_then(|kib| kib.parse().ok()).expect("its peak")
}

/// Sends what a box streams in so many seconds; the bytes sent.
fn stream(seconds: u64, out: &mut impl Write) -> u64 {
    let mut sender = Sender::new(1);
    let head = sender.started(FS as f64);
    out.write_all(&head).expect("a reader");
    let mut sent = head.len() as u64;
    let codes: Vec<i16> = (0..BLOCK as i16 * 100).map(|k| k * 7).collect();
    let step = codes.len() as u64;
    for first in (0..seconds * FS).step_by(codes.len()) {
        let left = (seconds * FS - first).min(step) as usize;
        let frames = sender.raw(first, &codes[..left]);
        out.write_all(&frames).expect("a reader");
        sent += frames.len() as u64;
    }
    sent
}

/// `decode` of standard input into a WAV; words or JSON go to nobody.
fn decode(seconds: u64, wav: &Path, json: bool) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"));
    command.args(["decode", "-", "--wav"]).arg(wav);
    if json {
        command.arg("--json");
    }
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("a program");
    let mut pipe = child.stdin.take().expect("a pipe");
    stream(seconds, &mut pipe);
    // Until what the pipe holds has been taken, 64 KiB at most.
    std::thread::sleep(Duration::from_millis(500));
    let peak = peak_kib(&child);
    drop(pipe);
    assert!(child.wait().expect("its end").success());
    let samples = hound::WavReader::open(wav).expect("a WAV").len();
    let most = (u64::from(u32::MAX) - 64) / 2;
    assert_eq!(u64::from(samples), (seconds * FS).min(most));
    peak
}

/// `connect` to a box on a socket, recording.
fn connect(seconds: u64, record: &Path, json: bool) -> u64 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = format!("tcp:{}", listener.local_addr().expect("an address"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(["connect", &port, "--look", "--record"])
        .arg(record)
        .args(json.then_some("--json"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("a program");
    let (mut socket, _) = listener.accept().expect("a connection");
    let sent = stream(seconds, &mut socket);
    let begun = Instant::now();
    while fs::metadata(record).map_or(0, |meta| meta.len()) < sent {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "not all recorded"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    let peak = peak_kib(&child);
    // The box goes, having heard everything.
    socket.shutdown(Shutdown::Write).expect("a socket");
    let _ = socket.read_to_end(&mut Vec::new());
    // Which is no good end.
    assert_eq!(child.wait().expect("its end").code(), Some(4));
    assert_eq!(fs::metadata(record).expect("a record").len(), sent);
    peak
}

fn assert_equal(what: &str, short_kib: u64, long_kib: u64) {
    println!("{what}: {short_kib} KiB, {long_kib} KiB");
    let ratio = long_kib as f64 / short_kib as f64;
    assert!((0.9..1.1).contains(&ratio), "{what}: {ratio}");
    assert!(
        (500..MOST_KIB).contains(&long_kib),
        "{what}: {long_kib} KiB"
    );
}

#[test]
fn decode_takes_no_more_for_longer_records() {
    let folder = Folder::default();
    let wav = |name: &str| folder.path().join(name);
    let short = decode(20, &wav("short.wav"), false);
    assert_equal(
        "decode, 20 s and 480 s",
        short,
        decode(480, &wav("long.wav"), false),
    );
    let short = decode(2, &wav("short.wav"), true);
    assert_equal(
        "decode --json, 2 s and 48 s",
        short,
        decode(48, &wav("long.wav"), true),
    );
}

#[test]
fn connect_takes_no_more_for_longer_records() {
    let folder = Folder::default();
    let record = |name: &str| folder.path().join(name);
    let short = connect(2, &record("short.frames"), true);
    let long = connect(48, &record("long.frames"), true);
    assert_equal("connect --json, 2 s and 48 s", short, long);
}

#[test]
#[ignore = "writes a record of 9 GB: minutes"]
fn connect_takes_no_more_for_longer_records_long() {
    let folder = Folder::default();
    let record = |name: &str| folder.path().join(name);
    let short = connect(3600, &record("hour.frames"), false);
    let long = connect(86_400, &record("day.frames"), false);
    assert_equal("connect, 1 h and 24 h", short, long);
}

#[test]
#[ignore = "writes 8 GB of WAV: minutes"]
fn decode_takes_no_more_for_longer_records_long() {
    let folder = Folder::default();
    let wav = |name: &str| folder.path().join(name);
    let short = decode(3600, &wav("hour.wav"), false);
    assert_equal(
        "decode, 1 h and 24 h",
        short,
        decode(86_400, &wav("day.wav"), false),
    );
    // More than a WAV holds: the rest is in a second one.
    let rest = hound::WavReader::open(wav("day-part2.wav")).expect("a WAV");
    let whole = 86_400 * FS;
    assert_eq!(
        u64::from(rest.len()),
        whole - (u64::from(u32::MAX) - 64) / 2
    );
}
