//! Promise: the loop holds with a real controller: a virtual cut at the speed at which LinuxCNC's
//! spindle really turns chatters, the box's firmware hears it, LinuxCNC is ordered another speed, and the cut is
//! stable; its operator wins, and whatever fails gives back.
//!
//! `cargo verify --only "loop with LinuxCNC"` installs LinuxCNC and runs it. Elsewhere it is
//! skipped, and says so, unless `RARMA_REQUIRE_LINUXCNC` is set.
#![cfg(target_os = "linux")]

use host_tests::act_ear::Firmware;
use host_tests::act_judge::{Judged, Kind, SEEDS, drawn};
use host_tests::act_loop::{FS_HZ, LIMITS, play_heard, simulated};
use host_tests::acting::{Acting, RPM as ACTING_RPM, acts, ends_given_back, log_lines};
use host_tests::advice::Case;
use host_tests::bars::{all_judged, holds};
use host_tests::files::Folder;
use host_tests::linuxcnc::{COMPONENT, LinuxCnc, RealTime};
use host_tests::rarma;
use host_tests::statistics::quantile;
use rarma_cli::controller::{self, Actor};
use rarma_core::act::ActConfig;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Speeds that LinuxCNC's simulated spindle reaches in some seconds, 1/min.
const RPM: core::ops::Range<f64> = 3000.0..24_000.0;

/// There can be one at a time on a computer.
static ONE: Mutex<()> = Mutex::new(());

fn is_there() -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|p| p.join("linuxcnc").is_file()))
}

/// The turn of a test that needs it, if it is to run.
fn turn() -> Option<MutexGuard<'static, ()>> {
    if std::env::var_os("RARMA_REQUIRE_LINUXCNC").is_none() {
        println!(
            "SKIPPED: the loop with LinuxCNC: run `cargo verify --only \"loop with LinuxCNC\"`"
        );
        return None;
    }
    assert!(
        is_there(),
        "linuxcnc is not in the path: install linuxcnc-uspace"
    );
    Some(ONE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// What is told of a machine beside its teeth.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Told {
    /// Frequencies and damping of its modes.
    Modes,
    /// All of it, usually wrong.
    Machine,
}

fn cut(mill: &mut LinuxCnc, case: &Case, told: Told) -> Judged {
    let hz = case.cut.spindle_hz();
    // Charts take seconds: before anything turns.
    let about = match told {
        Told::Modes => case.about(),
        Told::Machine => case.about_with_machine(),
    };
    mill.say(&format!("run {:.3} 60", 60.0 * hz));
    let port = controller::LinuxCnc::open(COMPONENT, true).expect("it listens");
    let config = ActConfig::limits(true, LIMITS.0, LIMITS.1);
    let mut actor = Actor::new(Box::new(port), config, about, None).expect("in range");
    let begun = Instant::now();
    // Until it turns as programmed.
    let turns = |actor: &Actor| {
        let actual = actor.reading().and_then(|r| r.actual_hz).unwrap_or(0.0);
        (actual / hz - 1.0).abs() < 0.01
    };
    while !turns(&actor) {
        let last = actor.reading();
        assert!(begun.elapsed() < Duration::from_secs(15), "{last:?}");
        let t_s = begun.elapsed().as_secs_f64();
        actor.step(t_s, |_| {}).expect("no log");
        thread::sleep(Duration::from_millis(20));
    }
    let mut firmware = Firmware::of(case, FS_HZ);
    let mut clock = RealTime::from_now(hz);
    let played = play_heard(case, &mut firmware, &mut actor, &mut clock);
    drop(actor);
    mill.say("abort");
    let unturned = simulated(case, false, case.about());
    let judged = played.judge(case, Some(&unturned));
    println!(
        "{:.0} 1/min, {} teeth, behind the clock by {:.3} s at most: {judged:?}",
        60.0 * hz,
        case.cut.teeth(),
        clock.late_s
    );
    for record in &played.records {
        println!("{}", controller::words(record));
    }
    judged
}

/// So many cuts of a kind that were called (or are stable); those that were not called are said.
fn cuts(mill: &mut LinuxCnc, kind: Kind, count: usize, told: Told) -> Vec<Judged> {
    let mut out = Vec::new();
    for case in (SEEDS..).filter_map(|seed| drawn(seed, kind, &RPM)) {
        if out.len() == count {
            break;
        }
        let judged = cut(mill, &case, told);
        if kind == Kind::Stable || judged.called_s.is_some() {
            out.push(judged);
        } else {
            println!("seed {}: not called in the time of a run", judged.seed);
        }
    }
    out
}

fn count(all: &[Judged], what: impl Fn(&Judged) -> bool) -> usize {
    all.iter().filter(|j| what(j)).count()
}

#[test]
fn a_real_controller_turns_chattering_cuts_to_a_stable_speed() {
    let Some(_turn) = turn() else {
        return;
    };
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());
    let pocket = cuts(&mut mill, Kind::Pocket, 4, Told::Modes);
    let turned = |j: &Judged| j.end_stable && j.orders > 0;
    assert!(count(&pocket, turned) >= 3, "{pocket:#?}");
    let inside = |j: &Judged| (LIMITS.0 - 0.01..=LIMITS.1 + 0.01).contains(&j.end_ratio);
    assert!(pocket.iter().all(inside), "{pocket:#?}");
    let stable = cuts(&mut mill, Kind::Stable, 2, Told::Modes);
    assert!(stable.iter().all(|j| j.orders == 0), "{stable:#?}");
}

#[test]
fn a_real_controller_turns_cuts_with_their_machine_told() {
    let Some(_turn) = turn() else {
        return;
    };
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());
    let pocket = cuts(&mut mill, Kind::Pocket, 2, Told::Machine);
    let turned = |j: &Judged| j.end_stable && j.orders > 0;
    assert!(count(&pocket, turned) >= 1, "{pocket:#?}");
}

/// The program as a user runs it: sound on standard input, as fast as it sounds.
#[test]
fn the_program_hears_orders_logs_and_gives_back() {
    let Some(_turn) = turn() else {
        return;
    };
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());
    // As it ends by itself, and as it is ended.
    for (signal, code) in [(None, 1), (Some("INT"), 130), (Some("TERM"), 130)] {
        mill.run_up(ACTING_RPM);
        let said = Folder::default();
        let log = said.path().join("act.jsonl");
        let options = format!(
            "--controller linuxcnc --act --override 80:120 --log {}",
            log.display()
        );
        let mut acting = Acting::begin(rarma!(), said.path(), &options);
        // Lower than any but an order would have it; it is sent no further than it may.
        let mut least = 1.0_f64;
        acting.until("an order stands", || {
            least = least.min(mill.factor());
            acts(&log).iter().any(|act| act == "arrived")
        });
        least = least.min(mill.factor());
        assert!((0.8 - 1e-6..0.95).contains(&least), "{least}");
        match signal {
            Some(signal) => acting.signal(signal),
            None => acting.end_sound(),
        }
        let ended = acting.ended();
        assert_eq!(ended.code, Some(code), "{signal:?}: {ended:?}");
        // It is said to be back within half a percent, and HAL goes on by itself.
        let factor = mill.factor();
        assert!((factor - 1.0).abs() < 0.007, "{signal:?}: {factor}");
        let lines = log_lines(&log);
        let ordered = lines.iter().find(|line| line["act"] == "ordered");
        let to = ordered.and_then(|line| line["to"]["spindle"].as_f64());
        assert!(to.is_some_and(|to| (80.0..95.0).contains(&to)), "{lines:?}");
        ends_given_back(&lines);
        mill.say("abort");
    }
}

#[test]
#[ignore = "half an hour, and LinuxCNC"]
fn a_real_controller_turns_chattering_cuts_to_a_stable_speed_long() {
    let mut mill = long("act, long", Told::Modes);
    let stable = cuts(&mut mill.0, Kind::Stable, 50, Told::Modes);
    let orders: usize = stable.iter().map(|j| j.orders).sum();
    println!(
        "of 50 stable: orders {orders}, alarms {}",
        count(&stable, |j| j.called_s.is_some())
    );
    holds("act, long: orders in stable cuts", orders as f64, 0.0..=0.0);
    all_judged("act, long");
}

#[test]
#[ignore = "half an hour, and LinuxCNC"]
fn a_real_controller_turns_cuts_with_their_machine_told_long() {
    let _mill = long("act with the machine told, long", Told::Machine);
    all_judged("act with the machine told, long");
}

/// 50 cuts with a pocket and 20 without; gives back the mill that is still there, and what it needs until it
/// has gone.
fn long(form: &str, told: Told) -> (LinuxCnc, Folder, MutexGuard<'static, ()>) {
    assert!(
        is_there(),
        "linuxcnc is not in the path: install linuxcnc-uspace"
    );
    let turn = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());
    let middle = |all: &[Judged], figure: &dyn Fn(&Judged) -> Option<f64>| {
        let values: Vec<f64> = all.iter().filter_map(figure).collect();
        assert!(!values.is_empty(), "nothing to take the middle of");
        quantile(&values, 0.5)
    };
    let pocket = cuts(&mut mill, Kind::Pocket, 50, told);
    let without = cuts(&mut mill, Kind::None, 20, told);
    let ends = |j: &Judged| j.end_stable && j.orders > 0;
    let end_stable = count(&pocket, ends);
    let less = |db: Option<f64>| db.is_some_and(|db| db >= 15.0);
    let (total, chatter) = (
        count(&pocket, |j| ends(j) && less(j.less_db)),
        count(&pocket, |j| ends(j) && less(j.chatter_less_db)),
    );
    let none_wrong = count(&pocket, |j| j.none_said && j.orders == 0);
    let heard_off = |j: &Judged| !j.heard_ratio.is_some_and(|r| (r - 1.0).abs() < 0.02);
    let after_s = middle(&pocket, &|j| j.stable_after_s);
    let released_s = middle(&pocket, &|j| j.released_after_s);
    let false_calls: usize = pocket.iter().map(|j| j.false_calls).sum();
    let said = count(&without, |j| j.none_said && j.orders == 0);
    println!(
        "| of 50 with a pocket: end stable | \"no speed\" said | frequency heard off by 2 % | and not stable at the end | vibration 15 dB less | chatter 15 dB less | stable after, s | released after, s | false calls |\n|---|---|---|---|---|---|---|---|---|\n| {end_stable} | {none_wrong} | {} | {} | {total} | {chatter} | {after_s:.2} | {released_s:.2} | {false_calls} |\nof 20 without: none said {said}, any order {}",
        count(&pocket, heard_off),
        count(&pocket, |j| heard_off(j) && !ends(j)),
        count(&without, |j| j.orders > 0),
    );
    let bar = |what: &str| format!("{form}: {what}");
    holds(&bar("of 50 end stable"), end_stable as f64, 48.0..=50.0);
    holds(
        &bar("of 50 vibration 15 dB less"),
        total as f64,
        48.0..=50.0,
    );
    holds(
        &bar("of 50 chatter 15 dB less"),
        chatter as f64,
        48.0..=50.0,
    );
    holds(&bar("stable after the call, s"), after_s, 0.0..=0.5);
    holds(&bar("released after that, s"), released_s, 0.0..=0.6);
    holds(&bar("false calls"), false_calls as f64, 0.0..=0.0);
    holds(&bar("of 20 none said"), said as f64, 19.0..=20.0);
    (mill, folder, turn)
}
