//! The databases of a plant beside SQLite.

use crate::python_environment::Environment;
use crate::toolchain::packages;
use crate::{Result, Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// PostgreSQL as Debian packs it; the tests start one of their own.
const POSTGRES: &str = "postgresql";
/// Where its programs are.
const PROGRAMS: &str = "/usr/lib/postgresql";
/// ClickHouse's engine for Python.
const ENGINE: &str = "rarma-fleet/tests/support/requirements.txt";

/// Installs both databases; the Python that has ClickHouse's engine.
///
/// # Errors
/// One of them cannot be had.
pub(crate) fn databases(workspace: &Workspace) -> Result<PathBuf> {
    if !Path::new(PROGRAMS).exists() {
        packages::install(&[POSTGRES])?;
    }
    Environment::kept(workspace, "plant-py", ENGINE)
}

/// Tells tests that they must not leave out a database, and which Python has ClickHouse's engine.
pub(crate) fn require(tests: &mut Command, engine: Option<&Path>) {
    tests.env("RARMA_ALL_STORES", "1");
    if let Some(engine) = engine {
        tests.env("RARMA_CHDB_PYTHON", engine);
    }
}
