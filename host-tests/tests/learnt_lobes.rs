//! Promise: what was heard of a tool at other speeds and depths makes the next proposal better, and
//! how much is known.
//!
//! Always: 100 cuts, whatever is within their reach. 200 cuts, with the table of docs/bench.md:
//! `cargo test --release -p host-tests --test learnt_lobes -- --ignored --nocapture`.

use host_tests::advice::{Case, F_NOISE, REACH, Told, Within};
use host_tests::page;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rarma_core::advice::KnownCut;
use rayon::prelude::*;
use std::fmt::Write as _;

/// Seeds that no number of the advice was set on: the first cuts of them that chatter.
const SEEDS: u64 = 145_000;
/// Seeds that are drawn at once.
const BATCH: u64 = 16;
/// Cuts that are known at most, the one that is asked about included.
const MOST: usize = 6;
/// Parts of its depth that the others have.
const DEPTHS: [f64; 3] = [0.6, 0.8, 1.0];

/// Who is asked.
const ASKED: [&str; 6] = [
    "plain rule",
    "a speed that was stable as deep, else the plain rule",
    "stable or not, no frequencies, without a structure",
    "with frequencies, without a structure",
    "stable or not, no frequencies, with a structure",
    "with frequencies, with a structure",
];

/// A cut whose outcome is known: speed over that of the one asked about, and depth; where it chattered
/// the frequency as it is heard, Hz.
struct Known {
    ratio: f64,
    depth: f64,
    f_hz: Option<f64>,
}

struct Judged {
    within: Within,
    /// By how many cuts are known: by who is asked whether the proposed speed is stable; none where
    /// none is said.
    right: [[Option<bool>; ASKED.len()]; MOST],
}

fn judged(case: &Case) -> Judged {
    let seed = case.cut.seed;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let others: Vec<Known> = (1..MOST)
        .map(|_| {
            let ratio = REACH.0 * (REACH.1 / REACH.0).powf(rng.random());
            let depth = DEPTHS[rng.random_range(0..DEPTHS.len())];
            let noise: f64 = rng.sample(StandardNormal);
            let root = case.root_of(ratio, depth);
            // What cannot be told by its root chatters at a frequency that nobody heard.
            let f_hz = root.map(|f| f * (1.0 + F_NOISE * noise));
            Known { ratio, depth, f_hz }
        })
        .collect();
    let f_hz = case.cut.operational().0 * (1.0 + F_NOISE * rng.sample::<f64, _>(StandardNormal));
    Judged {
        within: case.within,
        right: std::array::from_fn(|more| ask(case, f_hz, &others[..more])),
    }
}

fn ask(case: &Case, f_hz: f64, others: &[Known]) -> [Option<bool>; ASKED.len()] {
    let told = Told {
        f_hz,
        f_sd_hz: 0.003 * f_hz,
    };
    let hz = case.cut.spindle_hz();
    let known = |with_frequencies: bool| -> Vec<KnownCut<f64>> {
        let one = |cut: &Known| {
            let speed = cut.ratio * hz;
            let known = match cut.f_hz {
                None => KnownCut::stable(speed),
                Some(f) => {
                    let heard = with_frequencies && f.is_finite();
                    KnownCut::chattered(speed, heard.then_some((f, 0.003 * f)))
                }
            };
            known.of_depth(cut.depth)
        };
        others.iter().map(one).collect()
    };
    let proposed = |with_frequencies, structure| {
        let known = known(with_frequencies);
        let proposal = case.proposed_knowing(told, 1.0, &known, structure);
        proposal.map(|p| p.spindle_hz / hz)
    };
    let plain = case.plain(f_hz);
    let stable = others.iter().filter(|c| c.f_hz.is_none() && c.depth >= 1.0);
    let near = |ratio: &f64| (ratio - 1.0).abs();
    let quiet = stable
        .map(|c| c.ratio)
        .min_by(|a, b| near(a).total_cmp(&near(b)));
    [
        plain,
        quiet.or(plain),
        proposed(false, false),
        proposed(true, false),
        proposed(false, true),
        proposed(true, true),
    ]
    .map(|ratio| ratio.map(|ratio| case.root(ratio).is_none()))
}

/// So many cuts that chatter, drawn so.
fn cuts(count: usize, draw: fn(u64) -> Option<Case>) -> Vec<Judged> {
    let mut out = Vec::new();
    let mut begin = SEEDS;
    while out.len() < count {
        let batch: Vec<Option<Judged>> = (begin..begin + BATCH)
            .into_par_iter()
            .map(|seed| draw(seed).as_ref().map(judged))
            .collect();
        out.extend(batch.into_iter().flatten());
        begin += BATCH;
    }
    out.truncate(count);
    out
}

/// Percent of the cuts with such a reach for which `is` holds, and how many there are.
fn percent(
    all: &[Judged],
    within: Within,
    (known, asked): (usize, usize),
    is: Option<bool>,
) -> (f64, usize) {
    let of: Vec<&Judged> = all.iter().filter(|one| one.within == within).collect();
    let count = of.iter().filter(|one| one.right[known][asked] == is);
    (
        100.0 * count.count() as f64 / of.len().max(1) as f64,
        of.len(),
    )
}

#[test]
fn frequencies_at_other_speeds_make_the_proposal_better() {
    let all = cuts(100, Case::deep);
    let count = |known: usize, asked: usize, is: Option<bool>| {
        all.iter()
            .filter(|one| one.right[known][asked] == is)
            .count()
    };
    let stable = |known, asked| count(known, asked, Some(true));
    let (plain, first, learnt) = (stable(0, 0), stable(0, 3), stable(MOST - 1, 3));
    assert!(
        learnt > first && learnt > plain + 15,
        "{plain} {first} {learnt}"
    );
    // And it is said less often of a speed that it is stable where it is not.
    let wrong = |known| count(known, 3, Some(false));
    assert!(
        wrong(MOST - 1) < wrong(0),
        "{} {}",
        wrong(MOST - 1),
        wrong(0)
    );
}

#[test]
#[ignore = "a quarter of an hour"]
fn frequencies_at_other_speeds_make_the_proposal_better_long() {
    let all = cuts(200, Case::draw);
    let mut table = "| asked, and known cuts |".to_owned();
    for known in 1..=MOST {
        let _ = write!(table, " {known} |");
    }
    table += &format!("\n|---|{}\n", "---:|".repeat(MOST));
    for (what, within, is) in [
        ("stable, %", Within::Pocket, Some(true)),
        ("none said where there is none, %", Within::None, None),
    ] {
        for (asked, name) in ASKED.iter().enumerate() {
            let _ = write!(table, "| {what}: {name} |");
            for known in 0..MOST {
                let (part, _) = percent(&all, within, (known, asked), is);
                let _ = write!(table, " {part:.0} |");
            }
            table.push('\n');
        }
    }
    let [with, without] =
        [Within::Pocket, Within::None].map(|w| percent(&all, w, (0, 0), Some(true)).1);
    let _ = writeln!(table, "\n{with} cuts with a pocket, {without} without.");
    print!("{table}");
    page::holds("docs/bench.md", "learnt-lobes", &table);
}
