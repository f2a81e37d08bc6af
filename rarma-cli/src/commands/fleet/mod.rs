//! `rarma store`, `trends`, `plant`: many machines over months.

mod ask;
mod page;
mod plant;
mod receive;
mod store;
mod table;
mod trends;
mod words;

pub(super) use plant::main as plant;
pub(super) use store::main as store;
pub(super) use trends::main as trends;

use crate::args::StoreArgs;
use crate::failure::Failure;
use rarma_fleet::record::Name;
use rarma_fleet::store::{Store, StoreError, Taken};
use serde_json::{Value, json};
use std::path::Path;

/// What became of records, in a line.
fn tell(taken: &Taken, refused: u64, json: bool) {
    let Taken {
        new,
        same,
        thinned,
        different_count,
        ..
    } = taken;
    if json {
        say!(
            "{}",
            json!({"new": new, "same": same, "thinned": thinned, "different": different_count, "refused": refused})
        );
    } else {
        say!(
            "{new} new, {same} there before, {thinned} of days that were thinned, {different_count} of a name that another has, {refused} no records"
        );
    }
}

/// A store whose place can be told without its password.
struct Opened {
    store: Store,
    place: String,
}

impl Opened {
    /// Opens the store, which is made where it is not there.
    fn new(args: &StoreArgs) -> Result<Self, Failure> {
        let place = without_password(&args.store);
        let store = Store::open(&args.store).map_err(|why| failed(&place, "open", &why))?;
        Ok(Self { store, place })
    }

    /// Opens one that must be there: whoever asks a file that is not there has misspelled it.
    fn that_is_there(args: &StoreArgs) -> Result<Self, Failure> {
        let file = Path::new(&args.store);
        if !args.store.contains("://") && !file.exists() {
            return Err(Failure::Input(format!(
                "{}: open: no such store (check the spelling, or make it with `rarma store add`)",
                file.display()
            )));
        }
        Self::new(args)
    }

    /// What is said of a question that failed.
    fn asked<T>(&self, answer: Result<T, StoreError>) -> Result<T, Failure> {
        answer.map_err(|why| failed(&self.place, "ask", &why))
    }
}

fn failed(place: &str, step: &str, why: &StoreError) -> Failure {
    let text = format!("{place}: {step}: {why}");
    match why {
        StoreError::Foreign(_) | StoreError::Version { .. } | StoreError::Way(_) => {
            Failure::Input(text)
        }
        StoreError::Database(_) | StoreError::Answer(_) => Failure::System(text),
    }
}

/// An address without what stands between `:` and `@` of its user.
fn without_password(place: &str) -> String {
    let Some((scheme, rest)) = place.split_once("://") else {
        return place.to_owned();
    };
    match rest.rsplit_once('@') {
        Some((login, host)) => {
            let user = login.split(':').next().unwrap_or_default();
            format!("{scheme}://{user}@{host}")
        }
        None => place.to_owned(),
    }
}

/// A name from the command line.
fn name(option: &str, text: &str) -> Result<Name, Failure> {
    Name::new(text).map_err(|why| Failure::Usage(format!("{option}: {why}")))
}

/// Answers as a table for people: the keys of the first as its head.
fn lines(rows: &[Value]) -> Vec<String> {
    let Some(head) = rows.first().and_then(Value::as_object) else {
        return Vec::new();
    };
    let mut table: Vec<Vec<String>> = vec![head.keys().cloned().collect()];
    table.extend(
        rows.iter()
            .map(|row| head.keys().map(|key| cell(&row[key])).collect()),
    );
    let widths: Vec<usize> = (0..head.len())
        .map(|c| {
            table
                .iter()
                .map(|row| row[c].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let line = |row: &Vec<String>| {
        let cells = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    table.iter().map(line).collect()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_f64() => {
            let x = n.as_f64().unwrap_or(f64::NAN);
            let text = format!("{x:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        other => other.to_string(),
    }
}

/// Answers as JSON values.
fn values<T: serde::Serialize>(rows: &[T]) -> Vec<Value> {
    rows.iter()
        .filter_map(|row| serde_json::to_value(row).ok())
        .collect()
}
