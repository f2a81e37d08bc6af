//! The page of `rarma trends`.

use super::words::{day, limit, name_of, size, subject};
use rarma_fleet::store::{AdviceCount, AlarmCount, Machine};
use rarma_fleet::trends::Trends;
use rarma_fleet::trends::change::Change;
use rarma_fleet::trends::series::{Series as Tests, SeriesKind};
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// What the page is made of. Alarms and advice by month, machine, tool, speed.
pub(super) struct Asked<'a> {
    pub trends: &'a Trends,
    pub series: &'a [Tests],
    pub alarms: &'a [Vec<AlarmCount>],
    pub advice: &'a [Vec<AdviceCount>],
    pub machines: &'a [Machine],
}

/// Pictures of changes, most.
const PICTURES: usize = 12;
/// Tests whose mean is the level before a change.
const LEVEL: usize = 6;
/// Rows of a table, most.
const ROWS: usize = 60;

pub(super) fn page(asked: &Asked<'_>) -> String {
    let all: Vec<(&str, &Change)> = asked
        .trends
        .machines
        .iter()
        .flat_map(|m| m.changes.iter().map(|c| (m.machine.as_str(), c)))
        .collect();
    let mut newest = all.clone();
    newest.sort_by_key(|change| std::cmp::Reverse(change.1.found));
    let mut body = String::new();
    changes(&mut body, &newest, asked);
    for (machine, change) in newest.iter().take(PICTURES) {
        if let Some(chart) = picture(asked.series, machine, change) {
            body.push_str(&chart.figure());
        }
    }
    if newest.len() > PICTURES {
        body.push_str(&format!(
            "<p>The newest {PICTURES} have a picture, {} do not.</p>\n",
            newest.len() - PICTURES
        ));
    }
    limits(&mut body, asked);
    alarms(&mut body, asked);
    advice(&mut body, asked);
    silent(&mut body, asked);
    doubts(&mut body, asked);
    let changed = asked
        .trends
        .machines
        .iter()
        .filter(|m| !m.changes.is_empty())
        .count();
    let headline = match changed {
        0 => format!(
            "None of {} machines has changed beyond its uncertainty",
            asked.trends.machines.len()
        ),
        1 => format!(
            "One of {} machines has changed",
            asked.trends.machines.len()
        ),
        n => format!(
            "{n} of {} machines have changed",
            asked.trends.machines.len()
        ),
    };
    sheet(
        "Trends of the plant",
        &headline,
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

fn heading(body: &mut String, text: &str, words: &str) {
    body.push_str(&format!("<h2>{text}</h2>\n"));
    if !words.is_empty() {
        body.push_str(&format!("<p>{words}</p>\n"));
    }
}

fn rest(body: &mut String, count: usize) {
    if count > ROWS {
        body.push_str(&format!(
            "<p>{} more: <code>rarma trends --csv</code>.</p>\n",
            count - ROWS
        ));
    }
}

fn changes(body: &mut String, newest: &[(&str, &Change)], asked: &Asked<'_>) {
    let words = format!(
        "The newest first. Of a machine at most {} false changes in a year are allowed. Sizes and directions with twice their standard deviation, beginnings with the tests between which they lie (95 %).",
        asked.trends.false_per_year
    );
    heading(body, "What has changed", &words);
    if newest.is_empty() {
        body.push_str("<p>Nothing.</p>\n");
        return;
    }
    // Dates and sizes stay in one line: the table goes on to the right where the page is narrow.
    let whole = |text: String| text.replace('-', "\u{2011}").replace(' ', "\u{a0}");
    let rows: Vec<Vec<String>> = newest
        .iter()
        .take(ROWS)
        .map(|(machine, c)| {
            vec![
                (*machine).to_owned(),
                subject(c),
                size(c).replace(' ', "\u{a0}"),
                whole(day(c.since)),
                whole(format!("{} to {}", day(c.since_from), day(c.since_to))),
                whole(day(c.found)),
                c.tests.to_string(),
                limit(c).map_or("-".to_owned(), whole),
            ]
        })
        .collect();
    let head = [
        "machine",
        "what",
        "how much",
        "since",
        "between",
        "found",
        "tests",
        "limit depth",
    ];
    body.push_str(&table(&head, &rows));
    rest(body, newest.len());
}

/// The tests of a series: percent of the level before a change, or an error in its unit.
fn picture(all: &[Tests], machine: &str, change: &Change) -> Option<Chart> {
    let series = all.iter().find(|s| {
        s.machine == machine
            && s.kind == change.what
            && s.place == change.place
            && (s.at - change.at).abs() < 1e-9
    })?;
    let angle = change.direction_deg.map(f64::to_radians);
    // Of a plane the stiffness in the direction: 1 over its compliance.
    let value = |y: &[f64; 3]| match (series.kind, angle) {
        (SeriesKind::Plane, Some(a)) => {
            1.0 / (y[0].exp() * (1.0 + y[1] * (2.0 * a).cos() + y[2] * (2.0 * a).sin()))
        }
        (SeriesKind::Plane, None) => (-y[0]).exp(),
        _ if series.kind.unit().is_some() => y[0],
        _ => y[0].exp(),
    };
    // Its level just before: what is further back may have changed, too.
    let before: Vec<f64> = series
        .tests
        .iter()
        .filter(|t| t.time < change.since)
        .map(|t| value(&t.y))
        .collect();
    let before = &before[before.len().saturating_sub(LEVEL)..];
    let mean = before.iter().sum::<f64>() / before.len() as f64;
    let points: Vec<(f64, f64)> = (series.days().into_iter())
        .zip(&series.tests)
        .map(|(day, t)| match series.kind.unit() {
            Some(_) => (day, value(&t.y)),
            None => (day, 100.0 * value(&t.y) / mean),
        })
        .collect();
    let first = series.tests[0].time;
    let at = |time: rarma_fleet::record::Utc| time.since_s(first) / 86_400.0;
    let values = points.iter().map(|p| p.1);
    // Percent are never drawn larger than by a twentieth of the height each.
    let around = if series.kind.unit().is_none() {
        (98.0_f64, 102.0_f64)
    } else {
        (mean, mean)
    };
    let (low, high) = values.fold(around, |(l, h), v| (l.min(v), h.max(v)));
    let room = if series.kind.unit().is_none() {
        1.0
    } else {
        (0.1 * (high - low)).max(0.01)
    };
    let (low, high) = (low - room, high + room);
    let line =
        |name: &str, day: f64, mark| Series::new(name, vec![(day, low), (day, high)], mark, 1);
    Some(Chart {
        title: format!("{machine}: {}", subject(change)),
        x: Scale::linear(
            &format!("days since {}", day(first)),
            0.0,
            points.last()?.0.max(1.0),
        ),
        y: Scale::linear(series.kind.unit().unwrap_or("percent of before"), low, high),
        height: 180.0,
        series: vec![
            Series::new("tests", points.clone(), Mark::Dots, 0),
            line("since", at(change.since), Mark::Line),
            line("found", at(change.found), Mark::Dashes),
        ],
        caption: format!("{}, since {}.", size(change), day(change.since)),
    })
}

fn limits(body: &mut String, asked: &Asked<'_>) {
    let mut rows: Vec<(f64, Vec<String>)> = asked
        .trends
        .machines
        .iter()
        .filter_map(|m| {
            let f = m.limit?;
            let row = vec![
                m.machine.clone(),
                format!("{:.2}", f.now_mm),
                format!("{:.2}", f.then_mm),
                format!("{:.2} to {:.2}", f.from_mm, f.to_mm),
                format!("{:+.1} %", 100.0 * (f.then_mm / f.now_mm - 1.0)),
                format!("{:.0}°", f.direction_deg),
                day(f.time),
            ];
            Some((f.then_mm / f.now_mm, row))
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rows: Vec<Vec<String>> = rows.into_iter().map(|r| r.1).collect();
    heading(
        body,
        "The limit in a month",
        "Widest stable cut in the worst direction, the fastest falling first; 95 % interval.",
    );
    let head = [
        "machine",
        "now, mm",
        "then, mm",
        "from, to",
        "change",
        "direction",
        "when",
    ];
    body.push_str(&table(&head, &rows[..rows.len().min(ROWS)]));
    rest(body, rows.len());
}

fn alarms(body: &mut String, asked: &Asked<'_>) {
    let [by_month, by_machine, by_tool, by_speed] = asked.alarms else {
        return;
    };
    if by_month.is_empty() {
        return;
    }
    heading(body, "Alarms", "");
    let points: Vec<(f64, f64)> = by_month
        .iter()
        .enumerate()
        .map(|(n, a)| (n as f64, a.alarms as f64))
        .collect();
    let most = points.iter().map(|p| p.1).fold(1.0, f64::max);
    if by_month.len() > 1 {
        let chart = Chart {
            title: "Alarms by month".to_owned(),
            x: Scale::linear(
                &format!("months since {}", by_month[0].key),
                0.0,
                (points.len() - 1) as f64,
            ),
            y: Scale::linear("alarms", 0.0, 1.1 * most),
            height: 160.0,
            series: vec![
                Series::new("", points.clone(), Mark::Line, 0),
                Series::new("", points.clone(), Mark::Dots, 0),
            ],
            caption: "Of all machines. The first and the last month may not be whole.".to_owned(),
        };
        body.push_str(&chart.figure());
    }
    for (what, counts) in [
        ("machine", by_machine),
        ("tool", by_tool),
        ("speed from, 1/min", by_speed),
    ] {
        let mut sorted: Vec<&AlarmCount> = counts.iter().collect();
        sorted.sort_by(|a, b| b.alarms.cmp(&a.alarms).then(a.key.cmp(&b.key)));
        let rows: Vec<Vec<String>> = sorted
            .iter()
            .take(12)
            .map(|a| {
                vec![
                    told(&a.key),
                    a.alarms.to_string(),
                    format!("{:.1}", a.seconds / 60.0),
                ]
            })
            .collect();
        body.push_str(&table(&[what, "alarms", "minutes"], &rows));
    }
}

fn told(key: &str) -> String {
    if key.is_empty() {
        "not told".to_owned()
    } else {
        key.to_owned()
    }
}

fn advice(body: &mut String, asked: &Asked<'_>) {
    let [_, by_machine, by_tool, _] = asked.advice else {
        return;
    };
    if by_machine.iter().all(|a| a.advised == 0) {
        return;
    }
    heading(
        body,
        "Advice",
        "How often the chatter ended where a proposed speed was turned, and where it was not. The difference is not what advice does alone: nobody drew by lot who followed it.",
    );
    let share = |yes: i64, no: i64| {
        let n = yes + no;
        if n == 0 {
            return "-".to_owned();
        }
        let (low, high) = wilson(yes as f64, n as f64);
        format!(
            "{:.0} % ({low:.0} to {high:.0}) of {n}",
            100.0 * yes as f64 / n as f64
        )
    };
    let row = |name: String, of: &[&AdviceCount]| {
        let sum = |f: fn(&AdviceCount) -> i64| of.iter().map(|a| f(a)).sum::<i64>();
        vec![
            name,
            sum(|a| a.advised).to_string(),
            sum(|a| a.followed).to_string(),
            share(sum(|a| a.helped), sum(|a| a.not_helped)),
            share(sum(|a| a.ended_anyway), sum(|a| a.stayed)),
        ]
    };
    let mut rows = vec![row(
        "all".to_owned(),
        &by_machine.iter().collect::<Vec<_>>(),
    )];
    rows.extend(
        by_tool
            .iter()
            .take(ROWS)
            .map(|a| row(format!("tool {}", told(&a.key)), &[a])),
    );
    body.push_str(&table(
        &[
            "",
            "advised",
            "followed",
            "ended, followed",
            "ended, not followed",
        ],
        &rows,
    ));
}

/// 95 % interval of a share, percent (Wilson).
fn wilson(yes: f64, n: f64) -> (f64, f64) {
    const Z: f64 = 1.96;
    let p = yes / n;
    let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    (100.0 * (middle - half), 100.0 * (middle + half))
}

/// Machines that have said nothing for longer than the others.
fn silent(body: &mut String, asked: &Asked<'_>) {
    let Some(last) = asked.machines.iter().map(|m| m.last).max() else {
        return;
    };
    let silent: Vec<Vec<String>> = asked
        .machines
        .iter()
        .filter(|m| last.since_s(m.last) > 3.0 * 86_400.0)
        .map(|m| {
            vec![
                m.machine.clone(),
                day(m.last),
                format!("{:.0}", last.since_s(m.last) / 86_400.0),
            ]
        })
        .collect();
    if !silent.is_empty() {
        heading(
            body,
            "Silent",
            "Nothing for more than three days before the newest record.",
        );
        body.push_str(&table(&["machine", "last record", "days"], &silent));
    }
}

fn doubts(body: &mut String, asked: &Asked<'_>) {
    heading(
        body,
        "What is taken for no change",
        "Standard deviations of a reading, of the whole plant: from test to test, from operator to operator, from tool to tool, and of the season. A change must stand out of all of them. A change that comes with a new tool is called only where it is larger than tools make.",
    );
    let rows: Vec<Vec<String>> = (asked.trends.noise.iter())
        // Of what no machine has been tested for there is nothing but what is usual.
        .filter(|n| n.pairs > 0)
        .map(|n| {
            let what = match (n.kind, n.part) {
                (SeriesKind::Plane, 0) => "compliance of a plane, mean",
                (SeriesKind::Plane, _) => "compliance of a plane, by direction",
                (SeriesKind::Frequency, _) => "frequency of a mode",
                (SeriesKind::Damping, _) => "damping of a mode",
                (kind, _) => name_of(kind),
            };
            let sd = |x: f64| match n.kind.unit() {
                Some(unit) => format!("{x:.2} {unit}"),
                None => format!("{:.2} %", 100.0 * x),
            };
            vec![
                what.to_owned(),
                sd(n.test_sd),
                sd(n.operator_sd),
                sd(n.tool_sd),
                sd(n.season_sd),
                n.pairs.to_string(),
            ]
        })
        .collect();
    body.push_str(&table(
        &["", "test", "operator", "tool", "season", "pairs"],
        &rows,
    ));
}
