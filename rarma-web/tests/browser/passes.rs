//! The demonstration by the microphone.

use crate::chromium::Microphone;
use crate::page::Page;
use crate::sound::Sound;
use crate::told;
use serde_json::Value;
use std::thread;
use std::time::Duration;

/// Before the demonstration, s: longer than a busy computer takes to begin to listen.
const SILENCE_S: f64 = 1.5;

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
    // A cut, and not the quiet before it.
    page.browser.wait(
        "the cut",
        "import('./main.js').then(({heard_so_far}) => heard_so_far.at(-1)?.by_ear?.t > 3)",
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
    passes("every_pass_through_the_microphone", 2);
}

#[test]
#[ignore = "ten passes: two minutes"]
fn every_pass_through_the_microphone_is_called_when_the_command_calls_it_long() {
    passes("every_pass_through_the_microphone_long", 10);
}

fn passes(test: &str, passes: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let demonstration = Sound::of_the_demonstration();
    let file = folder.path().join("after-silence.wav");
    demonstration.after_silence(SILENCE_S).write(&file);
    let Some(mut page) = Page::open(test, Microphone::Hears(&file)) else {
        return;
    };
    told(&mut page);
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
