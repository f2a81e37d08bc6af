//! `rarma trends`.

use super::page::{self, Asked};
use super::{Opened, table, values};
use crate::args::TrendsArgs;
use crate::failure::Failure;
use crate::report;
use rarma_fleet::store::{By, Span};
use rarma_fleet::trends::change::{Change, Shape};
use rarma_fleet::trends::series::SeriesKind;
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

/// What has changed, in a few words.
pub(super) fn subject(change: &Change) -> String {
    match (change.what, change.direction_deg) {
        (SeriesKind::Plane, Some(angle)) => {
            let sd = change.direction_sd_deg.unwrap_or(0.0);
            format!(
                "stiffness of {} at {angle:.0}° ± {:.0}°",
                change.place,
                2.0 * sd
            )
        }
        (SeriesKind::Plane, None) => format!("stiffness of {}, all directions alike", change.place),
        (SeriesKind::Frequency, _) => {
            format!("frequency of {} at {:.0} Hz", place(change), change.at)
        }
        (SeriesKind::Damping, _) => format!("damping of {} at {:.0} Hz", place(change), change.at),
        (SeriesKind::Limit, _) => format!("limit of width at {:.0}°", change.at),
        (SeriesKind::Hysteresis, _) => format!("loops of {}", change.place),
        (kind, _) => error(kind, &change.place),
    }
}

/// `XY backlash_um.0` is the backlash of X.
fn error(kind: SeriesKind, place: &str) -> String {
    let (plane, name) = place.split_once(' ').unwrap_or((place, ""));
    let axis = (name.rsplit_once('.'))
        .and_then(|(_, n)| plane.chars().nth(n.parse().ok()?))
        .map_or_else(|| plane.to_owned(), String::from);
    format!("{} of {axis}", name_of(kind))
}

/// What a series is of, in words.
pub(super) fn name_of(kind: SeriesKind) -> &'static str {
    match kind {
        SeriesKind::Plane => "stiffness",
        SeriesKind::Frequency => "frequency",
        SeriesKind::Damping => "damping",
        SeriesKind::Limit => "limit of width",
        SeriesKind::Hysteresis => "loops",
        SeriesKind::ScaleMismatch => "scale mismatch",
        SeriesKind::Squareness => "squareness",
        SeriesKind::Straightness => "straightness",
        SeriesKind::Backlash => "backlash",
        SeriesKind::LateralPlay => "lateral play",
        SeriesKind::ServoMismatch => "servo mismatch",
    }
}

/// `X 0` is axis X at rest.
fn place(change: &Change) -> String {
    match change.place.split_once(' ') {
        Some((axis, "0")) => axis.to_owned(),
        Some((axis, rpm)) => format!("{axis} ({rpm} 1/min)"),
        None => change.place.clone(),
    }
}

pub(super) fn day(time: rarma_fleet::record::Utc) -> String {
    time.to_string().chars().take(10).collect()
}

pub(super) fn size(change: &Change) -> String {
    let (value, sd, unit) = match change.unit {
        Some(unit) => (change.amount, change.amount_sd, unit),
        None => (change.percent, change.percent_sd, "%"),
    };
    let (value, sd) = (value.unwrap_or(0.0), 2.0 * sd.unwrap_or(0.0));
    // Two digits of what is left open.
    let digits = if sd < 0.1 { 2 } else { 1 };
    format!("{value:+.digits$} ± {sd:.digits$} {unit}")
}

/// What a change does to the limit of depth, where it says something of it.
pub(super) fn limit(change: &Change) -> Option<String> {
    change.limit_percent.map(|p| format!("{p:+.1} %"))
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
