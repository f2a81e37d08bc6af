//! Promise: where it may, it turns chattering cuts to a speed at which they are stable, and leaves
//! a stable cut alone; with a simulated controller. With LinuxCNC itself, and how often:
//! act_linuxcnc.

use host_tests::act_ear::Firmware;
use host_tests::act_judge::{Judged, Kind, SEEDS, drawn, vibration_m};
use host_tests::act_loop::{
    FS_HZ, LENGTH_S, LIMITS, Played, SimulatedController, Spindle, simulated, simulated_heard,
    steady,
};
use host_tests::advice::Case;
use host_tests::bars::{all_judged, holds};
use host_tests::page;
use rarma_cli::controller::{Actor, Chatter, What};
use rarma_core::act::ActConfig;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, Mutex};

const BATCH: u64 = 8;
/// Speeds of the cuts: any, 1/min.
const RPM: Range<f64> = 0.0..1e9;

/// So many cuts of a kind that were called (or are stable), each judged beside the same without orders, and each with
/// several actors, of whom each is told something else.
fn told<const N: usize>(
    kind: Kind,
    count: usize,
    about: [fn(&Case) -> Chatter; N],
) -> [Vec<Judged>; N] {
    let judged = |seed: u64| {
        let case = drawn(seed, kind, &RPM)?;
        let unturned = simulated(&case, false, case.about());
        let turned = |about: fn(&Case) -> Chatter| simulated(&case, true, about(&case));
        Some(about.map(|about| turned(about).judge(&case, Some(&unturned))))
    };
    let mut out = Vec::new();
    let mut begin = SEEDS;
    // Not many more are played than are asked for.
    let at_once = BATCH.min(count as u64);
    while out.len() < count {
        let seeds = begin..begin + at_once;
        let batch: Vec<Option<[Judged; N]>> = seeds.into_par_iter().map(judged).collect();
        let heard = |j: &[Judged; N]| kind == Kind::Stable || j[0].called_s.is_some();
        out.extend(batch.into_iter().flatten().filter(heard));
        begin += at_once;
    }
    out.truncate(count);
    std::array::from_fn(|k| out.iter().map(|all| all[k].clone()).collect())
}

#[test]
fn a_machine_that_is_told_turns_more_of_them() {
    let [modes, machine] = told(Kind::Pocket, 4, [Case::about, Case::about_with_machine]);
    println!("{modes:#?}\n{machine:#?}");
    let count =
        |all: &[Judged], what: &dyn Fn(&Judged) -> bool| all.iter().filter(|j| what(j)).count();
    // Of the fourth it is said with the modes told, wrongly, that there is no speed: docs/act.md.
    let stable = [&modes, &machine].map(|all| count(all, &|j| j.end_stable));
    assert!(stable[0] >= 3 && stable[1] >= stable[0], "{stable:?}");
    assert!(count(&modes, &|j| j.orders > 0) >= 3);
    // Where it ends stable the chatter itself is gone, whatever the teeth force.
    let gone = |j: &Judged| !j.end_stable || j.chatter_less_db.is_some_and(|db| db >= 15.0);
    assert!(modes.iter().all(gone), "{modes:#?}");
    assert!(modes.iter().all(|j| j.false_calls == 0), "{modes:#?}");
}

#[test]
fn stable_cuts_are_left_alone_with_their_machine_told() {
    let both = told(Kind::Stable, 2, [Case::about, Case::about_with_machine]);
    let mut all = both.iter().flatten();
    assert!(all.all(|j| j.orders == 0), "{both:#?}");
}

#[test]
fn the_box_turns_what_its_core_turns() {
    let case = drawn(SEEDS + 9, Kind::Pocket, &RPM).expect("a pocket");
    let unturned = simulated(&case, false, case.about());
    let judged = |played: Played| played.judge(&case, Some(&unturned));
    let core = judged(simulated(&case, true, case.about()));
    let mut firmware = Firmware::of(&case, FS_HZ);
    let on_box = judged(simulated_heard(&case, &mut firmware, true, case.about()));
    println!("{core:#?}\n{on_box:#?}");
    assert!(core.end_stable && on_box.end_stable);
    assert_eq!((core.orders, on_box.orders), (1, 1));
    assert!((core.end_ratio / on_box.end_ratio - 1.0).abs() < 0.02);
    assert_eq!(on_box.false_calls, 0);
    // Its order is the smaller one that it is shipped with; the way over the link takes milliseconds.
    let later = on_box.called_s.expect("called") - core.called_s.expect("called");
    assert!(later.abs() < 0.1, "{later}");
}

/// Cuts of every kind, heard by the core, with the order that it is made with, and by the box, with the smaller one that it is
/// shipped with.
#[test]
#[ignore = "minutes"]
fn the_box_turns_what_its_core_turns_long() {
    let mut same_of = Vec::new();
    for (kind, count) in [(Kind::Pocket, 50), (Kind::None, 20), (Kind::Stable, 50)] {
        let judged = |seed: u64| {
            let case = drawn(seed, kind, &RPM)?;
            let core = simulated(&case, true, case.about()).judge(&case, None);
            let mut firmware = Firmware::of(&case, FS_HZ);
            let on_box = simulated_heard(&case, &mut firmware, true, case.about());
            Some([core, on_box.judge(&case, None)])
        };
        let mut all: Vec<[Judged; 2]> = Vec::new();
        let mut begin = SEEDS;
        while all.len() < count {
            let batch: Vec<_> = (begin..begin + BATCH).into_par_iter().map(judged).collect();
            let heard = |j: &[Judged; 2]| kind == Kind::Stable || j[0].called_s.is_some();
            all.extend(batch.into_iter().flatten().filter(heard));
            begin += BATCH;
        }
        all.truncate(count);
        for (k, name) in ["core", "box"].into_iter().enumerate() {
            let count = |what: &dyn Fn(&Judged) -> bool| all.iter().filter(|j| what(&j[k])).count();
            println!(
                "{kind:?}, {name}: of {} ordered {}, end stable {}, \"no speed\" said {}, called falsely {}",
                all.len(),
                count(&|j| j.orders > 0),
                count(&|j| j.orders > 0 && j.end_stable),
                count(&|j| j.none_said && j.orders == 0),
                count(&|j| j.false_calls > 0),
            );
        }
        let same = |[core, on_box]: &&[Judged; 2]| {
            core.orders == on_box.orders
                && core.end_stable == on_box.end_stable
                && core.none_said == on_box.none_said
        };
        same_of.push((kind, count, all.iter().filter(same).count()));
    }
    for (kind, count, same) in same_of {
        let bar = format!("act by the box, long: of {count} {kind:?} as by the core");
        holds(&bar, same as f64, count as f64..=count as f64);
    }
    all_judged("act by the box, long");
}

/// Told or not, nothing is ordered of a stable cut.
#[test]
#[ignore = "minutes"]
fn stable_cuts_are_left_alone_with_their_machine_told_long() {
    let [stable] = told(Kind::Stable, 50, [Case::about_with_machine]);
    let ordered = stable.iter().filter(|j| j.orders > 0).count();
    let unstable = stable.iter().filter(|j| !j.end_stable).count();
    let called = stable.iter().filter(|j| j.called_s.is_some()).count();
    println!(
        "of 50 stable cuts {called} called, {ordered} turned, {unstable} unstable at their end"
    );
    let form = "act with the machine told, simulated, long";
    let bar = |what: &str| format!("{form}: {what}");
    holds(&bar("of 50 stable turned"), ordered as f64, 0.0..=0.0);
    holds(
        &bar("of 50 stable made unstable"),
        unstable as f64,
        0.0..=0.0,
    );
    all_judged(form);
}

#[test]
fn a_program_at_another_speed_is_worked_out_beside_the_listening() {
    let case = drawn(SEEDS + 9, Kind::Pocket, &RPM).expect("a pocket");
    let (hz, f_hz) = (case.cut.spindle_hz(), case.root(1.0).expect("it chatters"));
    let spindle = |hz| Arc::new(Mutex::new(Spindle::turning(hz)));
    let controller = SimulatedController(spindle(0.8 * hz));
    let config = ActConfig::limits(false, LIMITS.0, LIMITS.1);
    let about = case.about_with_machine();
    let mut actor = Actor::new(Box::new(controller.clone()), config, about, None).expect("sound");
    let mut t_s = 0.0;
    let mut chatters = || proposed(&mut actor, &mut t_s, f_hz);
    let without = |said: &[What]| said.contains(&What::WithoutMachine);
    // Its chart has just been begun, and takes seconds.
    assert!(without(&chatters()));
    // That of the other speed was there from the beginning, and says more.
    *controller.spindle() = Spindle::turning(hz);
    let said = chatters();
    assert!(
        !without(&said) && !said.contains(&What::NotBelieved),
        "{said:?}"
    );
}

/// What is said of a chatter at this frequency, Hz, until something is proposed, and a tenth of a second longer.
fn proposed(actor: &mut Actor, t_s: &mut f64, f_hz: f64) -> Vec<What> {
    let mut said = Vec::new();
    let mut proposed_s = None;
    actor.heard(*t_s, None);
    while proposed_s.is_none_or(|at_s| *t_s < at_s + 0.1) {
        *t_s += 0.02;
        actor.heard(*t_s, Some(f_hz));
        let step = actor.step(*t_s, |record| said.push(record.what));
        step.expect("no log");
        let is = |what: &What| matches!(what, What::Proposed { .. });
        if said.iter().any(is) {
            proposed_s = proposed_s.or(Some(*t_s));
        }
        assert!(*t_s < 60.0, "{said:?}");
    }
    said
}

/// A stable cut is called at the frequency of something else: the operator is shown speeds, and nothing is turned.
#[test]
fn what_the_told_machine_cannot_do_turns_nothing() {
    let called = |case: &Case, about: Chatter| {
        let spindle = Arc::new(Mutex::new(Spindle::turning(case.cut.spindle_hz())));
        let port = Box::new(SimulatedController(spindle));
        let config = ActConfig::limits(true, LIMITS.0, LIMITS.1);
        let mut actor = Actor::new(port, config, about, None).expect("sound");
        let mode = case.structure.modes()[0].f_hz;
        let said = proposed(&mut actor, &mut 0.0, 1.02 * mode);
        (said, actor.holds())
    };
    let stable = (SEEDS..).filter_map(|seed| drawn(seed, Kind::Stable, &RPM));
    let (case, said) = stable
        .map(|case| (called(&case, case.about()), case))
        .find_map(|((said, turned), case)| turned.then_some((case, said)))
        .expect("one that is turned where its machine is not told");
    assert!(!said.contains(&What::NotBelieved), "{said:?}");
    let (said, turned) = called(&case, case.about_with_machine());
    assert!(!turned && said.contains(&What::NotBelieved), "{said:?}");
}

#[test]
#[ignore = "ten minutes"]
fn a_machine_that_is_told_turns_more_of_them_long() {
    let actors: [fn(&Case) -> Chatter; 3] = [Case::about, Case::about_with_machine, |case| {
        case.about_with_machine_off(2.0)
    }];
    let pocket = told(Kind::Pocket, 50, actors);
    let without = told(Kind::None, 20, actors);
    let ends = |all: &[Judged]| all.iter().filter(|j| j.end_stable && j.orders > 0).count();
    let said = |all: &[Judged]| all.iter().filter(|j| j.none_said && j.orders == 0).count();
    let names = ["modes", "machine", "machine twice as wrong as believed"];
    for (k, name) in names.into_iter().enumerate() {
        println!(
            "told {name}: of 50 with a pocket end stable {}, \"no speed\" said {}; of 20 without said {}",
            ends(&pocket[k]),
            said(&pocket[k]),
            said(&without[k]),
        );
    }
    for j in pocket[1].iter().filter(|j| !j.end_stable) {
        println!("{j:?}");
    }
    assert!(ends(&pocket[1]) > ends(&pocket[0]));
    assert!(said(&without[1]) > said(&without[0]));
}

/// Of the cut at so many times its speed, the vibration and its part that is the chatter's, less than at its own
/// speed, dB.
fn less_db(case: &Case, ratios: &[f64]) -> Vec<(f64, f64)> {
    let before = vibration_m(&steady(case, 1.0, LENGTH_S));
    let db = |before: f64, now: f64| 20.0 * (before / now).log10();
    let less = |ratio: &f64| {
        let now = vibration_m(&steady(case, *ratio, 2.0));
        (db(before.0, now.0), db(before.1, now.1))
    };
    ratios.iter().map(less).collect()
}

#[test]
fn how_much_less_a_cut_can_vibrate() {
    let case = drawn(SEEDS + 9, Kind::Pocket, &RPM).expect("a pocket");
    let stable = (50..=150).map(|percent| 0.01 * f64::from(percent));
    let stable: Vec<f64> = stable.filter(|r| case.root(*r).is_none()).collect();
    let (all, chatter) = less_db(&case, &stable[..1])[0];
    assert!(all > 0.0 && chatter > all, "{all} {chatter}");
    // At its own speed it is what it was.
    let (all, chatter) = less_db(&case, &[1.0])[0];
    assert!(all.abs() < 1.0 && chatter.abs() < 1.0, "{all} {chatter}");
}

#[test]
#[ignore = "five minutes"]
fn how_much_less_a_cut_can_vibrate_long() {
    let limits = |r: &f64| (LIMITS.0..=LIMITS.1).contains(r);
    let best = |case: &Case| {
        let ratios = (0..=200).map(|percent| 0.01 * f64::from(percent));
        let stable: Vec<f64> = ratios
            .filter(|r| limits(r) && case.root(*r).is_none())
            .collect();
        let less = less_db(case, &stable);
        let most = |of: &dyn Fn(&(f64, f64)) -> f64| less.iter().map(of).fold(f64::MIN, f64::max);
        [
            most(&|less| less.0),
            most(&|less| less.1),
            most(&|less| less.0.min(less.1)),
        ]
    };
    let cases: Vec<Case> = (SEEDS..)
        .filter_map(|seed| drawn(seed, Kind::Pocket, &(3000.0..24_000.0)))
        .take(50)
        .collect();
    let best: Vec<[f64; 3]> = cases.par_iter().map(best).collect();
    let count = |k: usize, db: f64| best.iter().filter(|b| b[k] >= db).count();
    let mut table = String::from(
        "| less by | the whole vibration | the chatter's part | both at one speed |\n|---|---|---|---|\n",
    );
    for db in [5.0, 10.0, 15.0, 20.0] {
        let [all, chatter, both] = [0, 1, 2].map(|k| count(k, db));
        table += &format!("| {db} dB | {all} | {chatter} | {both} |\n");
    }
    print!("{table}");
    page::holds("docs/act.md", "least-vibration", &table);
    assert_eq!(best.len(), 50);
    assert!(count(0, 15.0) < 40 && count(1, 15.0) < 48 && count(0, 15.0) > 10);
}

/// What an order rests on: where a cut chatters a good part of the machines like the one that is told do, and where it is stable
/// hardly any, also where the file is twice as wrong as it is believed to be.
#[test]
fn machines_like_the_told_one_tell_chatter_from_a_stable_cut() {
    let expected = |kind: Kind, seeds: Range<u64>, errors: f64| -> Vec<f64> {
        let cases = seeds
            .into_par_iter()
            .filter_map(|seed| drawn(seed, kind, &RPM));
        let of = |case: Case| case.told(errors).expected(case.cut.spindle_hz());
        cases.map(of).collect()
    };
    for errors in [1.0, 2.0] {
        let stable = expected(Kind::Stable, 1..40, errors);
        let chatters = expected(Kind::Pocket, 1..20, errors);
        println!("{errors}: {stable:.2?} {chatters:.2?}");
        let few = stable.iter().filter(|part| **part < 0.2).count();
        assert!(stable.len() > 5 && 5 * few >= 4 * stable.len());
        assert!(chatters.len() > 1 && chatters.iter().all(|part| *part >= 0.2));
    }
}
