//! Compressed files, made by the encoder that most people have: ffmpeg.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use xtask::process::find_program;

/// An encoder at hand.
#[derive(Debug, Clone)]
pub struct Encoder {
    /// What it calls itself: `ffmpeg 5.1.9`.
    pub version: String,
}

impl Encoder {
    /// The one of this machine; without it, a loud line that names the test.
    ///
    /// # Panics
    /// There is none and `RARMA_REQUIRE_FFMPEG` is `1`.
    #[must_use]
    pub fn or_skip(test: &str) -> Option<Self> {
        let required = std::env::var("RARMA_REQUIRE_FFMPEG").is_ok_and(|value| value == "1");
        let why = "there is no ffmpeg on this machine";
        let found = find_program("ffmpeg").is_some();
        assert!(
            found || !required,
            "{test}: {why}, and skipping is not allowed here"
        );
        if !found {
            let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
            return None;
        }
        let said = Command::new("ffmpeg").arg("-version").output();
        let said = said.expect("ffmpeg says its version").stdout;
        let said = String::from_utf8_lossy(&said);
        let version = said.split_whitespace().nth(2).unwrap_or("unknown");
        Some(Self {
            version: format!("ffmpeg {version}"),
        })
    }

    /// Makes `to` of `from`; its name tells the format, `options` the rest.
    ///
    /// # Panics
    /// The encoder refuses.
    pub fn make(&self, from: &Path, options: &str, to: &Path) -> PathBuf {
        let input = [OsStr::new("-i"), from.as_os_str()];
        self.run(&input, options, to)
    }

    /// Makes `to` out of what these words describe.
    ///
    /// # Panics
    /// The encoder refuses.
    pub fn run(&self, input: &[&OsStr], options: &str, to: &Path) -> PathBuf {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
        command.args(input);
        // Files of the same sound are the same, byte by byte.
        command.args(["-map_metadata", "-1", "-fflags", "+bitexact"]);
        command.args(options.split_whitespace()).arg(to);
        let done = command.output().expect("ffmpeg starts");
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{command:?}: {said}");
        to.to_path_buf()
    }
}
