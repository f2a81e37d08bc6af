//! Records of a plant: the same answers from SQLite, PostgreSQL and ClickHouse's engine, TLS to both, trends
//! against the truth of simulated plants, and `rarma store`, `trends`, `plant`.

use super::python::Environment;
use super::stages::Bench;
use super::summary::Outcome;
use crate::toolchain::packages;
use crate::{Result, process};
use std::path::Path;

/// PostgreSQL as Debian packs it; the tests start one of their own.
const POSTGRES: &str = "postgresql";
/// Where its programs are.
const PROGRAMS: &str = "/usr/lib/postgresql";
/// ClickHouse's engine for Python.
const ENGINE: &str = "rarma-fleet/tests/support/requirements.txt";

/// The check.
///
/// # Errors
/// A test fails. Where a database cannot be had the check is skipped.
pub(super) fn records(bench: &mut Bench<'_>) -> Result<Outcome> {
    if !Path::new(PROGRAMS).exists()
        && let Err(failure) = packages::install(&[POSTGRES])
    {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    let Some(python) = process::find_program("python3") else {
        return Ok(Outcome::Skipped(
            "no python3 for ClickHouse's engine".to_owned(),
        ));
    };
    let folder = bench.workspace.target_dir().join("plant-py");
    let engine = match Environment::make(&python, folder, &bench.workspace.root().join(ENGINE)) {
        Ok(engine) => engine,
        Err(failure) => return Ok(Outcome::Skipped(failure.to_string())),
    };
    let mut tests = bench.cargo(&["test", "--release"]);
    tests.args(process::HOST);
    for name in ["three_stores", "tls", "changes", "year", "grafana", "fleet"] {
        tests.args(["--test", name]);
    }
    tests
        .env("RARMA_ALL_STORES", "1")
        .env("RARMA_CHDB_PYTHON", engine.program());
    bench.pass_if(&mut tests)
}
