//! What is lost of the sound, and sound that is none.

use crate::chromium::Microphone;
use crate::page::Page;
use crate::sound::Sound;
use crate::told;
use std::fs;
use std::process::Command;
use std::thread;
use std::time::Duration;

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
    // None as long as what the browser loses by itself, which is 10 ms.
    let holes = [(2.0, 0.014), (2.5, 0.027), (3.0, 0.09), (3.5, 0.3)];
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
    // The microphone is unplugged: what was heard until then stays.
    page.browser.value(
        "import('./main.js').then(({microphone}) => { microphone.track.dispatchEvent(new Event('ended')); return 0; })",
    );
    page.ended(20.0);
    let message = page.text("messages");
    assert!(message.contains("has gone away"), "{message}");
    assert!(page.text("heard").contains("Save sound"));
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
    for (name, sound, says, ends) in [
        ("muted", muted, "unmute the input", "No verdict"),
        ("clipped", clipped, "lower the gain", "at full scale"),
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
        if name == "muted" {
            page.press("stop");
        } else {
            // The computer has slept for two hours meanwhile.
            page.browser.value("import('./main.js').then(({microphone}) => { microphone.node.port.onmessage({ data: { slept_s: 7200 } }); return 0; })");
        }
        let summary = page.ended(20.0);
        let words = [page.text("verdict"), page.text("messages")].concat();
        assert!(words.contains(ends), "{name}: {words}");
        assert_eq!(words.contains("slept for 120 min"), name == "clipped");
        assert_eq!(
            summary["alarms"].as_array().map(Vec::len),
            Some(0),
            "{name}"
        );
    }
}
