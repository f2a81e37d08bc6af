//! The page in a browser (`rarma-web`): built as it would be released, opened in a real Chromium
//! with the demonstration as its microphone.

use super::bench::Bench;
use super::summary::Outcome;
use crate::needs::browser::{browser, require};
use crate::{Result, process, sound, web};

/// The check. Without a compiler for browsers, or without one of these, it is skipped.
///
/// # Errors
/// The page does not build, or a test fails.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    if let Err(failure) = web::toolchain(bench.workspace) {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    let page = web::build(bench.workspace)?;
    if let Err(failure) = browser() {
        return Ok(Outcome::Partly(format!("built, but {failure}")));
    }
    let encoder = sound::ensure_encoder();
    let mut tests = bench.cargo(&["test", "--release"]);
    tests
        .args(process::HOST)
        // One browser at a time: they listen in real time.
        .args([
            "--test",
            "browser",
            "--",
            "--test-threads",
            "1",
            "--nocapture",
        ]);
    require(&mut tests, Some(page.folder()));
    if encoder.is_ok() {
        tests.env("RARMA_REQUIRE_FFMPEG", "1");
    }
    bench.pass_if(&mut tests)?;
    Ok(match encoder {
        Ok(()) => Outcome::Passed(page.description()),
        Err(failure) => Outcome::Partly(failure.to_string()),
    })
}
