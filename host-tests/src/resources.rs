//! What a test needs and a machine may lack: the real recordings, the published
//! series, and the image for the emulated chip.
//!
//! A test without them says so on standard error and ends; where
//! `RARMA_REQUIRE_SHARED=1` or `RARMA_REQUIRE_TARGET=1` is set (as `.ci/run` does)
//! it fails instead.

use rarma_recordings::input::{self, ReadOptions, Recording};
use serde_json::Value;
use std::env;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder of what the project shares, if it is there: beside the checkout, or where
/// `RARMA_SHARED` says.
fn folder(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = env::var_os("RARMA_SHARED").map_or_else(beside, PathBuf::from);
    let path = shared.join("data").join(name);
    path.is_dir().then_some(path)
}

/// Folder of the recordings that the project shares, if it is there.
#[must_use]
pub fn shared() -> Option<PathBuf> {
    folder("recordings")
}

/// Folder of the published series that the project shares, if it is there.
#[must_use]
pub fn series() -> Option<PathBuf> {
    folder("arma_reference")
}

/// [`series`]; without it, a loud line that names the test.
///
/// # Panics
/// The folder is missing and `RARMA_REQUIRE_SHARED` is `1`.
#[must_use]
pub fn series_or_skip(test: &str) -> Option<PathBuf> {
    let why = "the folder ../shared/data/arma_reference is missing";
    found(series(), test, why, required("RARMA_REQUIRE_SHARED"))
}

/// The image for the emulated chip that `RARMA_TARGET_ELF` names.
#[must_use]
pub fn target_elf() -> Option<PathBuf> {
    let path = PathBuf::from(env::var_os("RARMA_TARGET_ELF")?);
    path.is_file().then_some(path)
}

/// [`shared`]; without it, a loud line that names the test.
///
/// # Panics
/// The folder is missing and `RARMA_REQUIRE_SHARED` is `1`.
#[must_use]
pub fn shared_or_skip(test: &str) -> Option<PathBuf> {
    let why = "the folder ../shared/data/recordings is missing";
    found(shared(), test, why, required("RARMA_REQUIRE_SHARED"))
}

/// [`target_elf`]; without it, a loud line that names the test.
///
/// # Panics
/// There is no image and `RARMA_REQUIRE_TARGET` is `1`.
#[must_use]
pub fn target_elf_or_skip(test: &str) -> Option<PathBuf> {
    let why = "RARMA_TARGET_ELF names no image";
    found(target_elf(), test, why, required("RARMA_REQUIRE_TARGET"))
}

/// The image of the whole box on the emulated chip, which lies beside [`target_elf`]'s.
///
/// # Panics
/// There is none and `RARMA_REQUIRE_TARGET` is `1`.
#[must_use]
pub fn target_box_or_skip(test: &str) -> Option<PathBuf> {
    let path = target_elf().map(|elf| elf.with_file_name("mps2-an386-box"));
    let path = path.filter(|path| path.is_file());
    let why = "no mps2-an386-box beside the image that RARMA_TARGET_ELF names";
    found(path, test, why, required("RARMA_REQUIRE_TARGET"))
}

/// The image for the real board that `RARMA_BOARD_ELF` names, the program of its chip's
/// model, and the folder of what that imports; without them, a loud line that names the test.
///
/// # Panics
/// They are missing and `RARMA_REQUIRE_BOARD` is `1`.
#[must_use]
pub fn board_image_or_skip(test: &str) -> Option<(PathBuf, PathBuf, PathBuf)> {
    let path = |variable| env::var_os(variable).map(PathBuf::from);
    let image = path("RARMA_BOARD_ELF").filter(|image| image.is_file());
    let why = "RARMA_BOARD_ELF names no image, or RARMA_G474_MODEL no model of its chip";
    let found_image = image
        .zip(path("RARMA_G474_MODEL"))
        .zip(path("RARMA_G474_PACKAGES"));
    let required = required("RARMA_REQUIRE_BOARD");
    assert!(
        found_image.is_some() || !required,
        "{test}: {why}, and skipping is not allowed here"
    );
    if found_image.is_none() {
        let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
    }
    found_image.map(|((image, model), packages)| (image, model, packages))
}

/// The folder of the Python packages that tests use; without it, a loud line that names the
/// test.
///
/// # Panics
/// It is missing and `RARMA_REQUIRE_BOARD` is `1`.
#[must_use]
pub fn python_packages_or_skip(test: &str) -> Option<PathBuf> {
    let path = env::var_os("RARMA_G474_PACKAGES").map(PathBuf::from);
    let why = "RARMA_G474_PACKAGES names no folder with pyuff";
    found(path, test, why, required("RARMA_REQUIRE_BOARD"))
}

/// A recording of the shared folder with what is known about it.
#[derive(Debug, Clone)]
pub struct Known {
    /// The file.
    pub path: PathBuf,
    /// Its samples, read as `rarma` reads them.
    pub recording: Recording,
    /// Its `meta.json`.
    pub meta: Value,
}

impl Known {
    /// Reads `name` (without extension) below the shared folder, and its meta.json.
    ///
    /// # Panics
    /// Either file cannot be read.
    #[must_use]
    pub fn read(shared: &Path, name: &str) -> Self {
        let path = shared.join(format!("{name}.wav"));
        let recording =
            input::read(&path, &ReadOptions::default()).unwrap_or_else(|why| panic!("{why}"));
        let text = std::fs::read(shared.join(format!("{name}.meta.json")))
            .unwrap_or_else(|why| panic!("{name}.meta.json: {why}"));
        let meta =
            serde_json::from_slice(&text).unwrap_or_else(|why| panic!("{name}.meta.json: {why}"));
        Self {
            path,
            recording,
            meta,
        }
    }

    /// A number of the meta.json.
    ///
    /// # Panics
    /// There is no such number.
    #[must_use]
    pub fn number(&self, key: &str) -> f64 {
        self.meta[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{}: meta.json has no {key}", self.path.display()))
    }

    /// `--rpm` and `--teeth` as the meta.json states them; none if it does not.
    #[must_use]
    pub fn stated(&self) -> Option<String> {
        let rpm = match &self.meta["spindle_rpm"] {
            Value::Array(speeds) => speeds.first()?.as_f64()?,
            one => one.as_f64()?,
        };
        let teeth = self.meta["teeth"].as_u64();
        let teeth = teeth.map_or_else(String::new, |z| format!(" --teeth {z}"));
        Some(format!("--rpm {rpm}{teeth}"))
    }

    /// A segment that the meta.json names: from, to, s.
    ///
    /// # Panics
    /// There is no such segment.
    #[must_use]
    pub fn segment(&self, name: &str) -> (f64, f64) {
        let edges = &self.meta["segments_s"][name];
        match (edges[0].as_f64(), edges[1].as_f64()) {
            (Some(from), Some(to)) => (from, to),
            _ => panic!("{}: meta.json has no segment {name}", self.path.display()),
        }
    }
}

fn required(variable: &str) -> bool {
    env::var(variable).is_ok_and(|value| value == "1")
}

fn found(path: Option<PathBuf>, test: &str, why: &str, required: bool) -> Option<PathBuf> {
    if path.is_none() {
        assert!(!required, "{test}: {why}, and skipping is not allowed here");
        // Straight to the stream: the test harness hides what the macros print.
        let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_used_and_what_is_not_is_skipped() {
        let here = PathBuf::from(".");
        assert_eq!(found(Some(here.clone()), "t", "why", true), Some(here));
        assert_eq!(
            found(None, "self-test of skipping", "not needed", false),
            None
        );
    }

    #[test]
    #[should_panic(expected = "skipping is not allowed")]
    fn what_is_required_must_be_there() {
        let _ = found(None, "t", "why", true);
    }
}
