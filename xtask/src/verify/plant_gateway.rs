//! The gateway of a plant: a real broker with users and TLS, a gateway that is killed, a second
//! implementation of Sparkplug B, and `rarma gateway`.

use super::bench::Bench;
use super::summary::Outcome;
use crate::needs::broker::{broker, require};
use crate::{Result, process};

/// The check.
///
/// # Errors
/// A test fails. Where the broker or the second implementation cannot be had the check is skipped.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    let second = match broker(bench.workspace) {
        Ok(second) => second,
        Err(failure) => return Ok(Outcome::Skipped(failure.to_string())),
    };
    let mut tests = bench.cargo(&["test", "--release"]);
    tests
        .args(process::HOST)
        .args(["--test", "plant", "--", "--nocapture"]);
    require(&mut tests, Some(&second));
    if bench.long() {
        // A week of fifty machines, too.
        tests.arg("--include-ignored");
    }
    bench.pass_if(&mut tests)?;
    let mut command = bench.cargo(&["test", "--release", "--test", "gateway"]);
    require(command.args(process::HOST), None);
    bench.pass_if(&mut command)
}
