//! The page in a browser (`rarma-web`): built as it would be released, opened in a real Chromium
//! with the demonstration as its microphone.

use super::stages::Bench;
use super::summary::Outcome;
use crate::toolchain::packages;
use crate::{Result, Workspace, process, sound, web};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What Debian calls the browser, and its program.
const BROWSER: &str = "chromium";

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

/// Installs a browser where there is none.
fn browser() -> Result<()> {
    if process::find_program(BROWSER).is_some() {
        return Ok(());
    }
    packages::install(&[BROWSER])
}

/// The built page, and a browser that opens it.
///
/// # Errors
/// One of them cannot be had.
pub(crate) fn page(workspace: &Workspace) -> Result<PathBuf> {
    web::toolchain(workspace)?;
    let page = web::build(workspace)?;
    browser()?;
    Ok(page.folder().to_path_buf())
}

/// Tells tests that they must not skip, and where the page is.
pub(crate) fn require(tests: &mut Command, page: Option<&Path>) {
    tests.env("RARMA_REQUIRE_BROWSER", "1");
    if let Some(page) = page {
        tests.env("RARMA_WEB_PAGE", page);
    }
}
