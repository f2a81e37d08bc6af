//! Promise: the page in a real browser calls chatter when the command does, reports every gap,
//! stays below 5 % of the audio thread's time, works without a network, on a narrow screen and with
//! the keyboard, and says what to do where it cannot listen.
//!
//! Needs the built page (`RARMA_WEB_PAGE`, from `cargo xtask web`) and Chromium; without them these
//! are skipped, loudly. `RARMA_REQUIRE_BROWSER=1` makes that a failure. Sound takes its time: each
//! pass through the demonstration is 6 s. `RARMA_PASSES` says how many there are.

// What tests write nobody keeps.
#![allow(clippy::disallowed_methods)]

mod chromium;
mod page;
mod sound;

use chromium::Microphone;
use page::Page;
use serde_json::Value;
use sound::{RPM, Sound, TEETH};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::thread;
use std::time::Duration;
use tempfile::TempDir;

/// Before the demonstration, s: longer than a busy computer takes to begin to listen.
const SILENCE_S: f64 = 1.5;

/// The demonstration in a file.
fn demonstration(folder: &TempDir) -> (Sound, PathBuf) {
    let sound = Sound::of_the_demonstration();
    let path = folder.path().join("demonstration.wav");
    sound.write(&path);
    (sound, path)
}

fn told(page: &mut Page) {
    page.write("speed", &RPM.to_string());
    page.write("teeth", &TEETH.to_string());
}

fn first_call(summary: &Value) -> f64 {
    summary["alarms"][0]["on"].as_f64().expect("an alarm")
}

/// Listens for so long.
fn listen(page: &mut Page, seconds: f64) -> Value {
    page.press("listen");
    page.browser.wait(
        "sound",
        "import('./main.js').then(({heard_so_far}) => heard_so_far.at(-1)?.by_ear?.begun)",
        20.0,
    );
    thread::sleep(Duration::from_secs_f64(seconds));
    page.picture("listening");
    page.press("stop");
    page.ended(20.0)
}

/// Measures in the audio thread, and ends the listening that was begun for it.
fn cost_of_a_block(page: &mut Page) {
    page.press("listen");
    page.browser.wait(
        "sound",
        "import('./main.js').then(({heard_so_far}) => heard_so_far.at(-1)?.by_ear?.begun)",
        20.0,
    );
    // Some 3 s of sound at once, again and again: other programs that run meanwhile count as well,
    // least in the least of them.
    let blocks = 1024.0;
    let least = (0..8)
        .map(|_| {
            let took = page.browser.value(&format!(
                "import('./main.js').then(({{microphone}}) => microphone.measure({blocks}))"
            ));
            took.as_f64().expect("ms")
        })
        .fold(f64::INFINITY, f64::min);
    let block_ms = 1e3 * 128.0 / page.newest("now.fs").as_f64().expect("a rate");
    let share = least / blocks / block_ms;
    println!(
        "a block takes {:.4} ms of {block_ms:.2} ms: {:.2} %",
        least / blocks,
        100.0 * share
    );
    assert!(share < 0.05, "{share}");
    page.press("stop");
    page.ended(20.0);
}

#[test]
fn every_pass_through_the_microphone_is_called_when_the_command_calls_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let demonstration = Sound::of_the_demonstration();
    let file = folder.path().join("after-silence.wav");
    demonstration.after_silence(SILENCE_S).write(&file);
    let test = "every_pass_through_the_microphone";
    let Some(mut page) = Page::open(test, Microphone::Hears(&file)) else {
        return;
    };
    told(&mut page);
    let passes = std::env::var("RARMA_PASSES").map_or(2, |n| n.parse().expect("a number"));
    let by_command = demonstration.by_the_command().alarms[0].on;
    for pass in 1..=passes {
        let summary = listen(&mut page, 6.0);
        let heard = Sound::read(&page.saved("sound"));
        let called = first_call(&summary);
        // The sound of the last second before the end, and where it was in what was played.
        let (offset, likeness) = demonstration.offset_of(&heard, 5.3, (-0.1, 0.1));
        let by_ear = page.newest("now.by_ear.alarms[0].on").as_f64();
        let missing = page.newest("now.last.missing");
        println!(
            "pass {pass}: called at {called:.3} s, by the command at {by_command:.3} s; off by {:.1} ms at 5.3 s (correlation {likeness:.3}); missing {missing}",
            1e3 * offset
        );
        assert!(likeness > 0.95, "pass {pass}: {likeness}");
        assert!(
            (called - by_command).abs() < 0.1,
            "pass {pass}: {called}, {by_command}"
        );
        assert_eq!(
            by_ear,
            Some(first_call(&summary)),
            "audio thread and worker"
        );
        // The command on what was saved says the same, if nothing was missing.
        if missing["samples"] == 0 {
            let again = heard.by_the_command().alarms[0].on;
            assert!(
                (again - first_call(&summary)).abs() < 1e-9,
                "pass {pass}: {again}"
            );
        }
    }
    let report = String::from_utf8(page.saved("report")).expect("a page");
    assert!(
        report.contains("Chatter at") && report.contains("What to do"),
        "the report"
    );
    assert!(
        !report.contains("http://") && !report.contains("https://"),
        "no request"
    );
    cost_of_a_block(&mut page);
}

/// Processes that a browser has started, of the kind that an option names.
fn processes(browser: u32, kind: &str) -> Vec<u32> {
    let all = fs::read_dir("/proc").expect("Linux").flatten();
    let parents: Vec<(u32, u32)> = all
        .filter_map(|entry| {
            let pid = entry.file_name().to_str()?.parse().ok()?;
            let about = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
            // The name before it may hold anything.
            let parent = about.rsplit(')').next()?.split_whitespace().nth(1)?;
            Some((pid, parent.parse().ok()?))
        })
        .collect();
    let mut family = vec![browser];
    let mut k = 0;
    while let Some(parent) = family.get(k).copied() {
        family.extend(parents.iter().filter(|p| p.1 == parent).map(|p| p.0));
        k += 1;
    }
    let is = |pid: &u32| {
        let line = fs::read_to_string(format!("/proc/{pid}/cmdline"));
        line.is_ok_and(|line| line.contains(kind))
    };
    family.into_iter().filter(is).collect()
}

/// Stops processes for so long, as a busy computer does.
fn stall(pids: &[u32], seconds: f64) {
    let send = |signal: &str| {
        for pid in pids {
            // One that has ended meanwhile is not stopped.
            let _ = Command::new("kill")
                .args([signal, &pid.to_string()])
                .status();
        }
    };
    send("-STOP");
    thread::sleep(Duration::from_secs_f64(seconds));
    send("-CONT");
}

/// Runs of zeros, as browsers put them in for what they lose, at these times, s, and so long, s.
fn with_holes(sound: &Sound, holes: &[(f64, f64)]) -> Sound {
    let mut samples = sound.samples.clone();
    for (from, length) in holes {
        let place = |t: f64| (t * sound.fs) as usize;
        samples[place(*from)..place(from + length)].fill(0.0);
    }
    Sound {
        samples,
        fs: sound.fs,
    }
}

#[test]
fn every_gap_is_told_and_none_is_called_chatter() {
    let folder = tempfile::tempdir().expect("a folder");
    let holes = [(2.0, 0.01), (2.5, 0.02), (3.0, 0.09), (3.5, 0.3)];
    let once = with_holes(&Sound::of_the_demonstration(), &holes);
    let sound = Sound {
        samples: [once.samples.clone(), once.samples].concat(),
        fs: once.fs,
    };
    let file = folder.path().join("holes.wav");
    sound.write(&file);
    let test = "every_gap_is_told";
    let Some(mut page) = Page::open(test, Microphone::Hears(&file)) else {
        return;
    };
    told(&mut page);
    page.press("listen");
    page.browser.wait(
        "the first call",
        "document.getElementById('time').innerText.match(/^4[.]/)",
        20.0,
    );
    let missing = page.newest("now.last.missing");
    let seconds = missing["samples"].as_f64().unwrap() / page.newest("now.fs").as_f64().unwrap();
    let expected: f64 = holes.iter().map(|hole| hole.1).sum();
    println!(
        "holes of {expected:.3} s in {}: told {seconds:.4} s in {}",
        holes.len(),
        missing["gaps"]
    );
    // A loaded computer loses more; what was put in is there at least.
    assert!(
        missing["gaps"].as_u64() >= Some(holes.len() as u64),
        "{missing}"
    );
    assert!(seconds > expected - 0.002, "{seconds}");
    assert_eq!(page.newest("now.last.alarms_so_far"), 0, "no early call");
    let message = page.text("messages");
    assert!(message.contains("gaps in the sound"), "{message}");

    // The sound system stops for a while, then the page itself does: both are gaps.
    let browser = page.browser.process();
    for (kind, seconds) in [("audio.mojom.AudioService", 0.4), ("--type=renderer", 1.0)] {
        let before = page.newest("now.by_ear.missing.samples").as_f64().unwrap();
        let stalled = processes(browser, kind);
        assert!(!stalled.is_empty(), "{kind}");
        stall(&stalled, seconds);
        thread::sleep(Duration::from_millis(1500));
        let after = page.newest("now.by_ear.missing.samples").as_f64().unwrap();
        let fs = page.newest("now.fs").as_f64().unwrap();
        println!(
            "{kind} stopped for {seconds} s: {:.3} s told missing",
            (after - before) / fs
        );
        assert!(
            after - before > 0.5 * seconds * fs,
            "{kind}: {before}, {after}"
        );
        assert!(
            after - before < 2.0 * seconds * fs,
            "{kind}: {before}, {after}"
        );
    }
    page.press("stop");
    page.ended(20.0);
}

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
        2
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
}

#[test]
fn it_works_offline_on_a_narrow_screen_in_the_dark_and_by_keyboard() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, file) = demonstration(&folder);
    let test = "it_works_offline";
    let Some(mut page) = Page::open(test, Microphone::Forbidden) else {
        return;
    };
    // Every request so far went to the page's own address.
    let requests: Vec<String> = page.requests();
    assert!(requests.len() > 8, "{requests:?}");
    // Without a server, all of it comes from what was kept, and a file can be heard.
    page.server = None;
    page.reload();
    told(&mut page);
    page.choose(&file);
    let summary = page.ended(60.0);
    assert_eq!(
        summary["alarms"].as_array().map(Vec::len),
        Some(1),
        "{summary}"
    );
    let elsewhere: Vec<String> = page.requests();
    assert!(
        elsewhere.iter().all(|url| page.is_own(url)),
        "{elsewhere:?}"
    );
    // The policy forbids requests elsewhere, whoever asks.
    let asked = page
        .browser
        .value("fetch('https://example.org/').then(() => 'sent', () => 'forbidden')");
    assert_eq!(asked, "forbidden");

    for (width, scheme) in [(1200, "light"), (400, "light"), (400, "dark")] {
        page.screen(width, scheme);
        let wide = page.browser.value("document.documentElement.scrollWidth");
        assert!(wide.as_i64() <= Some(i64::from(width)), "{width}: {wide}");
        page.picture(&format!("{width}-{scheme}"));
    }
    let dark = page
        .browser
        .value("getComputedStyle(document.body).backgroundColor");
    assert_eq!(dark, "rgb(21, 24, 27)");

    // From the top, the tabulator reaches everything, and what is reached can be pressed.
    page.browser.value("document.activeElement.blur()");
    let mut reached = Vec::new();
    for _ in 0..14 {
        page.key("Tab");
        let id = page
            .browser
            .value("document.activeElement.id || document.activeElement.tagName");
        reached.push(id.as_str().unwrap_or_default().to_owned());
    }
    for id in ["listen", "file", "speed", "teeth", "SUMMARY", "gain"] {
        assert!(reached.iter().any(|r| r == id), "{id}: {reached:?}");
    }
    page.browser
        .value("document.getElementById('gain').focus()");
    page.key("Enter");
    assert_eq!(
        page.browser
            .value("document.getElementById('gain-help').open"),
        true
    );
    page.picture("gain");
    page.key("Escape");
    assert_eq!(
        page.browser
            .value("document.getElementById('gain-help').open"),
        false
    );
    // Every field and button has a name for those who do not see it.
    let nameless = page.browser.value(
        "[...document.querySelectorAll('input, select, button, meter')].filter((e) => !(e.labels?.length || e.textContent.trim() || e.ariaLabel)).map((e) => e.id).join()",
    );
    assert_eq!(nameless, "");
    assert!(
        page.browser
            .complaints()
            .iter()
            .all(|c| c.contains("example.org")),
        "{:?}",
        page.browser.complaints()
    );
}

#[test]
fn a_muted_and_a_clipped_microphone_are_told_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let demonstration = Sound::of_the_demonstration();
    let muted = Sound {
        samples: vec![0.0; 480_000],
        fs: 48_000.0,
    };
    let clipped = Sound {
        samples: demonstration
            .samples
            .iter()
            .map(|x| (40.0 * x).clamp(-1.0, 1.0))
            .collect(),
        fs: demonstration.fs,
    };
    for (name, sound, says) in [
        ("muted", muted, "unmute the input"),
        ("clipped", clipped, "lower the gain"),
    ] {
        let file = folder.path().join(format!("{name}.wav"));
        sound.write(&file);
        let test = "a_muted_and_a_clipped_microphone";
        let Some(mut page) = Page::open(test, Microphone::Hears(&file)) else {
            return;
        };
        page.press("listen");
        let waits = format!("document.getElementById('messages').innerText.includes('{says}')");
        page.browser.wait(name, &waits, 20.0);
        page.press("stop");
        let summary = page.ended(20.0);
        assert_eq!(
            summary["alarms"].as_array().map(Vec::len),
            Some(0),
            "{name}"
        );
    }
}
