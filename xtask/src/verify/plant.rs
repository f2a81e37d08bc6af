//! Records of a plant: the same answers from SQLite, PostgreSQL and ClickHouse's engine, TLS to both, trends
//! against the truth of simulated plants, and `rarma store`, `trends`, `plant`.

use super::bench::Bench;
use super::summary::Outcome;
use crate::needs::databases::{databases, require};
use crate::{Result, process};
use std::process::Command;

/// Tests that need no database beside SQLite.
const ALONE: [&str; 2] = ["changes", "fleet"];

/// The check.
///
/// # Errors
/// A test fails. Where a database cannot be had, what needs SQLite only runs.
pub(super) fn records(bench: &mut Bench<'_>) -> Result<Outcome> {
    let mut tests = bench.cargo(&["test", "--release"]);
    tests.args(process::HOST);
    let named = |tests: &mut Command, names: &[&str]| {
        tests.args(names.iter().flat_map(|name| ["--test", name]));
    };
    named(&mut tests, &ALONE);
    match databases(bench.workspace) {
        Ok(engine) => {
            named(&mut tests, &["three_stores", "tls", "year", "grafana"]);
            require(&mut tests, Some(&engine));
            bench.pass_if(&mut tests)
        }
        Err(failure) => {
            bench.pass_if(&mut tests)?;
            Ok(Outcome::Partly(format!("SQLite alone: {failure}")))
        }
    }
}
