//! Promise: what other programs write is heard: through a pipe as from the file, with a codec of
//! telephones and in videos, whole or cut short.
//!
//! Without ffmpeg these are skipped, loudly; `RARMA_REQUIRE_FFMPEG=1` makes that a failure.

use host_tests::encoder::Encoder;
use host_tests::files::Folder;
use host_tests::rarma;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

const OPTIONS: &str = "--rpm 1680 --teeth 6 --json";

/// The demonstration, which chatters.
fn cut(folder: &Folder) -> PathBuf {
    let path = folder.path().join("cut.wav");
    let to = path.to_str().expect("UTF-8");
    let made = rarma!().run(["simulate", "chatter-onset", "--out", to]);
    assert_eq!(made.code, Some(0), "{made:?}");
    path
}

/// Begin, s, and frequency, Hz, of its alarms.
fn alarms(summary: &Value) -> Vec<(f64, f64)> {
    let all = summary["alarms"].as_array().expect("a list");
    all.iter()
        .filter_map(|a| Some((a["on"].as_f64()?, a["f"].as_f64()?)))
        .collect()
}

#[test]
fn what_ffmpeg_writes_into_a_pipe_is_heard_as_its_file() {
    let Some(encoder) = Encoder::or_skip("ffmpeg in a pipe") else {
        return;
    };
    let folder = Folder::default();
    let phone = encoder.make(&cut(&folder), "-c:a aac", &folder.path().join("phone.m4a"));
    let file = encoder.make(&phone, "", &folder.path().join("decoded.wav"));
    let of_file = rarma!().on("monitor", &file, OPTIONS);
    assert_eq!(of_file.code, Some(1), "{of_file:?}");
    let mut ffmpeg = Command::new("ffmpeg")
        .args(["-loglevel", "error", "-nostdin", "-i"])
        .arg(&phone)
        .args(["-f", "wav", "-"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("ffmpeg");
    let pipe = ffmpeg.stdout.take().expect("its output");
    let mut monitor = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"));
    monitor.args(["monitor", "-"]).args(OPTIONS.split(' '));
    let of_pipe = monitor.stdin(pipe).output().expect("rarma");
    assert!(ffmpeg.wait().expect("its end").success());
    assert_eq!(of_pipe.status.code(), of_file.code);
    assert!(String::from_utf8_lossy(&of_pipe.stdout) == of_file.stdout);
}

#[test]
fn vorbis_and_the_sound_of_videos_are_heard() {
    let Some(encoder) = Encoder::or_skip("videos") else {
        return;
    };
    let folder = Folder::default();
    let wav = cut(&folder);
    let (_, summary) = rarma!().on("monitor", &wav, OPTIONS).monitored();
    let expected = alarms(&summary);
    assert_eq!(expected.len(), 1, "{summary}");
    let sound = [OsStr::new("-i"), wav.as_os_str()];
    let picture = ["-f", "lavfi", "-i", "color=size=64x64:rate=10"].map(OsStr::new);
    let film = [&sound[..], &picture[..]].concat();
    let both = "-shortest -map 0:a -map 1:v -c:a aac -b:a 128k -c:v";
    for (name, input, options) in [
        ("cut.ogg", &sound[..], "-c:a libvorbis -b:a 128k".to_owned()),
        ("cut.mp4", &film, format!("{both} mpeg4")),
        ("cut.mov", &film, format!("{both} mjpeg")),
    ] {
        let path = encoder.run(input, &options, &folder.path().join(name));
        let ended = rarma!().on("monitor", &path, OPTIONS);
        let (_, summary) = ended.monitored();
        let heard = alarms(&summary);
        let same =
            |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - b.0).abs() < 0.8 && (a.1 - b.1).abs() < 1.0;
        assert!(
            heard.len() == 1 && heard.iter().zip(&expected).all(same),
            "{name}: {heard:?} for {expected:?}"
        );
        assert!(ended.stderr.contains("damping"), "{name}: {}", ended.stderr);
    }
}

/// A telephone that was switched off while it wrote has no index; one that was copied in part
/// has, and is heard as far as it goes.
#[test]
fn a_recording_of_a_phone_that_was_cut_short_is_heard_or_refused_in_a_line() {
    let Some(encoder) = Encoder::or_skip("cut short") else {
        return;
    };
    let folder = Folder::default();
    let wav = cut(&folder);
    for (name, options, heard) in [
        ("index-first.m4a", "-c:a aac -movflags +faststart", true),
        ("index-last.m4a", "-c:a aac", false),
    ] {
        let path = encoder.make(&wav, options, &folder.path().join(name));
        let bytes = fs::read(&path).expect("a file");
        fs::write(&path, &bytes[..bytes.len() * 8 / 10]).expect("written");
        let ended = rarma!().on("monitor", &path, OPTIONS);
        if heard {
            let (_, summary) = ended.monitored();
            assert_eq!(alarms(&summary).len(), 1, "{name}: {summary}");
            assert!(ended.stderr.contains(name), "{name}: {}", ended.stderr);
        } else {
            assert_eq!(ended.code, Some(3), "{name}: {ended:?}");
            assert_eq!(ended.stderr.lines().count(), 1, "{name}: {}", ended.stderr);
        }
    }
}
