//! Promise: `rarma box`, `decode`, `connect` and `monitor` of a record do what they say, as
//! programs.

use host_tests::files::Folder;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

fn rarma(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> (Output, Vec<Value>) {
    let output = rarma(arguments).output().expect("a program");
    let text = String::from_utf8(output.stdout.clone()).expect("UTF-8");
    let lines = text.lines().filter_map(|l| serde_json::from_str(l).ok());
    let lines = lines.collect();
    (output, lines)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a name")
}

/// Messages of one kind.
fn of<'a>(lines: &'a [Value], kind: &str) -> Vec<&'a Value> {
    let messages = lines.iter().map(|l| &l["message"][kind]);
    messages.filter(|m| !m.is_null()).collect()
}

#[test]
fn scenario_with_a_broken_coil_trips_is_cleared_and_comes_up_again() {
    let folder = Folder::default();
    let record = folder.path().join("cers.frames");
    let (output, lines) = run(&[
        "box",
        "--sim",
        "box-cers-fault",
        "--json",
        "--record",
        text(&record),
    ]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let faults = of(&lines, "Fault");
    assert_eq!(faults[0]["record"]["code"], "CoilOpen");
    assert_eq!(faults[0]["record"]["place"], 2);
    let stages: Vec<&str> = of(&lines, "Status")
        .iter()
        .filter_map(|s| s["stage"].as_str())
        .collect();
    let mut order = stages.clone();
    order.dedup();
    assert!(
        order.windows(2).any(|w| w == ["Ready", "Faulted"])
            && order.windows(2).any(|w| w == ["Faulted", "Off"])
            && order.ends_with(&["Ready", "Off"]) | order.ends_with(&["Stopping", "Off"]),
        "{order:?}"
    );
    let summary = &lines.last().expect("a summary")["summary"];
    assert_eq!(
        (summary["trips"].as_u64(), summary["missing"].as_u64()),
        (Some(1), Some(0))
    );
    // The record says the same as the run did.
    let (output, decoded) = run(&["decode", text(&record), "--json"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(decoded[..], lines[..lines.len() - 1]);
}

#[test]
fn exciter_measures_lines_and_listens_without_calling_chatter() {
    let (output, lines) = run(&["box", "--sim", "box-cers-steps", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let excitation = of(&lines, "Excitation");
    let measured: Vec<_> = excitation.iter().filter(|e| !e["Line"].is_null()).collect();
    assert_eq!(measured.len(), 30);
    let stages: Vec<&str> = of(&lines, "Status")
        .iter()
        .filter_map(|s| s["stage"].as_str())
        .collect();
    for stage in ["Exciting", "Ready"] {
        assert!(stages.contains(&stage), "{stage}");
    }
    // It shakes the structure with sines: what it hears is modes, and no verdict.
    assert!(of(&lines, "Alarm").is_empty());
    let verdicts = of(&lines, "Verdict");
    let excited = verdicts.iter().filter(|v| v["reason"] == "Excited");
    let modes: usize = excited
        .map(|v| v["modes"].as_array().map_or(0, Vec::len))
        .sum();
    assert!(modes > 300, "{modes}");
    // Faults of a coil are not the magnets'.
    let folder = Folder::default();
    let path = folder.path().join("both.toml");
    let text_of = "name = \"b\"\nabout = \"b\"\nduration_s = 1.0\nhears = \"quiet\"\nmagnets = true\nfault = [{ kind = \"coil-open\", at_s = 0.5 }]\n";
    std::fs::write(&path, text_of).expect("a file");
    let (output, _) = run(&["box", "--sim", text(&path), "--json"]);
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("coil-open") && said.contains("magnets"),
        "{said}"
    );
}

#[test]
fn cut_heard_over_a_bad_link_is_called_and_its_record_replayed() {
    let folder = Folder::default();
    let record = folder.path().join("bad.frames");
    let (output, lines) = run(&[
        "box",
        "--sim",
        "box-bad-link",
        "--json",
        "--record",
        text(&record),
    ]);
    assert_eq!(output.status.code(), Some(1), "chatter: {output:?}");
    let summary = &lines.last().expect("a summary")["summary"];
    let count = |name: &str| summary[name].as_u64().expect("a number");
    assert!(
        count("missing") > 5 && count("broken") > 5 && count("chatter") >= 1,
        "{summary}"
    );
    assert!(of(&lines, "Alarm").iter().any(|a| a["on"] == true));
    let wav = folder.path().join("bad.wav");
    let (output, _) = run(&["decode", text(&record), "--json", "--wav", text(&wav)]);
    assert_eq!(output.status.code(), Some(0));
    let reader = hound::WavReader::open(&wav).expect("a WAV");
    assert_eq!(reader.spec().sample_rate, 48_000);
    // Two seconds, less what was lost at the ends.
    let length = f64::from(reader.duration()) / 48_000.0;
    assert!((1.9..=2.001).contains(&length), "{length}");
}

#[test]
fn record_of_a_stream_is_monitored_like_a_recording() {
    let folder = Folder::default();
    let scenario = folder.path().join("stream.toml");
    std::fs::write(
        &scenario,
        "name = \"stream\"\nabout = \"a stream of the demonstration\"\nduration_s = 9.0\nhears = \"chatter-onset\"\nhost = [{ at_s = 0.05, say = \"stream 8.9\" }]\n",
    )
    .expect("a scenario");
    let record = folder.path().join("stream.frames");
    let (output, lines) = run(&[
        "box",
        "--sim",
        text(&scenario),
        "--json",
        "--record",
        text(&record),
    ]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let box_call = of(&lines, "Alarm")
        .iter()
        .find(|a| a["on"] == true)
        .map(|a| {
            (
                a["sample"].as_f64().expect("a sample") / 48_000.0,
                a["frequency"].as_f64().expect("Hz"),
            )
        })
        .expect("a call");
    let (output, monitored) = run(&["monitor", text(&record), "--rpm", "1680", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let alarm = &monitored.last().expect("a summary")["summary"]["alarms"][0];
    let (on, f) = (
        alarm["on"].as_f64().expect("s"),
        alarm["f"].as_f64().expect("Hz"),
    );
    // The stream begins 0.05 s later than the box's own listening, and is of 16 bits; lines are
    // judged every 0.05 s. At the call the line is one window's, in the summary a mean.
    assert!((on + 0.05 - box_call.0).abs() < 0.11, "{on} {box_call:?}");
    assert!((f / box_call.1 - 1.0).abs() < 0.1, "{f} {box_call:?}");
}

struct Served {
    child: Child,
    address: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn serve(scenario: &str, more: &[&str]) -> Served {
    let mut arguments = vec!["box", "--sim", scenario, "--listen", "127.0.0.1:0"];
    arguments.extend(more);
    let mut child = rarma(&arguments)
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    let mut line = String::new();
    let out = child.stdout.take().expect("its output");
    BufReader::new(out).read_line(&mut line).expect("a line");
    let address = line
        .trim()
        .rsplit(' ')
        .next()
        .expect("an address")
        .to_owned();
    Served { child, address }
}

/// A scenario that only waits, and the file of a key.
fn idle(folder: &Folder) -> (String, String) {
    let scenario = folder.path().join("idle.toml");
    std::fs::write(
        &scenario,
        "name = \"idle\"\nabout = \"waits for a host\"\nduration_s = 60.0\nhears = \"quiet\"\n",
    )
    .expect("a scenario");
    let key = folder.path().join("box.key");
    std::fs::write(
        &key,
        format!("{}\n", "00112233445566778899aabbccddeeff".repeat(2)),
    )
    .expect("a key");
    (text(&scenario).to_owned(), text(&key).to_owned())
}

/// Runs until a line of JSON is what is looked for, or the program ends.
fn until(child: &mut Child, mut is_it: impl FnMut(&Value) -> bool) -> bool {
    let out = child.stdout.as_mut().expect("its output");
    let lines = BufReader::new(out).lines().map_while(Result::ok);
    lines
        .filter_map(|line| serde_json::from_str(&line).ok())
        .any(|line: Value| is_it(&line["message"]))
}

#[test]
fn connect_arms_sets_reads_and_records_over_a_socket() {
    let folder = Folder::default();
    let (scenario, key) = idle(&folder);
    let served = serve(&scenario, &["--key", &key]);
    let port = format!("tcp:{}", served.address);
    let record = folder.path().join("live.frames");
    let mut arguments = vec!["connect", &port, "--json", "--key", &key, "--seconds", "6"];
    arguments.extend(["--record", text(&record)]);
    for words in [
        "set monitor.threshold 0.02",
        "save monitor.threshold",
        "set monitor.threshold 9",
        "start cers",
        "arm",
        "stream 1",
    ] {
        arguments.extend(["--say", words]);
    }
    let (output, lines) = run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("heartbeats begin"), "{said}");
    let answers: Vec<&Value> = of(&lines, "Reply").iter().map(|r| &r["answer"]).collect();
    assert!(
        answers
            .iter()
            .any(|a| a["Setting"]["stored"]["Real"] == 0.02)
    );
    assert!(
        answers
            .iter()
            .any(|a| !a["Refused"]["Setting"]["Range"].is_null())
    );
    assert!(
        of(&lines, "Status")
            .iter()
            .any(|s| s["stage"] == "Ready" && s["energised"] == true),
        "{said}"
    );
    let samples: usize = of(&lines, "Raw")
        .iter()
        .map(|r| r["samples"].as_array().map_or(0, Vec::len))
        .sum();
    assert!((40_000..=48_000).contains(&samples), "{samples}");
    // It has given control up, and the outputs went down in order: no fault.
    let (_, lines) = run(&["connect", &port, "--json", "--seconds", "1", "--look"]);
    let last = of(&lines, "Status")
        .last()
        .copied()
        .cloned()
        .expect("a status");
    assert_eq!(
        (&last["energised"], &last["fault"]),
        (&Value::Bool(false), &Value::Null)
    );
    assert_eq!(last["control"]["why"], "GivenUp");
    let output = rarma(&["connect", &port, "--settings"])
        .output()
        .expect("a program");
    let page = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        page.lines()
            .any(|l| l.starts_with("monitor.threshold") && l.contains("0.02")),
        "{page}"
    );
    assert!(
        page.lines()
            .any(|l| l.starts_with("link.key") && l.contains(" set ") && !l.contains("0011"))
    );
    assert_eq!(page.lines().count(), rarma_box::settings::SETTINGS.len());
}

/// Two programs on one box: the second looks on until it takes over, and both are told; the
/// connection of the one in control is cut while outputs are on.
#[test]
fn one_controls_the_other_looks_on_and_a_cut_connection_lets_go() {
    let folder = Folder::default();
    let (scenario, key) = idle(&folder);
    let served = serve(&scenario, &["--key", &key]);
    let port = format!("tcp:{}", served.address);
    let control = ["connect", &port, "--json", "--key", &key];
    let mut first = rarma(&[&control[..], &["--say", "start cers", "--say", "arm"]].concat())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    assert!(until(&mut first, |m| m["Status"]["stage"] == "Ready"));
    let (output, lines) = run(&[
        &control[..],
        &["--seconds", "2", "--say", "current 1.5", "--say", "take"],
    ]
    .concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("is in control; `take` takes it"), "{said}");
    assert!(said.contains("this host is in control"), "{said}");
    let answers: Vec<&Value> = of(&lines, "Reply").iter().map(|r| &r["answer"]).collect();
    assert!(answers.iter().any(|a| a["Refused"] == "NotInControl"));
    assert!(of(&lines, "Control").iter().any(|c| c["why"] == "Taken"));
    assert!(of(&lines, "Status").iter().any(|s| s["stage"] == "Off"));
    // The first is told, too.
    assert!(until(&mut first, |m| m["Control"]["why"] == "Taken"));
    let _ = first.kill();
    let said = first.wait_with_output().expect("it ends");
    assert!(!said.status.success());

    let served = serve(&scenario, &["--key", &key]);
    let port = format!("tcp:{}", served.address);
    let arguments = [
        "connect",
        &port,
        "--json",
        "--key",
        &key,
        "--say",
        "start cers",
        "--say",
        "arm",
    ];
    let mut cut = rarma(&arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    assert!(until(&mut cut, |m| m["Status"]["stage"] == "Ready"));
    let _ = cut.kill();
    let _ = cut.wait();
    let mut next = rarma(&["connect", &port, "--json", "--look"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    let lost = until(&mut next, |m| {
        m["Status"]["fault"]["code"] == "HeartbeatLost"
            && m["Status"]["energised"] == false
            && m["Status"]["control"]["why"] == "HostLost"
            && m["Status"]["press_again"] == true
    });
    let _ = next.kill();
    let _ = next.wait();
    assert!(lost);
}

/// Over a network, a box without a key changes nothing; with one, nothing without it.
#[test]
fn over_a_network_nothing_is_changed_without_the_key() {
    let folder = Folder::default();
    let (scenario, key) = idle(&folder);
    for (more, says) in [
        (&[][..], "the box has no key"),
        (&["--key", &key][..], "the key is missing or another one"),
    ] {
        let served = serve(&scenario, more);
        let port = format!("tcp:{}", served.address);
        let (output, lines) = run(&[
            "connect",
            &port,
            "--json",
            "--seconds",
            "2",
            "--say",
            "start cers",
            "--say",
            "arm",
        ]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let replies = of(&lines, "Reply");
        let refused = if more.is_empty() { "NoKey" } else { "Seal" };
        let count = replies
            .iter()
            .filter(|r| r["answer"]["Refused"] == refused)
            .count();
        // Take, start, the heartbeat and the arm.
        assert!(count >= 4, "{count} {replies:?}");
        assert!(of(&lines, "Status").iter().all(|s| s["stage"] == "Off"));
        let output = rarma(&["connect", &port, "--set-key", &key])
            .output()
            .expect("a program");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            (output.status.code(), said.lines().count()),
            (Some(4), 1),
            "{said}"
        );
        assert!(said.contains(says), "{said}");
    }
}

#[test]
fn wrong_usage_and_bad_input_are_said_in_one_line() {
    let folder = Folder::default();
    let file = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        text(&path).to_owned()
    };
    let bad = "name = \"x\"\nabout = \"y\"\nduration_s = 1.0\nhears = \"quiet\"\n";
    let short = file("short.key", b"0011\n");
    let cases: [(&[&str], i32, &str); 9] = [
        (&["box"], 2, "--sim"),
        (&["box", "--sim", "nothing-of-that-name"], 3, "open"),
        (
            &[
                "box",
                "--sim",
                &file(
                    "f.toml",
                    format!("{bad}fault = [{{ kind = \"flu\", at_s = 1 }}]\n").as_bytes(),
                ),
            ],
            3,
            "coil-open",
        ),
        (
            &[
                "box",
                "--sim",
                &file(
                    "h.toml",
                    format!("{bad}host = [{{ at_s = 1, say = \"dance\" }}]\n").as_bytes(),
                ),
            ],
            3,
            "dance",
        ),
        (
            &["decode", &file("g.frames", &[7; 5000])],
            3,
            "no whole frame",
        ),
        (&["connect", "tcp:127.0.0.1:1"], 3, "open"),
        (
            &["connect", "tcp:127.0.0.1:1", "--key", &short],
            3,
            "short.key: line 1: 4 characters where a key has 64 hexadecimal digits",
        ),
        (
            &["connect", "tcp:127.0.0.1:1", "--key", "nokey.hex"],
            3,
            "nokey.hex: open: no such file",
        ),
        (
            &["connect", "tcp:127.0.0.1:1", "--say", "dance"],
            2,
            "is no command",
        ),
    ];
    for (arguments, code, says) in cases {
        let output = rarma(arguments).output().expect("a program");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(says), "{arguments:?}: {said}");
        if code == 3 {
            assert_eq!(said.lines().count(), 1, "{said}");
        }
    }
}
