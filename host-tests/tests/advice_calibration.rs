//! Promise: the chance that is said of a proposed speed is about the part of them that is stable, and how far chatter lies
//! off its mode is known by the population, not only by theory.
//!
//! Always: forty cuts. 300, with the tables of docs/bench.md:
//! `cargo test --release -p host-tests --test advice_calibration -- --ignored --nocapture`.

use host_tests::advice::{Case, F_NOISE, Told};
use host_tests::page;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rarma_core::advice::Proposal;
use rayon::prelude::*;
use std::fmt::Write as _;

/// Seeds that no number was set on.
const SEEDS: u64 = 350_000;
/// Who is asked.
const ASKED: [&str; 3] = ["without a structure", "with a structure", "machine told"];
/// The machine is told of one cut in so many: it takes seconds.
const MACHINE_EVERY: u64 = 3;
/// Edges of the chances that are counted together.
const EDGES: [f64; 5] = [0.0, 0.5, 0.7, 0.85, 1.001];

struct Judged {
    /// Of the first proposal: its chance, and whether it is stable.
    first: [Option<(f64, bool)>; ASKED.len()],
    /// f/f_m − 1, and the same over the damping of the mode that lies nearest.
    off: (f64, f64),
}

fn judged(seed: u64, machine: bool) -> Option<Judged> {
    let case = Case::deep(seed)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise: f64 = rng.sample(StandardNormal);
    let f_hz = case.cut.operational().0;
    let told = Told {
        f_hz: f_hz * (1.0 + F_NOISE * noise),
        f_sd_hz: F_NOISE * f_hz,
    };
    let judge = |proposal: Option<Proposal<f64>>| {
        proposal.map(|p| {
            let ratio = p.spindle_hz / case.cut.spindle_hz();
            (p.chance, case.root(ratio).is_none())
        })
    };
    let by_machine = (machine && seed.is_multiple_of(MACHINE_EVERY))
        .then(|| case.proposed_by(&case.told(1.0), told, 1.0, &[]));
    let off = |f_m: f64| f_hz / f_m - 1.0;
    let modes = case.structure.modes().iter();
    let nearest = modes.min_by(|a, b| off(a.f_hz).abs().total_cmp(&off(b.f_hz).abs()))?;
    Some(Judged {
        first: [
            judge(case.proposed(told, 1.0, &[], false)),
            judge(case.proposed(told, 1.0, &[], true)),
            judge(by_machine.flatten()),
        ],
        off: (off(nearest.f_hz), off(nearest.f_hz) / nearest.zeta),
    })
}

fn cuts(count: usize, machine: bool) -> Vec<Judged> {
    let mut out = Vec::new();
    let mut begin = SEEDS;
    while out.len() < count {
        let batch: Vec<Option<Judged>> = (begin..begin + 64)
            .into_par_iter()
            .map(|seed| judged(seed, machine))
            .collect();
        out.extend(batch.into_iter().flatten());
        begin += 64;
    }
    out.truncate(count);
    out
}

/// Proposals with such a chance: how many, their mean chance, and the part that is stable.
fn bin(all: &[Judged], asked: usize, (low, high): (f64, f64)) -> (usize, f64, f64) {
    let first = all.iter().filter_map(|one| one.first[asked]);
    let within: Vec<(f64, bool)> = first.filter(|(c, _)| (low..high).contains(c)).collect();
    let count = within.len();
    let mean =
        |x: &dyn Fn(&(f64, bool)) -> f64| within.iter().map(x).sum::<f64>() / count.max(1) as f64;
    (count, mean(&|p| p.0), mean(&|p| f64::from(u8::from(p.1))))
}

/// The 10th, 50th and 90th percent of the sorted values.
fn quantiles(mut x: Vec<f64>) -> [f64; 3] {
    x.sort_by(f64::total_cmp);
    [0.1, 0.5, 0.9].map(|p| x[(p * (x.len() - 1) as f64).round() as usize])
}

#[test]
fn a_chance_is_about_what_comes_true() {
    let all = cuts(40, false);
    for asked in 0..2 {
        let (count, said, stable) = bin(&all, asked, (0.0, 1.001));
        assert!(count >= 15, "{count}");
        // Of so few: two deviations of a part of a half.
        let allowed = 1.0 / (count as f64).sqrt();
        assert!(
            (said - stable).abs() < allowed,
            "{asked}: {said} {stable} of {count}"
        );
    }
}

#[test]
#[ignore = "twenty minutes of a processor"]
fn a_chance_is_about_what_comes_true_long() {
    let all = cuts(300, true);
    let mut table = String::from(
        "| asked | chance said | proposals | mean of it, % | stable, % |\n|---|---|---|---|---|\n",
    );
    for (asked, name) in ASKED.iter().enumerate() {
        for edges in EDGES.windows(2) {
            let (count, said, stable) = bin(&all, asked, (edges[0], edges[1]));
            if count == 0 {
                continue;
            }
            let _ = writeln!(
                table,
                "| {name} | {:.0} to {:.0} % | {count} | {:.0} | {:.0} |",
                100.0 * edges[0],
                100.0 * edges[1].min(1.0),
                100.0 * said,
                100.0 * stable
            );
        }
    }
    let off = |above: bool| -> Vec<&(f64, f64)> {
        let all = all.iter().map(|one| &one.off);
        all.filter(|off| (off.0 > 0.0) == above).collect()
    };
    table += "\n| chatter lies | cuts | off its mode, over ζ, 10 / 50 / 90 % | off its mode, %: so far its pockets lie beside f/(k·N) |\n|---|---|---|---|\n";
    for (above, name) in [(true, "above the nearest mode"), (false, "below it")] {
        let those = off(above);
        let [a, b, c] = quantiles(those.iter().map(|off| off.1).collect());
        let [d, e, f] = quantiles(those.iter().map(|off| 100.0 * off.0).collect());
        let _ = writeln!(
            table,
            "| {name} | {} | {a:.1} / {b:.1} / {c:.1} | {d:.1} / {e:.1} / {f:.1} |",
            those.len()
        );
    }
    print!("{table}");
    page::holds("docs/bench.md", "advice-calibration", &table);
}
