//! Promise: the loop holds with a real controller: a virtual cut at the speed at which LinuxCNC's
//! spindle really turns chatters, is heard, LinuxCNC is ordered another speed, and the cut is
//! stable; its operator wins, and a stop gives back.
//!
//! `cargo verify --only "loop with LinuxCNC"` installs LinuxCNC and runs it. Elsewhere it is
//! skipped, and says so, unless `RARMA_REQUIRE_LINUXCNC` is set.
#![cfg(target_os = "linux")]

use host_tests::act_loop::{Judged, play};
use host_tests::advice::Case;
use host_tests::files::Folder;
use host_tests::linuxcnc::{COMPONENT, LinuxCnc, RealTime};
use rarma_cli::controller::{self, Actor, Chatter, What};
use rarma_core::act::ActConfig;
use std::thread;
use std::time::{Duration, Instant};

/// Cuts that chatter, with a pocket within reach, at speeds that LinuxCNC's simulated spindle
/// has; seeds as in act_loop.
const CUTS: usize = 3;
const SEEDS: u64 = 300_000;
/// Its drive reaches less than this; slower the loop takes too long.
const RPM: core::ops::Range<f64> = 3000.0..24_000.0;

fn is_there() -> bool {
    let there = std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|p| p.join("linuxcnc").is_file()));
    let required = std::env::var_os("RARMA_REQUIRE_LINUXCNC").is_some();
    if required {
        assert!(
            there,
            "linuxcnc is not in the path: install linuxcnc-uspace"
        );
    } else {
        println!(
            "SKIPPED: the loop with LinuxCNC: run `cargo verify --only \"loop with LinuxCNC\"`"
        );
    }
    required
}

fn actor(case: Option<&Case>) -> Actor {
    let port = controller::LinuxCnc::open(COMPONENT, true).expect("it listens");
    let about = Chatter {
        teeth: case.map_or(3, |c| c.cut.teeth() as u32),
        structure: case.map(|c| c.structure),
        power: None,
    };
    let config = ActConfig::limits(true, 0.5, 1.5);
    Actor::new(Box::new(port), config, about, None).expect("in range")
}

/// Steps by the clock; it chatters at this, Hz, or does not. What has ended, and why.
fn go(actor: &mut Actor, begun: Instant, seconds: f64, chatter_hz: Option<f64>) -> Vec<String> {
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let mut ends = Vec::new();
    while Instant::now() < end {
        let t_s = begun.elapsed().as_secs_f64();
        actor.heard(t_s, chatter_hz);
        let step = actor.step(t_s, |record| {
            if let What::Ends { why, .. } = record.what {
                ends.push(why.to_owned());
            }
        });
        step.expect("no log");
        thread::sleep(Duration::from_millis(20));
    }
    ends
}

fn in_force(actor: &Actor) -> f64 {
    actor.reading().expect("a report").overrides.spindle
}

fn cut(mill: &mut LinuxCnc, case: &Case) -> Judged {
    let hz = case.cut.spindle_hz();
    mill.say(&format!("run {:.3} 60", 60.0 * hz));
    let mut actor = actor(Some(case));
    let begun = Instant::now();
    // Until it turns as programmed.
    let turns = |actor: &Actor| {
        let actual = actor.reading().and_then(|r| r.actual_hz).unwrap_or(0.0);
        (actual / hz - 1.0).abs() < 0.01
    };
    while !turns(&actor) {
        assert!(
            begun.elapsed() < Duration::from_secs(15),
            "{:?}",
            actor.reading()
        );
        go(&mut actor, begun, 0.1, None);
    }
    let mut clock = RealTime::from_now(hz);
    let played = play(case, &mut actor, &mut clock);
    let judged = played.judge(case, None);
    println!(
        "seed {}, {:.0} 1/min, {} teeth, behind the clock by {:.3} s at most: {judged:.3?}",
        case.cut.seed,
        60.0 * hz,
        case.cut.teeth(),
        clock.late_s
    );
    for record in &played.records {
        println!("{}", controller::words(record));
    }
    drop(actor);
    mill.say("abort");
    thread::sleep(Duration::from_secs(1));
    judged
}

#[test]
fn a_real_controller_turns_chattering_cuts_to_a_stable_speed() {
    if !is_there() {
        return;
    }
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());

    // What its operator and a stop do, first.
    mill.say("run 11000 60");
    let begun = Instant::now();
    let mut hand = actor(None);
    go(&mut hand, begun, 3.0, None);
    assert_eq!(go(&mut hand, begun, 0.2, Some(1007.0)), [] as [&str; 0]);
    go(&mut hand, begun, 1.0, None);
    let ordered = in_force(&hand);
    assert!((0.5..0.95).contains(&ordered), "{ordered}");
    mill.say("override 105");
    assert_eq!(go(&mut hand, begun, 0.5, None), ["operator"]);
    assert_eq!(go(&mut hand, begun, 1.0, Some(1007.0)), [] as [&str; 0]);
    assert!(
        (in_force(&hand) - 1.05).abs() < 0.001,
        "{}",
        in_force(&hand)
    );
    mill.say("abort");
    go(&mut hand, begun, 0.5, None);
    mill.say("run 11000 60");
    go(&mut hand, begun, 3.0, None);
    go(&mut hand, begun, 0.2, Some(1007.0));
    go(&mut hand, begun, 1.0, None);
    assert!(in_force(&hand) < 0.95);
    mill.say("estop");
    let ends = go(&mut hand, begun, 1.5, None);
    assert!(ends == ["stopped"] || ends == ["program-end"], "{ends:?}");
    assert!((in_force(&hand) - 1.0).abs() < 0.001);
    drop(hand);

    let cases = (SEEDS..).filter_map(|seed| Case::milled(seed, &RPM));
    let judged: Vec<Judged> = cases.take(CUTS).map(|case| cut(&mut mill, &case)).collect();
    let stable = judged
        .iter()
        .filter(|j| j.end_stable && j.orders > 0)
        .count();
    assert!(2 * stable > CUTS, "{judged:#?}");
}
