//! Promise: where it may, it turns chattering cuts to a speed at which they are stable; how often
//! is known. A stable cut is left alone.
//!
//! Always: some cuts with a simulated controller. 170 cuts, with a table:
//! `cargo test --release -p host-tests --test act_loop -- --ignored --nocapture`.

use hal_sim::population::Cut;
use host_tests::act_loop::{Judged, Played, SimulatedController, Spindle, play};
use host_tests::advice::{Case, Within, plays};
use host_tests::bars::{all_judged, holds};
use host_tests::statistics::quantile;
use rarma_cli::controller::{Actor, Chatter};
use rarma_core::act::ActConfig;
use rayon::prelude::*;
use std::sync::{Arc, Mutex};

/// Seeds that no number of the advice was set on.
const SEEDS: u64 = 300_000;
const BATCH: u64 = 8;
/// What may be ordered.
const LIMITS: (f64, f64) = (0.5, 1.5);
/// A stable cut is one with this much damping at most of its limit.
const SHALLOW: f64 = 0.8;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Pocket,
    None,
    Stable,
}

fn drawn(seed: u64, kind: Kind) -> Option<Case> {
    let cut = Cut::draw(seed).expect("a cut");
    if !plays(&cut) {
        return None;
    }
    if kind == Kind::Stable {
        let stable = cut.limit_part() < SHALLOW && cut.operational().1 > 0.0;
        return stable.then(|| Case::of(cut));
    }
    let case = Case::draw(seed)?;
    let wanted = match kind {
        Kind::Pocket => Within::Pocket,
        _ => Within::None,
    };
    (case.within == wanted).then_some(case)
}

/// One case with a simulated controller, which may be ordered or not.
fn played(case: &Case, act: bool, with_structure: bool) -> Played {
    let spindle = Spindle::turning(case.cut.spindle_hz());
    let mut controller = SimulatedController(Arc::new(Mutex::new(spindle)));
    let config = ActConfig::limits(act, LIMITS.0, LIMITS.1);
    let about = Chatter {
        teeth: case.cut.teeth() as u32,
        structure: with_structure.then_some(case.structure),
        power: None,
    };
    let port = Box::new(controller.clone());
    let mut actor = Actor::new(port, config, about, None).expect("in range");
    play(case, &mut actor, &mut controller)
}

/// The loop over one case, and over the same without orders.
fn judged(case: &Case, with_structure: bool) -> Judged {
    let turned = played(case, true, with_structure);
    let unturned = played(case, false, with_structure);
    turned.judge(case, Some(&unturned))
}

/// So many cuts of a kind that were called (or are stable), each judged.
fn cuts(kind: Kind, count: usize, with_structure: bool) -> Vec<Judged> {
    let mut out = Vec::new();
    let mut begin = SEEDS;
    while out.len() < count {
        let batch: Vec<Option<Judged>> = (begin..begin + BATCH)
            .into_par_iter()
            .map(|seed| Some(judged(&drawn(seed, kind)?, with_structure)))
            .collect();
        let heard = |j: &Judged| kind == Kind::Stable || j.called_s.is_some();
        out.extend(batch.into_iter().flatten().filter(heard));
        begin += BATCH;
    }
    out.truncate(count);
    out
}

fn middle(all: &[Judged], figure: impl Fn(&Judged) -> Option<f64>) -> f64 {
    let values: Vec<f64> = all.iter().filter_map(figure).collect();
    if values.is_empty() {
        return f64::NAN;
    }
    quantile(&values, 0.5)
}

fn count(all: &[Judged], what: impl Fn(&Judged) -> bool) -> usize {
    all.iter().filter(|j| what(j)).count()
}

#[test]
fn chatter_is_turned_to_a_stable_speed() {
    let pocket = cuts(Kind::Pocket, 4, true);
    println!("{pocket:#?}");
    assert!(count(&pocket, |j| j.end_stable) >= 2, "{pocket:#?}");
    assert!(count(&pocket, |j| j.orders > 0) >= 3);
    // A stable cut is left alone.
    let stable = cuts(Kind::Stable, 2, true);
    assert!(stable.iter().all(|j| j.orders == 0), "{stable:#?}");
}

#[test]
#[ignore = "half an hour"]
fn chatter_is_turned_to_a_stable_speed_long() {
    println!(
        "| cuts | number | end stable | 15 dB less of these | stable after the call, s, median | released after that, s, median | calls at a stable speed | orders | \"none\" said |\n|---|---|---|---|---|---|---|---|---|"
    );
    for (name, kind, number, with) in [
        ("a pocket in reach, structure told", Kind::Pocket, 50, true),
        ("a pocket in reach, not told", Kind::Pocket, 50, false),
        ("no pocket in reach, structure told", Kind::None, 20, true),
        ("stable", Kind::Stable, 50, true),
    ] {
        let all = cuts(kind, number, with);
        let stable = count(&all, |j| j.end_stable);
        let less = count(&all, |j| {
            j.end_stable && j.less_db.is_some_and(|db| db >= 15.0)
        });
        let orders: usize = all.iter().map(|j| j.orders).sum();
        let after_s = middle(&all, |j| j.stable_after_s);
        let released_s = middle(&all, |j| j.released_after_s);
        let calls: usize = all.iter().map(|j| j.false_calls).sum();
        let none = count(&all, |j| j.none_said && j.orders == 0);
        println!(
            "| {name} | {number} | {stable} | {less} | {after_s:.2} | {released_s:.2} | {calls} | {orders} | {none} |"
        );
        let bar = |what: &str| format!("act, long: {what}, {name}");
        match kind {
            Kind::Pocket => {
                holds(&bar("of 50 end stable"), stable as f64, 48.0..=50.0);
                holds(&bar("15 dB less"), less as f64, 48.0..=50.0);
                holds(&bar("stable after, s"), after_s, 0.0..=0.5);
                holds(&bar("released after, s"), released_s, 0.0..=0.6);
                holds(&bar("calls at a stable speed"), calls as f64, 0.0..=0.0);
            }
            Kind::None => {
                holds(&bar("of 20 none said"), none as f64, 20.0..=20.0);
            }
            Kind::Stable => {
                holds(&bar("orders"), orders as f64, 0.0..=0.0);
            }
        }
    }
    all_judged("act, long");
}
