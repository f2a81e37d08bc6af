//! A browser, and the page that it opens.

use crate::toolchain::packages;
use crate::{Result, Workspace, process, web};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What Debian calls the browser, and its program.
const BROWSER: &str = "chromium";

/// Installs a browser where there is none.
///
/// # Errors
/// It cannot be had.
pub(crate) fn browser() -> Result<()> {
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
