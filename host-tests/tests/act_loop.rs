//! Promise: where it may, it turns chattering cuts to a speed at which they are stable, and leaves
//! a stable cut alone; with a simulated controller. With LinuxCNC itself, and how often:
//! act_linuxcnc.

use host_tests::act_judge::{Judged, Kind, SEEDS, drawn};
use host_tests::act_loop::simulated;
use rayon::prelude::*;

const BATCH: u64 = 8;
/// Speeds of the cuts: any, 1/min.
const RPM: core::ops::Range<f64> = 0.0..1e9;

/// So many cuts of a kind that were called (or are stable), each judged beside the same
/// without orders.
fn cuts(kind: Kind, count: usize) -> Vec<Judged> {
    let judged = |seed: u64| {
        let case = drawn(seed, kind, &RPM)?;
        let unturned = simulated(&case, false, case.about());
        Some(simulated(&case, true, case.about()).judge(&case, Some(&unturned)))
    };
    let mut out = Vec::new();
    let mut begin = SEEDS;
    while out.len() < count {
        let batch: Vec<Option<Judged>> =
            (begin..begin + BATCH).into_par_iter().map(judged).collect();
        let heard = |j: &Judged| kind == Kind::Stable || j.called_s.is_some();
        out.extend(batch.into_iter().flatten().filter(heard));
        begin += BATCH;
    }
    out.truncate(count);
    out
}

#[test]
fn chatter_is_turned_to_a_stable_speed() {
    let pocket = cuts(Kind::Pocket, 4);
    println!("{pocket:#?}");
    let count = |what: &dyn Fn(&Judged) -> bool| pocket.iter().filter(|j| what(j)).count();
    // Of the fourth it is said, wrongly, that there is no speed: docs/act.md.
    assert!(count(&|j| j.end_stable) >= 3, "{pocket:#?}");
    assert!(count(&|j| j.orders > 0) >= 3);
    // Where it ends stable the chatter itself is gone, whatever the teeth force.
    let gone = |j: &Judged| !j.end_stable || j.chatter_less_db.is_some_and(|db| db >= 15.0);
    assert!(pocket.iter().all(gone), "{pocket:#?}");
    assert!(pocket.iter().all(|j| j.false_calls == 0), "{pocket:#?}");
    // A stable cut is left alone.
    let stable = cuts(Kind::Stable, 2);
    assert!(stable.iter().all(|j| j.orders == 0), "{stable:#?}");
}
