//! What long forms need beside this workspace: a test that left it out would pass having judged nothing.

use super::LongForm;
use crate::needs::{broker, browser, databases};
use crate::{Result, Workspace};
use std::path::PathBuf;
use std::process::Command;

/// The package whose tests ask for servers, and the one whose tests ask for a browser.
const PLANT: &str = "rarma-fleet";
const PAGE: &str = "rarma-web";

/// What is installed once, when the first form asks for it; none: it could not be had.
#[derive(Default)]
pub(super) struct Needs {
    databases: Option<Option<PathBuf>>,
    broker: Option<Option<PathBuf>>,
    page: Option<Option<PathBuf>>,
}

impl Needs {
    /// Tells a form of the servers, or the browser, that it must not leave out. Where one cannot be had that is said, and the form fails.
    pub(super) fn tell(&mut self, workspace: &Workspace, form: &LongForm, tests: &mut Command) {
        match form.place() {
            (PLANT, Some("plant")) => {
                let second = self
                    .broker
                    .get_or_insert_with(|| had(broker::broker(workspace)));
                broker::require(tests, second.as_deref());
            }
            (PAGE, Some("browser")) => {
                let page = self
                    .page
                    .get_or_insert_with(|| had(browser::page(workspace)));
                browser::require(tests, page.as_deref());
            }
            (PLANT, Some(_)) => {
                let engine = self
                    .databases
                    .get_or_insert_with(|| had(databases::databases(workspace)));
                databases::require(tests, engine.as_deref());
            }
            _ => {}
        }
    }
}

fn had(found: Result<PathBuf>) -> Option<PathBuf> {
    found.inspect_err(|failure| eprintln!("{failure}")).ok()
}
