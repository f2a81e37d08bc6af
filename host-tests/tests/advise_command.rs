//! Promise: `rarma advise` says per alarm which speed to turn instead, in words and in JSON, and
//! what it must be told to say it; `monitor --json` has the same as `advice` of an alarm where
//! speed and teeth are told, and is to the byte what it was where they are not.

use host_tests::files::Folder;
use host_tests::process::Ended;
use host_tests::rarma;
use rarma_plants::truth::roots;
use rarma_scenarios::scenario::load;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const SPEED_AND_TEETH: &str = "--rpm 1680 --teeth 6";

/// A face mill that cuts into chatter and out of it, 9 s.
fn cut(folder: &Folder) -> PathBuf {
    let file = folder.path().join("cut.wav");
    let text = file.to_str().expect("a name");
    let ended = rarma!().run(["simulate", "chatter-onset", "--out", text]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    file
}

fn on(command: &str, file: &Path, options: &str) -> Ended {
    rarma!().on(command, file, options)
}

fn last(ended: &Ended) -> Value {
    ended.json_lines().pop().expect("a line")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number: {value}"))
}

#[test]
fn a_speed_per_alarm_in_words_and_json() {
    let folder = Folder::default();
    let file = cut(&folder);
    let answer = last(&on("advise", &file, &format!("{SPEED_AND_TEETH} --json")));
    assert_eq!(answer["missing"], Value::Array(Vec::new()));
    let alarms = answer["alarms"].as_array().expect("alarms");
    assert_eq!(alarms.len(), 1, "{answer}");
    let advice = &alarms[0]["advice"];
    let waves = number(&alarms[0]["f"]) / (number(&advice["rpm"]) / 60.0 * 6.0);
    assert!((number(&advice["waves"]) - waves).abs() < 0.002, "{advice}");
    let [low, high] = [0, 1].map(|i| number(&advice["reach_rpm"][i]));
    assert!((low / 840.0 - 1.0).abs() < 0.01 && (high / 2520.0 - 1.0).abs() < 0.01);
    for speed in advice["speeds"].as_array().expect("speeds") {
        let rpm = number(&speed["rpm"]);
        assert!((low..=high).contains(&rpm), "{speed}");
        let chance = number(&speed["chance"]);
        assert!((0.0..=1.0).contains(&chance), "{speed}");
    }
    let said = on("advise", &file, SPEED_AND_TEETH).stdout;
    assert!(
        said.contains("What to do:") && said.contains("1/min"),
        "{said}"
    );
}

#[test]
fn the_reach_is_kept() {
    let folder = Folder::default();
    let file = cut(&folder);
    let options = format!("{SPEED_AND_TEETH} --json --reach 70:110");
    let advice = |more: &str| {
        let answer = last(&on("advise", &file, &format!("{options} {more}")));
        answer["alarms"][0]["advice"].clone()
    };
    let plain = advice("");
    assert!((number(&plain["reach_rpm"][1]) / number(&plain["rpm"]) - 1.1).abs() < 1e-3);
    let weak = advice("--power 1.02");
    assert!((number(&weak["reach_rpm"][1]) / number(&weak["rpm"]) - 1.02).abs() < 1e-3);
    let same_feed = advice("--power 1.02 --same-feed");
    assert!((number(&same_feed["reach_rpm"][1]) / number(&same_feed["rpm"]) - 1.1).abs() < 1e-3);
    for speed in same_feed["speeds"].as_array().expect("speeds") {
        assert_eq!(speed["feed_ratio"], 1.0);
    }
}

#[test]
fn what_is_missing_is_said() {
    let folder = Folder::default();
    let file = cut(&folder);
    for (options, missing) in [
        ("", vec!["speed", "teeth"]),
        ("--rpm 1680", vec!["teeth"]),
        ("--teeth 6", vec!["speed"]),
    ] {
        let answer = last(&on("advise", &file, &format!("{options} --json")));
        assert_eq!(answer["missing"], Value::from(missing), "{options}");
        assert!(answer["alarms"][0].get("advice").is_none(), "{answer}");
    }
    let said = on("advise", &file, "--rpm 1680").stdout;
    assert!(
        said.contains("--teeth") && !said.contains("--rpm,"),
        "{said}"
    );
}

#[test]
fn the_monitor_has_it_where_it_can_be_said_and_else_says_what_it_said() {
    let folder = Folder::default();
    let file = cut(&folder);
    let summary = |options: &str| last(&on("monitor", &file, &format!("{options} --json")));
    let with = summary(SPEED_AND_TEETH);
    let alarm = &with["summary"]["alarms"][0];
    let advised = last(&on("advise", &file, &format!("{SPEED_AND_TEETH} --json")));
    assert_eq!(alarm, &advised["alarms"][0]);
    // It is said when the alarm is called, too: in the next line, and in no other.
    let all = on("monitor", &file, &format!("{SPEED_AND_TEETH} --json")).json_lines();
    let of_lines: Vec<&Value> = all.iter().filter(|l| l.get("advice").is_some()).collect();
    assert_eq!(of_lines.len(), 1);
    // By the frequency at the call: that of the summary is the mean over the alarm.
    let [then, mean] = [&of_lines[0]["advice"], &alarm["advice"]];
    assert_eq!(then["rpm"], mean["rpm"]);
    assert!(
        (number(&then["waves"]) / number(&mean["waves"]) - 1.0).abs() < 0.02,
        "{then} {mean}"
    );
    let after = number(&of_lines[0]["t"]) - number(&alarm["on"]);
    assert!((0.0..=0.02).contains(&after), "{after}");
    for options in ["", "--rpm 1680"] {
        assert!(
            !summary(options).to_string().contains("advice"),
            "{options}"
        );
    }
}

#[test]
fn a_pipe_says_it_at_the_call() {
    let folder = Folder::default();
    let file = cut(&folder);
    let said = |options: &str| {
        let child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
            .args(["monitor", "-"])
            .args(options.split_whitespace())
            .stdin(std::fs::File::open(&file).expect("a file"))
            .output()
            .expect("started");
        String::from_utf8(child.stdout).expect("text")
    };
    let with = said(SPEED_AND_TEETH);
    let mut lines = with.lines().skip_while(|line| !line.contains("CHATTER"));
    let (called, next) = (lines.next().expect("called"), lines.next().expect("advice"));
    assert!(called.contains("CHATTER"), "{with}");
    assert!(
        next.trim_start().starts_with("Turn ") || next.contains("No stable speed"),
        "{with}"
    );
    assert!(!said("--rpm 1680").contains("1/min instead"));
    // A file is over: there it is said at the end, by `advise` and on the page.
    assert!(
        !on("monitor", &file, SPEED_AND_TEETH)
            .stdout
            .contains("1/min instead")
    );
}

#[test]
fn the_page_says_what_to_do_first() {
    let folder = Folder::default();
    let file = cut(&folder);
    let page = |options: &str| {
        let dir = folder.path().join("page");
        let report = format!("{options} --report {}", dir.display());
        on("monitor", &file, &report);
        std::fs::read_to_string(dir.join("index.html")).expect("a page")
    };
    let with = page(SPEED_AND_TEETH);
    let place = |text: &str| with.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(place("What to do") < place("What was seen"));
    assert!(with.contains("Speeds within reach") && with.contains("Lobes, as heard"));
    let without = page("--rpm 1680");
    assert!(without.contains("What to do") && without.contains("number of teeth"));
    assert!(!without.contains("Speeds within reach"));
}

#[test]
fn what_is_known_of_other_cuts_counts_and_is_remembered() {
    let folder = Folder::default();
    let file = cut(&folder);
    let cuts = folder.path().join("cuts.csv");
    let known = format!("{SPEED_AND_TEETH} --known {} --depth-mm 2", cuts.display());
    let first = |options: &str| {
        let answer = last(&on("advise", &file, &format!("{options} --json")));
        answer["alarms"][0]["advice"]["speeds"][0]["rpm"].as_f64()
    };
    let before = first(SPEED_AND_TEETH).expect("a speed");
    // Heard a first time: the file is made, with the alarm in it.
    assert_eq!(first(&format!("{known} --remember")), Some(before));
    let text = std::fs::read_to_string(&cuts).expect("cuts");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!((lines.len(), lines[0]), (2, "rpm,state,f,depth"));
    assert!(
        lines[1].contains(",chatter,") && lines[1].ends_with(",2"),
        "{text}"
    );
    // The proposed speed was tried since, and chatters: another one is proposed, or none.
    std::fs::write(&cuts, format!("{text}{before},chatter,,2")).expect("written");
    let second = first(&known);
    let is_other = second.is_none_or(|rpm| (rpm / before - 1.0).abs() > 0.01);
    assert!(is_other, "{before} {second:?}");
    // A line is added to what has no end of line, and nothing of it is lost.
    first(&format!("{known} --remember"));
    let text = std::fs::read_to_string(&cuts).expect("cuts");
    assert_eq!(text.lines().count(), 4, "{text}");
    assert!(text.contains(&format!("{before},chatter,,2\n")), "{text}");
}

#[test]
fn a_list_of_cuts_that_is_none_is_refused_before_anything_is_heard() {
    let folder = Folder::default();
    let file = cut(&folder);
    let cuts = folder.path().join("cuts.csv");
    for (text, options, code, says) in [
        ("rpm,state\n0,stable\n", "", 3, "line 2"),
        ("rpm\n100\n", "", 3, "no column state"),
        ("rpm,state,depth\n100,stable,1\n", "", 2, "--depth-mm"),
        (
            "state,rpm\nstable,100\n",
            "--remember",
            2,
            "rpm,state,f,depth",
        ),
    ] {
        std::fs::write(&cuts, text).expect("written");
        let options = format!("{SPEED_AND_TEETH} --known {} {options}", cuts.display());
        let ended = on("advise", &file, &options);
        assert_eq!(ended.code, Some(code), "{text}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{text}: {}", ended.stderr);
        assert_eq!(ended.stdout, "", "{text}");
        assert_eq!(std::fs::read_to_string(&cuts).expect("cuts"), text);
    }
    let absent = format!(
        "{SPEED_AND_TEETH} --known {}/none.csv",
        folder.path().display()
    );
    assert_eq!(on("advise", &file, &absent).code, Some(3));
}

/// The three-mode miller, which chatters.
fn three_modes(folder: &Folder) -> PathBuf {
    let file = folder.path().join("three.wav");
    let text = file.to_str().expect("a name");
    let ended = rarma!().run(["simulate", "three-mode-chatter", "--out", text]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    file
}

#[test]
fn a_machine_that_is_told_tells_a_stable_speed() {
    let folder = Folder::default();
    let file = three_modes(&folder);
    let options = "--rpm 11000 --teeth 3";
    let machine = format!("{options} --machine three-mode-chatter --json");
    let answer = last(&on("advise", &file, &machine));
    let advice = &answer["alarms"][0]["advice"];
    assert_eq!(advice["machine"], "explains", "{answer}");
    let process = load("three-mode-chatter", None)
        .expect("shipped")
        .scenario
        .process;
    let depth_m = process.depth().largest();
    let rpm = number(&advice["speeds"][0]["rpm"]);
    let there = process.at_spindle_hz(rpm / 60.0);
    let root = roots(&there, f64::INFINITY, depth_m, 1).expect("roots")[0];
    assert!(root.growth_per_s < 0.0, "{rpm}: {root:?}");
    assert!(number(&advice["speeds"][0]["chance"]) > 0.5, "{advice}");
    // The same is said again, and the page has it, too.
    let dir = folder.path().join("page");
    let report = format!("{machine} --report {}", dir.display());
    assert_eq!(last(&on("advise", &file, &report)), answer);
    let page = std::fs::read_to_string(dir.join("index.html")).expect("a page");
    assert!(page.contains(&format!("{rpm:.0}")), "{rpm}");
    // Without it nothing of it is said.
    let plain = last(&on("advise", &file, &format!("{options} --json")));
    assert!(plain["alarms"][0]["advice"]["machine"].is_null());
    assert!(plain["alarms"][0]["advice"]["waves"].is_number());
    // Another machine, which does not chatter here: the advice is as without it, and it is said.
    let other = format!("{options} --machine spindle-10000");
    let said = on("advise", &file, &other).stdout;
    assert!(said.contains("does not chatter at this speed"), "{said}");
    let other = last(&on("advise", &file, &format!("{other} --json")));
    let mut advice = other["alarms"][0]["advice"].clone();
    assert_eq!(advice["machine"], "contradicts");
    advice.as_object_mut().expect("an object").remove("machine");
    assert_eq!(advice, plain["alarms"][0]["advice"]);
}

#[test]
fn a_machine_of_another_cut_is_refused_before_anything_is_heard() {
    let folder = Folder::default();
    let file = folder.path().join("no.wav");
    let absent = folder.path().join("absent.toml").display().to_string();
    for (machine, options, code, says) in [
        (absent.as_str(), "--rpm 11000 --teeth 3", 3, "absent.toml"),
        (
            "turning-980",
            "--rpm 11000 --teeth 3",
            2,
            "it is turned with 1 edge, and --teeth is 3",
        ),
        (
            "three-mode-chatter",
            "--rpm 11000 --teeth 2",
            2,
            "with 3 teeth, and --teeth is 2",
        ),
    ] {
        for command in ["advise", "act"] {
            let more = if command == "act" {
                "--controller dry"
            } else {
                ""
            };
            let ended = on(
                command,
                &file,
                &format!("{options} {more} --machine {machine}"),
            );
            assert_eq!(
                ended.code,
                Some(code),
                "{command} {machine}: {}",
                ended.stderr
            );
            assert!(
                ended.stderr.contains(says),
                "{command} {machine}: {}",
                ended.stderr
            );
            assert_eq!(ended.stderr.trim().lines().count(), 1, "{}", ended.stderr);
        }
    }
}

#[test]
fn odd_options_are_refused() {
    let folder = Folder::default();
    let file = folder.path().join("no.wav");
    for options in [
        "--reach 100",
        "--reach 120:80",
        "--reach 10:100",
        "--reach nan:100",
        "--power 0",
        "--power x",
        "--remember",
        "--depth-mm 0",
        "--machine-sd 1",
        "--machine three-mode-chatter --machine-sd 0",
        "--machine three-mode-chatter --machine-sd 11",
    ] {
        let ended = on("advise", &file, options);
        assert_eq!(ended.code, Some(2), "{options}");
    }
}
