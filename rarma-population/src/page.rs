//! Figures of the population for people: tables, and a page with curves.

use super::changed::{self, CHANGES};
use super::detectors::ALL;
use super::score::Sum;
use super::sensitivity;
use super::{Asked, Tally, Told};
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// The page of a run.
pub fn page(seeds: (u64, u64), asked: &Asked, tally: &Tally) -> String {
    let mut body = String::new();
    for told in &asked.tellings {
        body.push_str(&curve(*told, tally).figure());
    }
    let mut head = vec!["speed", "detector", "threshold"];
    head.extend(Sum::HEAD);
    let rows: Vec<Vec<String>> = tally
        .sums
        .iter()
        .map(|((told, detector, k), sum)| {
            let mut row = vec![
                told.name().to_owned(),
                ALL[*detector].name().to_owned(),
                ALL[*detector].thresholds()[*k].to_string(),
            ];
            row.extend(sum.cells());
            row
        })
        .collect();
    body.push_str("<h2>Every point</h2>\n");
    body.push_str(&table(&head, &rows));
    head[2] = "kind of cut";
    let rows: Vec<Vec<String>> = tally
        .kinds
        .iter()
        .map(|((told, detector, kind), sum)| {
            let mut row = vec![
                told.name().to_owned(),
                ALL[*detector].name().to_owned(),
                (*kind).to_owned(),
            ];
            row.extend(sum.cells());
            row
        })
        .collect();
    body.push_str("<h2>By what is in the cut, at the usual threshold</h2>\n");
    body.push_str(&table(&head, &rows));
    if !asked.variants.is_empty() {
        head.splice(..3, ["number", "usual", "here"]);
        let rows: Vec<Vec<String>> = asked
            .variants
            .iter()
            .zip(&tally.variants)
            .map(|(variant, sum)| sensitivity::cells(variant, &asked.numbers, sum))
            .collect();
        body.push_str("<h2>Half and double of each number of the verdict</h2>\n");
        body.push_str(&table(&head, &rows));
    }
    if asked.changed {
        let rows: Vec<Vec<String>> = CHANGES
            .iter()
            .zip(&tally.flips)
            .map(|(change, flips)| changed::cells(*change, flips).to_vec())
            .collect();
        body.push_str("<h2>The same cuts, changed in ways that should not matter</h2>\n");
        body.push_str(&table(&changed::HEAD, &rows));
    }
    let before = asked
        .before
        .map(|before| format!(", each after {}", before.name()));
    let headline = format!(
        "{} cuts (seeds {} to {}){}, {} undecidable",
        tally.cuts,
        seeds.0,
        seeds.1 - 1,
        before.unwrap_or_default(),
        tally.undecidable
    );
    sheet("Population", &headline, &body, env!("CARGO_PKG_VERSION"))
}

/// Detection over false alarms, a line for each detector.
fn curve(told: Told, tally: &Tally) -> Chart {
    /// Left edge of a logarithmic axis that cannot show none.
    const LEAST: f64 = 0.5;
    let series: Vec<Series> = (0..ALL.len())
        .flat_map(|place| {
            let thresholds = ALL[place].thresholds();
            let sums = tally.sums.iter();
            let mut those: Vec<(f64, &Sum)> = sums
                .filter(|((t, d, _), _)| *t == told && *d == place)
                .map(|((_, _, k), sum)| (thresholds[*k], sum))
                .collect();
            // The line goes from threshold to threshold.
            those.sort_by(|a, b| a.0.total_cmp(&b.0));
            let points: Vec<(f64, f64)> = those
                .iter()
                .filter_map(|(_, sum)| Some((sum.false_per_hour()?.max(LEAST), sum.detected()?)))
                .collect();
            // One entry in the legend is enough.
            let name = ALL[place].name().to_owned();
            [(Mark::Line, String::new()), (Mark::Dots, name)].map(|(mark, name)| Series {
                name,
                points: points.clone(),
                mark,
                colour: place,
            })
        })
        .collect();
    Chart {
        title: format!("Speed {}", told.name()),
        x: Scale::log("false alarms in an hour of stable cutting", LEAST, 5000.0),
        y: Scale::linear("part of the chatters that are called", 0.0, 1.0),
        height: 300.0,
        series,
        caption: "Each dot is one threshold, joined in their order. Up and to the left is better. No false alarm at all is drawn at the left edge. Cuts in which nobody could tell are left out.".to_owned(),
    }
}
