//! The page in a browser (`rarma-web`): built as it would be released, opened in a real Chromium
//! with the demonstration as its microphone.

use super::stages::Bench;
use super::summary::Outcome;
use crate::toolchain::packages;
use crate::{Result, process, sound, web};

/// What Debian calls the browser, and its program.
const BROWSER: &str = "chromium";
/// Passes through the demonstration in the long form.
const LONG_PASSES: &str = "10";

/// The check. Without a compiler for browsers, or without one of these, it is skipped.
///
/// # Errors
/// The page does not build, or a test fails.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    if let Err(failure) = web::toolchain(bench.workspace) {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    let page = web::build(bench.workspace)?;
    if process::find_program(BROWSER).is_none()
        && let Err(failure) = packages::install(&[BROWSER])
    {
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
        ])
        .env("RARMA_WEB_PAGE", page.folder())
        .env("RARMA_REQUIRE_BROWSER", "1");
    if encoder.is_ok() {
        tests.env("RARMA_REQUIRE_FFMPEG", "1");
    }
    if bench.long() {
        tests.env("RARMA_PASSES", LONG_PASSES);
    }
    bench.pass_if(&mut tests)?;
    Ok(match encoder {
        Ok(()) => Outcome::Passed(page.description()),
        Err(failure) => Outcome::Partly(failure.to_string()),
    })
}
