//! Promise: the page in a real browser calls chatter when the command does, reports every gap,
//! stays below 5 % of the audio thread's time, works without a network, on a narrow screen and with
//! the keyboard, and says what to do where it cannot listen.
//!
//! Needs the built page (`RARMA_WEB_PAGE`, from `cargo xtask web`) and Chromium; without them these
//! are skipped, loudly. `RARMA_REQUIRE_BROWSER=1` makes that a failure. Sound takes its time: each
//! pass through the demonstration is 6 s.

// What tests write nobody keeps.
#![allow(clippy::disallowed_methods)]

mod chromium;
mod files;
mod gaps;
mod offline;
mod page;
mod passes;
mod sound;

use page::Page;
use sound::{RPM, Sound, TEETH};
use std::path::PathBuf;
use tempfile::TempDir;

/// The demonstration in a file.
fn demonstration(folder: &TempDir) -> (Sound, PathBuf) {
    let sound = Sound::of_the_demonstration();
    let path = folder.path().join("demonstration.wav");
    sound.write(&path);
    (sound, path)
}

/// Writes speed and teeth of the demonstration into the page.
fn told(page: &mut Page) {
    page.write("speed", &RPM.to_string());
    page.write("teeth", &TEETH.to_string());
}
