//! Promise: a Grbl is ordered by override bytes, within the limits, one step after the other; its
//! operator wins; what is ordered is given back.

use host_tests::files::Folder;
use host_tests::grbl::Grbl;
use rarma_cli::controller::{self, ActRecord, Actor, Chatter, What};
use rarma_core::act::ActConfig;
use rarma_scenarios::scenario;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const RPM: f64 = 11_000.0;
/// Chatter of three-mode-chatter: 88 % is proposed.
const CHATTER_HZ: f64 = 1007.0;
const ORDERED: i32 = 88;

struct Play {
    grbl: Grbl,
    actor: Actor,
    begun: Instant,
    chatter_hz: Option<f64>,
    records: Vec<ActRecord>,
}

impl Play {
    fn begin() -> Self {
        let grbl = Grbl::running(RPM);
        let port = controller::Grbl::open(&grbl.port, 115_200).expect("a port");
        let about = Chatter {
            teeth: 3,
            ..Chatter::default()
        };
        let config = ActConfig::limits(true, 0.8, 1.2);
        let actor = Actor::new(Box::new(port), config, about, None).expect("in range");
        Self {
            grbl,
            actor,
            begun: Instant::now(),
            chatter_hz: None,
            records: Vec::new(),
        }
    }

    fn go(&mut self, seconds: f64) {
        let end = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < end {
            let t_s = self.begun.elapsed().as_secs_f64();
            self.actor.heard(t_s, self.chatter_hz);
            let step = self.actor.step(t_s, |record| self.records.push(record));
            step.expect("no log");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Goes on until the speed's override is so, and a little longer.
    fn go_to(&mut self, percent: i32) {
        for _ in 0..100 {
            if self.grbl.state().spindle == percent {
                break;
            }
            self.go(0.1);
        }
        self.go(0.4);
        assert_eq!(self.grbl.state().spindle, percent, "{:#?}", self.records);
    }

    /// Chatter, and the order that follows has arrived.
    fn ordered() -> Self {
        let mut play = Self::begin();
        play.go(0.4);
        play.chatter_hz = Some(CHATTER_HZ);
        play.go(0.2);
        play.chatter_hz = None;
        play.go_to(ORDERED);
        play
    }

    fn ends(&self) -> Vec<&str> {
        let ends = self.records.iter().filter_map(|r| match &r.what {
            What::Ends { why, .. } => Some(*why),
            _ => None,
        });
        ends.collect()
    }
}

#[test]
fn an_override_is_ordered_step_by_step_and_given_back() {
    let mut play = Play::ordered();
    assert_eq!(play.grbl.state().feed, ORDERED);
    let known = [b'?', 0x9C, 0x9D, 0x93, 0x94];
    let t_s = play.begun.elapsed().as_secs_f64();
    play.actor.end(t_s);
    play.go_to(100);
    let state = play.grbl.state().clone();
    assert_eq!(
        (state.spindle, state.feed),
        (100, 100),
        "{:#?}",
        play.records
    );
    assert_eq!(state.ends, (ORDERED, 100), "it never went too far");
    assert!(state.bytes.iter().all(|b| known.contains(b)));
    assert!(play.records.iter().any(|r| r.what == What::Returned));
}

#[test]
fn the_operator_wins() {
    let mut play = Play::ordered();
    play.grbl.state().spindle = 98;
    play.go(0.4);
    play.chatter_hz = Some(CHATTER_HZ);
    play.go(1.5);
    assert_eq!(play.ends(), ["operator"]);
    assert_eq!(play.grbl.state().spindle, 98);
}

#[test]
fn an_override_that_is_refused_is_said() {
    let mut play = Play::begin();
    play.grbl.state().refuses = true;
    play.go(0.4);
    play.chatter_hz = Some(CHATTER_HZ);
    play.go(3.5);
    assert_eq!(play.ends(), ["refused"]);
    assert_eq!(play.grbl.state().spindle, 100);
}

#[test]
fn a_program_that_ends_and_an_alarm_give_back() {
    for (name, why) in [("Idle", "program-end"), ("Alarm", "stopped")] {
        let mut play = Play::ordered();
        play.grbl.state().name = name;
        play.go(2.2);
        assert_eq!(play.ends(), [why]);
        assert_eq!(
            play.grbl.state().spindle,
            100,
            "{name}: {:#?}",
            play.records
        );
    }
}

#[test]
fn a_spindle_that_does_not_follow_is_given_back() {
    let mut play = Play::ordered();
    // The drive goes no faster: what is reported is not what is commanded.
    play.grbl.state().most_rpm = 0.8 * RPM;
    play.go(0.5);
    play.go_to(100);
    assert_eq!(play.ends(), ["speed"], "{:#?}", play.records);
}

#[test]
fn a_cable_that_is_pulled_is_said() {
    let mut play = Play::ordered();
    play.grbl.pull();
    play.go(3.0);
    let gone = |r: &ActRecord| matches!(r.what, What::Gone { .. });
    assert!(play.records.iter().any(gone), "{:#?}", play.records);
    assert!(!play.actor.holds());
}

/// The program as a user runs it: sound on standard input, as fast as it sounds.
#[test]
fn the_program_hears_orders_logs_and_gives_back() {
    let grbl = Grbl::running(RPM);
    let folder = Folder::default();
    let log = folder.path().join("act.jsonl");
    let said = folder.path().join("said.jsonl");
    let loaded = scenario::load("three-mode-chatter", Some(1)).expect("a scenario");
    let cut = rarma_plants::cut::VirtualCut::new(&loaded.scenario).expect("a cut");
    let fs = cut.sample_rate_hz();
    let samples: Vec<f32> = cut.map(|r| r.value).collect();
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(["act", "-", "--raw", "f32", "--fs", &fs.to_string()])
        .args(["--teeth", "3", "--act", "--override", "80:120", "--json"])
        .args(["--controller", &format!("grbl:{}", grbl.port)])
        .arg("--log")
        .arg(&log)
        .stdin(Stdio::piped())
        // A pipe that nobody reads would hold it up.
        .stdout(std::fs::File::create(&said).expect("a file"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let mut input = child.stdin.take().expect("a pipe");
    let begun = Instant::now();
    let mut lowest = 100;
    for (k, block) in samples.chunks((fs / 50.0) as usize).enumerate() {
        let bytes: Vec<u8> = block.iter().flat_map(|x| x.to_le_bytes()).collect();
        input.write_all(&bytes).expect("it listens");
        lowest = lowest.min(grbl.state().spindle);
        let due = Duration::from_millis(20 * k as u64);
        thread::sleep(due.saturating_sub(begun.elapsed()));
    }
    drop(input);
    let output = child.wait_with_output().expect("ended");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!((80..=95).contains(&lowest), "{lowest}: {stderr}");
    assert_eq!(grbl.state().spindle, 100, "{stderr}");
    let text = std::fs::read_to_string(log).expect("a log");
    let acts: Vec<String> = text
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"))
        .map(|line| line["act"].as_str().expect("an act").to_owned())
        .collect();
    for act in [
        "begins", "proposed", "ordered", "arrived", "ends", "returned",
    ] {
        assert!(acts.iter().any(|a| a == act), "{act}: {acts:?}");
    }
    let said = std::fs::read_to_string(said).expect("lines");
    assert!(said.contains("\"act\":\"ordered\""), "{said}");
}
