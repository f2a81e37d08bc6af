//! Files, and what is none; a microphone that may not be heard.

use crate::chromium::Microphone;
use crate::page::Page;
use crate::sound::Sound;
use crate::{demonstration, told};
use serde_json::Value;
use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;
use xtask::process::find_program;

#[test]
fn a_file_is_heard_as_the_command_hears_it_and_what_is_none_is_refused_with_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let (demonstration, file) = demonstration(&folder);
    let test = "a_file_is_heard";
    let Some(mut page) = Page::open(test, Microphone::Forbidden) else {
        return;
    };
    told(&mut page);
    page.choose(&file);
    let summary = page.ended(60.0);
    let by_command = demonstration.by_the_command();
    let expected = serde_json::to_value(&by_command.alarms).expect("JSON");
    let strip = |alarms: &Value| -> Vec<Value> {
        let of = |a: &Value| serde_json::json!([a["on"], a["off"], a["f"], a["zeta"]]);
        alarms.as_array().expect("a list").iter().map(of).collect()
    };
    assert_eq!(strip(&summary["alarms"]), strip(&expected));
    assert_eq!(summary["samples"], demonstration.samples.len());
    assert!(
        page.text("advice").contains("1/min"),
        "{}",
        page.text("advice")
    );

    // What was heard stays, whatever comes after it.
    let bytes = fs::read(&file).expect("a file");
    let clipped = Sound {
        samples: demonstration
            .samples
            .iter()
            .map(|x| (40.0 * x).clamp(-1.0, 1.0))
            .collect(),
        fs: demonstration.fs,
    };
    clipped.write(&folder.path().join("clipped.wav"));
    let silent = Sound {
        samples: vec![0.0; 48_000],
        fs: 48_000.0,
    };
    silent.write(&folder.path().join("muted.wav"));
    let write =
        |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("written");
    write("cut-short.wav", &bytes[..20]);
    write("video.mp4", b"\0\0\0\x20ftypisom no sound in here");
    write("empty.wav", b"");
    for (name, says) in [
        ("clipped.wav", "lower the gain and record again"),
        ("muted.wav", "check the sensor, its cable"),
        ("cut-short.wav", "copy it again"),
        ("video.mp4", "Convert it to WAV"),
        ("empty.wav", "Copy it again"),
    ] {
        page.choose(&folder.path().join(name));
        let waits = format!("document.getElementById('messages').innerText.includes('{name}')");
        page.browser.wait(name, &waits, 20.0);
        let message = page.text("messages");
        println!("{name}: {message}");
        assert!(message.contains(says), "{name}: {message}");
        assert_eq!(
            page.browser
                .value("document.querySelectorAll('#heard li').length"),
            1,
            "{name}"
        );
        assert_eq!(
            page.browser
                .value("document.getElementById('listen').disabled"),
            false
        );
    }
    // A file whose end is missing is heard as far as it goes, and that is said.
    write("half.wav", &bytes[..bytes.len() / 2]);
    page.choose(&folder.path().join("half.wav"));
    page.browser.wait("half", "document.getElementById('heard').innerText.includes('half.wav') && !document.getElementById('heard').innerText.includes('listening')", 30.0);
    let message = page.text("messages");
    assert!(message.contains("half.wav: "), "{message}");

    // What telephones write is decoded by the browser, however it is given to the page.
    let mut listed = 2;
    if find_program("ffmpeg").is_none() {
        let required = env::var("RARMA_REQUIRE_FFMPEG").is_ok_and(|value| value == "1");
        assert!(
            !required,
            "{test}: no ffmpeg, and skipping is not allowed here"
        );
        println!("SKIPPED: what telephones write: no ffmpeg on this machine");
    } else {
        for name in [
            "phone.m4a",
            "phone.mp3",
            "phone.flac",
            "phone.ogg",
            "phone.mp4",
        ] {
            let path = folder.path().join(name);
            encode(&file, &path);
            page.drop_file(name, &fs::read(&path).expect("encoded"));
            listed += 1;
            let waits = format!(
                "document.querySelectorAll('#heard li').length === {listed} && !document.getElementById('heard').innerText.includes('listening')"
            );
            page.browser.wait(name, &waits, 60.0);
            let alarms = page.newest("now.summary.alarms");
            let of = |alarms: &Value, key: &str| alarms[0][key].as_f64().unwrap_or(f64::NAN);
            println!("{name}: {alarms}");
            assert!(
                (of(&alarms, "f") - of(&expected, "f")).abs() < 1.0,
                "{name}"
            );
            assert!(
                (of(&alarms, "on") - of(&expected, "on")).abs() < 0.8,
                "{name}"
            );
            let message = page.text("messages");
            assert!(message.contains("decoded by the browser"), "{message}");
        }
    }

    // No permission: said, with what to do, and nothing is lost.
    page.press("listen");
    page.browser.wait(
        "refused",
        "document.getElementById('messages').innerText.includes('may not use')",
        20.0,
    );
    assert_eq!(
        page.browser
            .value("document.querySelectorAll('#heard li').length"),
        listed
    );
    // No device, and one that another program holds.
    for (name, says) in [
        ("NotFoundError", "no such microphone"),
        ("NotReadableError", "another program"),
    ] {
        page.browser.value(&format!(
            "navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException('', '{name}')); 0"
        ));
        page.press("listen");
        let waits = format!("document.getElementById('messages').innerText.includes('{says}')");
        page.browser.wait(name, &waits, 20.0);
    }
    // Stopped while the browser still asks: what it grants then is let go.
    page.browser.value(
        "globalThis.give = null; navigator.mediaDevices.getUserMedia = () => new Promise((go) => { globalThis.give = go; }); 0",
    );
    page.press("listen");
    page.browser.wait("asked", "globalThis.give !== null", 20.0);
    page.drop_file("meanwhile.wav", &bytes);
    assert!(page.text("messages").contains("Press Stop first"));
    page.press("stop");
    assert!(page.text("messages").contains("nothing was heard"));
    page.browser.value(
        "globalThis.granted = new AudioContext().createMediaStreamDestination().stream; globalThis.give(globalThis.granted); 0",
    );
    page.browser.wait(
        "let go",
        "globalThis.granted.getTracks().every((track) => track.readyState === 'ended')",
        20.0,
    );
    assert_eq!(
        page.browser.value(
            "[document.getElementById('listen').disabled, document.getElementById('stop').disabled, document.querySelectorAll('#heard li').length].join()"
        ),
        format!("false,true,{listed}")
    );
}

/// As telephones do it.
fn encode(from: &Path, to: &Path) {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg
        .args(["-loglevel", "error", "-nostdin", "-y", "-i"])
        .arg(from);
    match to.extension().and_then(|e| e.to_str()) {
        Some("mp4") => ffmpeg
            .args(["-f", "lavfi", "-i", "color=size=64x64:rate=10"])
            .args([
                "-shortest",
                "-map",
                "0:a",
                "-map",
                "1:v",
                "-c:v",
                "mpeg4",
                "-c:a",
                "aac",
            ]),
        Some("ogg") => ffmpeg.args(["-c:a", "libvorbis"]),
        _ => &mut ffmpeg,
    };
    let done = ffmpeg.arg(to).output().expect("ffmpeg");
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}
