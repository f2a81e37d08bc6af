//! `rarma population`: detectors on machines drawn at random, against the truth.

use super::show;
use crate::args::PopulationArgs;
use crate::failure::Failure;
use crate::output;
use rarma_population::changed::{self, CHANGES};
use rarma_population::detectors::ALL;
use rarma_population::page::page;
use rarma_population::records::{cut_record, summary};
use rarma_population::score::Sum;
use rarma_population::sensitivity::{self, variants};
use rarma_population::{Asked, Judged, Tally, judged, labels};
use rayon::prelude::*;
use serde_json::json;

/// Cuts in work at once: enough for all cores, few enough for the memory.
const BATCH: u64 = 32;

pub(super) fn main(args: &PopulationArgs) -> Result<u8, Failure> {
    let (from, to) = args.seeds;
    let numbers = args.numbers.numbers()?;
    let asked = Asked {
        tellings: args.told.iter().map(|told| (*told).into()).collect(),
        detectors: args.detectors.0.clone(),
        curve: args.curve,
        variants: if args.sensitivity {
            variants(&numbers)
        } else {
            Vec::new()
        },
        before: args.heard_before.map(Into::into),
        numbers,
        changed: args.changed,
    };
    if let Some(folder) = &args.out {
        output::folder(folder)?;
    }
    let bar = show::progress(to - from, "cutting");
    let mut tally = Tally::default();
    let mut list = Vec::new();
    for begin in (from..to).step_by(BATCH as usize) {
        let seeds = begin..to.min(begin + BATCH);
        let batch: Vec<Judged> = seeds
            .into_par_iter()
            .map(|seed| {
                let one = judged(seed, &asked)?;
                if let Some(folder) = &args.out {
                    labels::write_recording(folder, &one)?;
                }
                bar.inc(1);
                Ok(one)
            })
            .collect::<Result<_, Failure>>()?;
        for one in &batch {
            tally.add(one);
            if args.json {
                say!("{}", cut_record(one));
            }
            if args.out.is_some() {
                list.push(labels::label(one));
            }
        }
    }
    bar.finish_and_clear();
    if let Some(folder) = &args.out {
        labels::write_list(folder, &list)?;
    }
    if let Some(dir) = &args.report {
        let page = page(args.seeds, &asked, &tally);
        output::write_all(dir, [("index.html".to_owned(), page.into_bytes())])?;
    }
    if args.json {
        say!(
            "{}",
            json!({ "summary": summary(args.seeds, &asked, &tally) })
        );
    } else {
        words(&asked, &tally);
    }
    Ok(0)
}

fn words(asked: &Asked, tally: &Tally) {
    say!(
        "{} cuts; in {} chatter can be heard; {} are undecidable and in no figure below",
        tally.cuts,
        tally.chatters,
        tally.undecidable
    );
    if !tally.sums.is_empty() {
        detectors(tally);
    }
    if asked.before.is_some() {
        before(tally);
    }
    if !asked.variants.is_empty() {
        sensitivities(asked, tally);
    }
    if asked.changed {
        changes(tally);
    }
}

fn detectors(tally: &Tally) {
    say!(
        "| speed | detector | threshold | {} |",
        Sum::HEAD.join(" | ")
    );
    say!("|---|---|---|{}", "---:|".repeat(Sum::HEAD.len()));
    for ((told, detector, k), sum) in &tally.sums {
        say!(
            "| {} | {} | {} | {} |",
            told.name(),
            ALL[*detector].name(),
            ALL[*detector].thresholds()[*k],
            sum.cells().join(" | ")
        );
    }
}

fn before(tally: &Tally) {
    say!("");
    say!("| speed | detector | threshold | cuts | with an alarm before the cut |");
    say!("|---|---|---|---:|---:|");
    for ((told, detector, k), sum) in &tally.sums {
        say!(
            "| {} | {} | {} | {} | {} |",
            told.name(),
            ALL[*detector].name(),
            ALL[*detector].thresholds()[*k],
            sum.cuts,
            sum.alarmed_before
        );
    }
}

fn sensitivities(asked: &Asked, tally: &Tally) {
    say!("");
    say!("| number | usual | here | {} |", Sum::HEAD.join(" | "));
    say!("|---|---:|---:|{}", "---:|".repeat(Sum::HEAD.len()));
    for (variant, sum) in asked.variants.iter().zip(&tally.variants) {
        let row = sensitivity::cells(variant, &asked.numbers, sum);
        say!("| {} |", row.join(" | "));
    }
}

fn changes(tally: &Tally) {
    say!("");
    say!("| {} |", changed::HEAD.join(" | "));
    say!("|---|---:|---:|---:|");
    for (change, flips) in CHANGES.iter().zip(&tally.flips) {
        say!("| {} |", changed::cells(*change, flips).join(" | "));
    }
}
