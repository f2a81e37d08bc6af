//! How many records there are, and their seconds, by machine, kind, month and state: kept beside the records
//! in the same transaction, so that what is asked of all of them reads some thousand rows and not millions.
//!
//! A database without transactions keeps none: there the same rows are made of the records each time they
//! are asked ([`asked`]), which a database by columns does well.

use super::tables::table;
use super::value::{Rows, Value};
use std::collections::BTreeMap;

/// Rows that stand in the way of nothing: added to what is there.
pub(super) const ADD: &str = "ON CONFLICT (machine, kind, month, state) DO UPDATE SET \
    records = sums.records + excluded.records, seconds = sums.seconds + excluded.seconds, \
    first_us = CASE WHEN excluded.first_us < sums.first_us THEN excluded.first_us ELSE sums.first_us END, \
    last_us = CASE WHEN excluded.last_us > sums.last_us THEN excluded.last_us ELSE sums.last_us END";

/// The rows of `sums` that rows of `from` make, where `of` is true of them; `from` may be a part of the columns. No name
/// is that of a column it is made of: ClickHouse would take it for that column.
pub(super) fn select(from: &str, of: &str) -> String {
    format!(
        "SELECT machine, kind, month, coalesce(state, '') AS state_or_none, count(*) AS records, \
         coalesce(sum(seconds), 0.0) AS seconds_in_all, min(time_us) AS first_us, max(time_us) AS last_us \
         FROM {from} WHERE {of} GROUP BY machine, kind, month, coalesce(state, '')"
    )
}

/// `sums` where there is no such table (ClickHouse). Verdicts of closed days that a thinning that was killed left
/// behind do not count.
pub(super) fn asked() -> String {
    let open = "kind <> 'verdict' OR time_us >= \
                (SELECT max(value) FROM meta FINAL WHERE name = 'thinned_before_us')";
    format!(
        "(SELECT machine, kind, month, state_or_none AS state, records, seconds_in_all AS seconds, \
         first_us, last_us FROM ({})) AS sums",
        select("records FINAL", open)
    )
}

/// Statements that make all of `sums` anew, of those kinds of which `of` is true.
pub(super) fn anew(of: &str) -> [String; 2] {
    [
        format!("DELETE FROM sums WHERE {of}"),
        format!("INSERT INTO sums {}", select("records", of)),
    ]
}

/// The rows of `sums` that rows of `records` make.
pub(super) fn of_rows<'a>(records: impl Iterator<Item = &'a Vec<Value>>) -> Rows {
    let columns = table("records").columns;
    let place = |name: &str| columns.iter().position(|c| c.name == name).unwrap_or(0);
    let (machine, kind, month) = (place("machine"), place("kind"), place("month"));
    let (state, seconds, time) = (place("state"), place("seconds"), place("time_us"));
    let text = |value: &'a Value| match value {
        Value::Text(text) => text.as_str(),
        _ => "",
    };
    let whole = |value: &Value| value.int().unwrap_or(0);
    // Records, seconds, first, last; by machine, kind, month, state.
    type Key<'k> = (&'k str, &'k str, i64, &'k str);
    let mut sums: BTreeMap<Key<'_>, (i64, f64, i64, i64)> = BTreeMap::new();
    for row in records {
        let key = (
            text(&row[machine]),
            text(&row[kind]),
            whole(&row[month]),
            text(&row[state]),
        );
        let at = whole(&row[time]);
        let sum = sums.entry(key).or_insert((0, 0.0, at, at));
        sum.0 += 1;
        sum.1 += row[seconds].real().unwrap_or(0.0);
        sum.2 = sum.2.min(at);
        sum.3 = sum.3.max(at);
    }
    sums.into_iter()
        .map(|((machine, kind, month, state), (n, s, first, last))| {
            vec![
                machine.into(),
                kind.into(),
                month.into(),
                state.into(),
                n.into(),
                s.into(),
                first.into(),
                last.into(),
            ]
        })
        .collect()
}
