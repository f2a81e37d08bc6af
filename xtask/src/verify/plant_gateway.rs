//! The gateway of a plant: a real broker with users and TLS, a gateway that is killed, a second
//! implementation of Sparkplug B, and `rarma gateway`.

use super::python::Environment;
use super::stages::Bench;
use super::summary::Outcome;
use crate::toolchain::packages;
use crate::{Result, process};

/// The broker, as Debian packs it; the tests start one of their own. With it what makes certificates.
const PACKAGES: [&str; 2] = ["mosquitto", "openssl"];
/// The second implementation.
const SECOND: &str = "rarma-fleet/tests/plant/requirements.txt";

/// The check.
///
/// # Errors
/// A test fails. Where the broker or the second implementation cannot be had the check is skipped.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    if let Err(failure) = packages::install(&PACKAGES) {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    let Some(python) = process::find_program("python3") else {
        return Ok(Outcome::Skipped(
            "no python3 for a second implementation of Sparkplug B".to_owned(),
        ));
    };
    let folder = bench.workspace.target_dir().join("gateway-py");
    let second = match Environment::make(&python, folder, &bench.workspace.root().join(SECOND)) {
        Ok(second) => second,
        Err(failure) => return Ok(Outcome::Skipped(failure.to_string())),
    };
    let mut tests = bench.cargo(&["test", "--release"]);
    tests
        .args(process::HOST)
        .args(["--test", "plant", "--", "--nocapture"])
        .env("RARMA_REQUIRE_BROKER", "1")
        .env("RARMA_SPARKPLUG_PYTHON", second.program());
    if bench.long() {
        // A week of fifty machines, too.
        tests.arg("--include-ignored");
    }
    bench.pass_if(&mut tests)?;
    let mut command = bench.cargo(&["test", "--release", "--test", "gateway"]);
    bench.pass_if(command.args(process::HOST).env("RARMA_REQUIRE_BROKER", "1"))
}
