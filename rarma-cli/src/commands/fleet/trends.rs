//! `rarma trends`.

use super::page::{self, Asked};
use super::words::{day, limit, size, subject};
use super::{Opened, table, values};
use crate::args::TrendsArgs;
use crate::failure::Failure;
use crate::report;
use rarma_fleet::store::{By, Span};
use rarma_fleet::trends::change::{Change, Shape};
use rarma_fleet::trends::{TrendsConfig, trends};
use serde_json::{Value, json};

const HEAD: [&str; 20] = [
    "machine",
    "what",
    "place",
    "at",
    "shape",
    "found",
    "tests",
    "since",
    "since_from",
    "since_to",
    "percent",
    "percent_sd",
    "amount",
    "amount_sd",
    "unit",
    "direction_deg",
    "direction_sd_deg",
    "limit_percent",
    "statistic",
    "threshold",
];

pub(in crate::commands) fn main(args: &TrendsArgs) -> Result<u8, Failure> {
    let mut opened = Opened::that_is_there(&args.store)?;
    let readings = opened.store.readings(None);
    let readings = opened.asked(readings)?;
    let (found, series) = trends(
        &readings,
        &TrendsConfig {
            false_per_year: args.false_per_year,
        },
    );
    let mut changes: Vec<Value> = Vec::new();
    for machine in &found.machines {
        for mut row in values(&machine.changes) {
            row["machine"] = machine.machine.as_str().into();
            changes.push(row);
        }
    }
    table::write(&args.table, &changes, &HEAD)?;
    if let Some(folder) = &args.report {
        let all = Span::default();
        let mut alarms = Vec::new();
        let mut advice = Vec::new();
        for by in [By::Month, By::Machine, By::Tool, By::Speed] {
            let answer = opened.store.alarms(by, all);
            alarms.push(opened.asked(answer)?);
            let answer = opened.store.advice(by, all);
            advice.push(opened.asked(answer)?);
        }
        let machines = opened.store.machines();
        let machines = opened.asked(machines)?;
        let asked = Asked {
            trends: &found,
            series: &series,
            alarms: &alarms,
            advice: &advice,
            machines: &machines,
        };
        let path = report::sheet_into(folder, page::page(&asked))?;
        if !args.json {
            say!("{}", path.display());
        }
    }
    if args.json {
        say!("{}", json!(found));
        return Ok(0);
    }
    for machine in &found.machines {
        for change in &machine.changes {
            say!("{}", sentence(&machine.machine, change));
        }
    }
    let count = changes.len();
    say!(
        "{count} change{} of {} machines; {} false a machine and year are allowed",
        if count == 1 { "" } else { "s" },
        found.machines.len(),
        found.false_per_year
    );
    Ok(0)
}

fn sentence(machine: &str, change: &Change) -> String {
    let how = match change.shape {
        Shape::Step => "at once",
        Shape::Drift => "more every day",
    };
    format!(
        "{machine}: {}: {}, {how}, since {} ({} to {}){}; found {} after {} tests",
        subject(change),
        size(change),
        day(change.since),
        day(change.since_from),
        day(change.since_to),
        limit(change).map_or(String::new(), |p| format!("; limit depth {p}")),
        day(change.found),
        change.tests,
    )
}
