//! Promise: `rarma listen` says of a sound card what `monitor` says of the same samples in a file; what is
//! lost on the way is counted and is missing in its place; however it ends, the recording is whole.
//!
//! The card is the system's own library for sound, which reads a file or a pipe in place of hardware
//! (ALSA's `file` device). Without the feature `sound-card` these are skipped, loudly; `RARMA_REQUIRE_SOUND_CARD=1`
//! makes that a failure.

// What tests write nobody keeps.
#![allow(clippy::disallowed_methods)]

use serde_json::Value;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const FS: usize = 48_000;
/// Bytes of a moment: two channels of 32 bits.
const FRAME: usize = 8;

fn rarma() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rarma"))
}

fn output(command: &mut Command) -> Output {
    command.output().expect("rarma runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A home in which the system finds cards that read files.
struct Cards(TempDir);

impl Cards {
    fn or_skip(test: &str) -> Option<Self> {
        let why = "this test was built without the feature sound-card, or not on Linux";
        let required = std::env::var("RARMA_REQUIRE_SOUND_CARD").is_ok_and(|value| value == "1");
        let can = cfg!(all(feature = "sound-card", target_os = "linux"));
        assert!(
            can || !required,
            "{test}: {why}, and skipping is not allowed here"
        );
        if !can {
            let _ = writeln!(io::stderr(), "SKIPPED: {test}: {why}");
            return None;
        }
        Some(Self(tempfile::tempdir().expect("a folder")))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A card called `name` that gives what is in `file`, as fast as it is read.
    fn add(&self, name: &str, file: &Path) {
        let entry = format!(
            "pcm.{name} {{ type file; slave.pcm \"null\"; file \"/dev/null\"; infile \"{}\"; format \"raw\"; hint {{ show on; description \"test {name}\" }} }}\n",
            file.display()
        );
        let mut options = OpenOptions::new();
        let config = options
            .create(true)
            .append(true)
            .open(self.path(".asoundrc"));
        let written = config.and_then(|mut file| file.write_all(entry.as_bytes()));
        written.expect("written");
    }

    /// A card that plays these sounds on both of its channels.
    fn plays(&self, name: &str, codes: &[i16]) {
        let file = self.path(&format!("{name}.raw"));
        rarma_cli::output::write(&file, frames(codes)).expect("written");
        self.add(name, &file);
    }

    /// A card that gives what is written into the pipe.
    fn pipe(&self, name: &str) -> PathBuf {
        let pipe = self.path(&format!("{name}.pipe"));
        let made = Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo").success());
        self.add(name, &pipe);
        pipe
    }

    fn listen(&self, arguments: &[&str]) -> Command {
        let mut command = rarma();
        command
            .arg("listen")
            .args(arguments)
            .env("HOME", self.0.path())
            .current_dir(self.0.path())
            .stdin(Stdio::null());
        command
    }
}

/// As the card gives them: 32 bits, two channels.
fn frames(codes: &[i16]) -> Vec<u8> {
    let one = |code: &i16| (i32::from(*code) << 16).to_le_bytes();
    codes
        .iter()
        .flat_map(|code| [one(code), one(code)].concat())
        .collect()
}

/// Writes into a pipe as fast as a card would, waiting `pause` after so many seconds. The thread ends
/// with the test.
fn play(pipe: PathBuf, codes: &[i16], pause: (f64, Duration)) {
    let bytes = frames(codes);
    thread::spawn(move || {
        // For reading, too: the pipe stays while `listen` asks what the card offers, and opens it again.
        let both = File::options().read(true).write(true).open(pipe);
        let (mut pipe, mut begun, mut paused) = (both.expect("a pipe"), Instant::now(), false);
        for (k, block) in bytes.chunks(FS / 100 * FRAME).enumerate() {
            let due = k as f64 * 0.01;
            if due >= pause.0 && !paused {
                paused = true;
                thread::sleep(pause.1);
                begun += pause.1;
            }
            while begun.elapsed().as_secs_f64() < due {
                thread::sleep(Duration::from_millis(1));
            }
            pipe.write_all(block).expect("written");
        }
    });
}

/// Loud noise, always the same.
fn noise(seconds: f64) -> Vec<i16> {
    let mut state = 1_u32;
    (0..(seconds * FS as f64) as usize)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 19) as i16 - (1 << 12)
        })
        .collect()
}

fn codes_of(wav: &Path) -> Vec<i16> {
    let reader = hound::WavReader::open(wav).expect("a WAV");
    assert_eq!(
        reader.spec().bits_per_sample,
        16,
        "all bits of the converter"
    );
    assert_eq!(reader.spec().sample_rate, FS as u32);
    let samples = reader.into_samples::<i16>();
    samples.map(|x| x.expect("a sample")).collect()
}

/// The lines after the first, which is `listen`'s own.
fn lines(json: &[u8]) -> Vec<Value> {
    let parse = |line: &str| serde_json::from_str(line).expect("JSON");
    text(json).lines().map(parse).collect()
}

/// Waits until so many seconds are in the file.
fn until_recorded(wav: &Path, seconds: usize) {
    let begun = Instant::now();
    while std::fs::metadata(wav).map_or(0, |meta| meta.len()) < (2 * FS * seconds) as u64 {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "{}",
            wav.display()
        );
        thread::sleep(Duration::from_millis(20));
    }
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.expect("kill").success());
}

#[test]
fn without_the_feature_one_line_says_how_to_get_it() {
    let help = output(rarma().args(["listen", "--help"]));
    assert!(help.status.success() && text(&help.stdout).contains("--device"));
    if cfg!(feature = "sound-card") {
        return;
    }
    for arguments in [&["listen"][..], &["listen", "--list"]] {
        let said = output(rarma().args(arguments));
        let line = text(&said.stderr);
        assert_eq!(said.status.code(), Some(4), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        assert!(line.contains("--features sound-card"), "{line}");
    }
}

#[test]
fn a_card_and_a_file_with_the_same_samples_have_the_same_verdict() {
    let Some(cards) = Cards::or_skip("same verdict") else {
        return;
    };
    let (file, heard) = (cards.path("cut.wav"), cards.path("heard.wav"));
    let made = output(
        rarma()
            .args(["simulate", "slender-bar", "--out"])
            .arg(&file),
    );
    assert!(made.status.success(), "{}", text(&made.stderr));
    let codes = codes_of(&file);
    let seconds = 3.5;
    cards.plays("cut", &codes);
    let how = ["--rpm", "420", "--json"];
    let record = heard.display().to_string();
    let length = seconds.to_string();
    let options = ["--device", "cut", "--seconds", &length, "--record", &record];
    let live = output(&mut cards.listen(&[&options[..], &how].concat()));
    assert_eq!(live.status.code(), Some(1), "{}", text(&live.stderr));
    // Every sample, and no other.
    let taken = (seconds * FS as f64).round() as usize;
    assert_eq!(codes_of(&heard), codes[..taken]);
    let of_file = output(rarma().arg("monitor").arg(&heard).args(how));
    let live = lines(&live.stdout);
    assert_eq!(live[0]["listening"]["device"], "cut");
    assert_eq!(live[0]["listening"]["fs"], FS);
    let level = live[0]["listening"]["level"][0]["rms_dbfs"].as_f64();
    assert!(
        level.is_some_and(|dbfs| (-90.0..0.0).contains(&dbfs)),
        "{level:?}"
    );
    assert!(live.len() > 100, "{} lines", live.len());
    assert_eq!(live[1..], lines(&of_file.stdout)[..]);
}

/// Which writes a header without a length, and ends with its pipe.
#[test]
fn what_arecord_writes_into_a_pipe_is_heard_as_its_file() {
    let Some(cards) = Cards::or_skip("arecord") else {
        return;
    };
    let file = cards.path("cut.wav");
    let made = output(
        rarma()
            .args(["simulate", "slender-bar", "--out"])
            .arg(&file),
    );
    assert!(made.status.success(), "{}", text(&made.stderr));
    cards.plays("cut", &codes_of(&file));
    let shell = |line: &str| {
        let mut shell = Command::new("sh");
        shell
            .args(["-c", line, env!("CARGO_BIN_EXE_rarma")])
            .env("HOME", cards.0.path())
            .current_dir(cards.0.path());
        output(&mut shell)
    };
    let arecord = "arecord -q -D cut -f S32_LE -c 2 -r 48000 -t wav";
    let of_file = shell(&format!(
        "{arecord} -d 3 three.wav && $0 monitor three.wav --rpm 420 --json"
    ));
    assert_eq!(of_file.status.code(), Some(1), "{}", text(&of_file.stderr));
    let bytes = 44 + 3 * FS * FRAME;
    let of_pipe = shell(&format!(
        "{arecord} | head -c {bytes} | $0 monitor - --rpm 420 --json"
    ));
    assert_eq!(of_pipe.status.code(), Some(1), "{}", text(&of_pipe.stderr));
    assert!(of_pipe.stdout == of_file.stdout);
}

#[test]
fn what_comes_too_fast_is_missing_and_counted() {
    let Some(cards) = Cards::or_skip("too fast") else {
        return;
    };
    // The file is read a thousand times faster than a card would be: the ring overflows.
    cards.plays("fast", &noise(60.0));
    let said = output(&mut cards.listen(&[
        "--device",
        "fast",
        "--seconds",
        "50",
        "--json",
        "--record",
        "fast.wav",
    ]));
    let words = text(&said.stderr);
    assert!(words.contains("samples are missing ("), "{words}");
    let lines = lines(&said.stdout);
    let summary = &lines.last().expect("a last line")["summary"];
    assert_eq!(summary["samples"], 50 * FS, "{summary}");
    assert!(
        summary["state_seconds"]["invalid"].as_f64() > Some(0.0),
        "{summary}"
    );
    assert_eq!(codes_of(&cards.path("fast.wav")).len(), 50 * FS);
}

#[test]
fn a_muted_input_is_refused_with_its_own_code() {
    let Some(cards) = Cards::or_skip("muted") else {
        return;
    };
    let said = output(&mut cards.listen(&["--device", "null", "--record", "none.wav"]));
    let words = text(&said.stderr);
    assert_eq!(said.status.code(), Some(5), "{words}");
    assert!(
        words.contains("silence") && words.contains("unmute"),
        "{words}"
    );
    assert!(!cards.path("none.wav").exists());
}

#[test]
fn cards_are_listed_and_unknown_ones_refused() {
    let Some(cards) = Cards::or_skip("list") else {
        return;
    };
    cards.plays("mill", &noise(0.1));
    let said = output(&mut cards.listen(&["--list"]));
    let words = text(&said.stdout);
    assert!(words.contains("mill\n    test mill\n"), "{words}");
    assert!(
        !text(&said.stderr).contains("ALSA lib"),
        "{}",
        text(&said.stderr)
    );
    let said = output(&mut cards.listen(&["--list", "--json"]));
    let all = &lines(&said.stdout)[0]["inputs"];
    let mill = all
        .as_array()
        .expect("a list")
        .iter()
        .find(|i| i["name"] == "mill");
    assert!(
        mill.expect("listed")["formats"]
            .to_string()
            .contains("16 bit")
    );
    let said = output(&mut cards.listen(&["--device", "lathe"]));
    assert_eq!(said.status.code(), Some(3));
    assert!(text(&said.stderr).contains("listen --list"));
    let said = output(&mut cards.listen(&["--device", "mill", "--channel", "70"]));
    assert_eq!(said.status.code(), Some(3));
    assert!(text(&said.stderr).contains("channel 70 asked for, but it has 64"));
}

/// The library for sound is told of no card at all.
#[test]
fn a_computer_without_an_input_is_told_what_to_do() {
    let Some(cards) = Cards::or_skip("no input") else {
        return;
    };
    let said = output(
        cards
            .listen(&["--record", "none.wav"])
            .env("ALSA_CONFIG_PATH", "/dev/null"),
    );
    let words = text(&said.stderr);
    assert_eq!(said.status.code(), Some(4), "{words}");
    assert_eq!(words.lines().count(), 1, "{words}");
    assert!(
        words.contains("sound card") && words.contains("listen --list"),
        "{words}"
    );
    assert!(!cards.path("none.wav").exists());
}

#[test]
fn a_clipped_input_is_warned_of_and_is_bad_input_at_its_end() {
    let Some(cards) = Cards::or_skip("clipped") else {
        return;
    };
    let loud: Vec<i16> = noise(4.0).iter().map(|x| x.saturating_mul(20)).collect();
    cards.plays("loud", &loud);
    let said = output(&mut cards.listen(&["--device", "loud", "--seconds", "3"]));
    let words = text(&said.stderr);
    assert_eq!(said.status.code(), Some(3), "{words}");
    assert!(
        words.contains("Warning") && words.contains("gain"),
        "{words}"
    );
}

#[test]
fn a_file_that_is_there_is_not_recorded_over() {
    let Some(cards) = Cards::or_skip("not over") else {
        return;
    };
    cards.plays("mill", &noise(2.0));
    rarma_cli::output::write(&cards.path("mine.wav"), b"mine").expect("written");
    let said =
        output(&mut cards.listen(&["--device", "mill", "--seconds", "1", "--record", "mine.wav"]));
    assert_eq!(said.status.code(), Some(4), "{}", text(&said.stderr));
    assert!(text(&said.stderr).contains("mine.wav"));
    assert_eq!(
        std::fs::read(cards.path("mine.wav")).expect("there"),
        b"mine"
    );
}

#[test]
fn the_rate_of_a_telephone_is_named() {
    let Some(cards) = Cards::or_skip("telephone") else {
        return;
    };
    cards.plays("phone", &noise(2.0));
    let said =
        output(&mut cards.listen(&["--device", "phone", "--fs", "8000", "--seconds", "1.5"]));
    let words = text(&said.stderr);
    assert!(
        words.contains("8000 Hz is the rate of a telephone call"),
        "{words}"
    );
}

#[test]
fn an_interruption_ends_it_with_summary_and_recording() {
    let Some(cards) = Cards::or_skip("interrupted") else {
        return;
    };
    let codes = noise(20.0);
    play(cards.pipe("live"), &codes, (f64::MAX, Duration::ZERO));
    let mut listen = cards.listen(&[
        "--device", "live", "--json", "--every", "1", "--record", "live.wav",
    ]);
    let listen = listen.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let listen = listen.expect("rarma runs");
    until_recorded(&cards.path("live.wav"), 2);
    interrupt(&listen);
    let said = listen.wait_with_output().expect("an end");
    let words = text(&said.stderr);
    assert!(matches!(said.status.code(), Some(0 | 1)), "{words}");
    let last = lines(&said.stdout).pop().expect("a last line");
    let heard = codes_of(&cards.path("live.wav"));
    assert_eq!(last["summary"]["samples"], heard.len(), "{words}");
    assert!(heard.len() >= 2 * FS && heard.len() < codes.len());
    assert_eq!(heard, codes[..heard.len()]);
}

#[test]
fn a_killed_one_leaves_a_recording_that_can_be_heard() {
    let Some(cards) = Cards::or_skip("killed") else {
        return;
    };
    let codes = noise(20.0);
    play(cards.pipe("live"), &codes, (f64::MAX, Duration::ZERO));
    let mut listen = cards.listen(&["--device", "live", "--record", "live.wav"]);
    let listen = listen.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut listen = listen.expect("rarma runs");
    until_recorded(&cards.path("live.wav"), 2);
    listen.kill().and_then(|()| listen.wait()).expect("killed");
    let heard = codes_of(&cards.path("live.wav"));
    assert!(heard.len() >= FS, "{}", heard.len());
    assert_eq!(heard, codes[..heard.len()]);
}

#[test]
fn a_card_that_pauses_is_told_of_and_what_it_left_out_is_missing() {
    let Some(cards) = Cards::or_skip("pause") else {
        return;
    };
    let codes = noise(4.0);
    let pause = (2.0, Duration::from_millis(2500));
    play(cards.pipe("live"), &codes, pause);
    let said = output(&mut cards.listen(&[
        "--device",
        "live",
        "--seconds",
        "5.5",
        "--record",
        "live.wav",
    ]));
    let words = text(&said.stderr);
    assert!(words.contains("no samples for 2 s"), "{words}");
    assert!(words.contains("samples come again, after 2."), "{words}");
    assert!(words.contains("in one place at "), "{words}");
    let heard = codes_of(&cards.path("live.wav"));
    let zeros = heard
        .windows(1000)
        .filter(|w| w.iter().all(|x| *x == 0))
        .count();
    // 2.5 s are missing, to a tenth.
    let missing_s = (zeros + 999) as f64 / FS as f64;
    assert!((missing_s - 2.5).abs() < 0.1, "{missing_s} s: {words}");
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_listening() {
    let Some(cards) = Cards::or_skip("full disk") else {
        return;
    };
    cards.plays("mill", &noise(7.0));
    let program = env!("CARGO_BIN_EXE_rarma");
    let words = "listen --device mill --seconds 6 --json --record full.wav";
    // No file may grow beyond 128 KiB, and that is an error, not a signal.
    let mut shell = Command::new("sh");
    let limited = "trap '' XFSZ; ulimit -f 256; exec \"$0\" \"$@\"";
    shell.args(["-c", limited, program]).args(words.split(' '));
    shell
        .env("HOME", cards.0.path())
        .current_dir(cards.0.path());
    let said = output(&mut shell);
    let told = text(&said.stderr);
    assert_eq!(said.status.code(), Some(4), "{told}");
    assert!(
        told.contains("no more is recorded, it listens on"),
        "{told}"
    );
    let last = lines(&said.stdout).pop().expect("a last line");
    assert_eq!(last["summary"]["samples"], 6 * FS, "{told}");
    assert!(
        codes_of(&cards.path("full.wav")).len() >= FS,
        "what fitted stays"
    );
}

#[test]
fn standard_output_that_is_full_or_closed_ends_it() {
    let Some(cards) = Cards::or_skip("standard output") else {
        return;
    };
    cards.plays("mill", &noise(7.0));
    let mut listen = cards.listen(&["--device", "mill", "--seconds", "6", "--json"]);
    let full = File::options()
        .write(true)
        .open("/dev/full")
        .expect("a device");
    let said = output(listen.stdout(full).stderr(Stdio::piped()));
    assert_eq!(said.status.code(), Some(4), "{}", text(&said.stderr));
    let (reader, writer) = io::pipe().expect("a pipe");
    drop(reader);
    let said = output(listen.stdout(writer).stderr(Stdio::piped()));
    assert_eq!(said.status.code(), Some(141), "{}", text(&said.stderr));
}
