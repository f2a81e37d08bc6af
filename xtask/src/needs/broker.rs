//! A broker for a plant, and a second implementation of Sparkplug B.

use crate::python_environment::Environment;
use crate::toolchain::packages;
use crate::{Result, Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The broker, as Debian packs it; the tests start one of their own. With it what makes certificates.
const PACKAGES: [&str; 2] = ["mosquitto", "openssl"];
/// The second implementation.
const SECOND: &str = "rarma-fleet/tests/plant/requirements.txt";

/// Installs the broker; the Python that has the second implementation.
///
/// # Errors
/// One of them cannot be had.
pub(crate) fn broker(workspace: &Workspace) -> Result<PathBuf> {
    packages::install(&PACKAGES)?;
    Environment::kept(workspace, "gateway-py", SECOND)
}

/// Tells tests that they must not do without the broker, and which Python has the second implementation.
pub(crate) fn require(tests: &mut Command, second: Option<&Path>) {
    tests.env("RARMA_REQUIRE_BROKER", "1");
    if let Some(second) = second {
        tests.env("RARMA_SPARKPLUG_PYTHON", second);
    }
}
