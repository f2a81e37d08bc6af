//! The time a command may take, on the machine's own yardstick: the demonstration.

use crate::{Result, process};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A command may take this many times as long as the demonstration: it is not to be silent for
/// minutes, and a busy machine is no failure.
pub const TIMES_THE_DEMONSTRATION: f64 = 100.0;

/// How long the demonstration takes on this machine as it is now.
#[derive(Debug)]
pub struct Yardstick {
    rarma: PathBuf,
    folder: PathBuf,
    /// What it took.
    pub seconds: f64,
}

impl Yardstick {
    /// Three times, the one in the middle.
    ///
    /// # Errors
    /// The demonstration fails.
    pub fn new(rarma: &Path, scratch: &Path) -> Result<Self> {
        let mut out = Self {
            rarma: rarma.to_path_buf(),
            folder: scratch.join("demonstration"),
            seconds: 0.0,
        };
        let mut all = [out.measured()?, out.measured()?, out.measured()?];
        all.sort_by(f64::total_cmp);
        out.seconds = all[1];
        Ok(out)
    }

    fn measured(&self) -> Result<f64> {
        let begun = Instant::now();
        let mut demo = Command::new(&self.rarma);
        demo.args(["demo", "--out"]).arg(&self.folder);
        process::output(demo.stdin(Stdio::null()))?;
        Ok(begun.elapsed().as_secs_f64())
    }

    /// What a command may take.
    pub fn limit(&self) -> Duration {
        Duration::from_secs_f64(TIMES_THE_DEMONSTRATION * self.seconds)
    }

    /// Measured again, before a command is blamed: the machine may have got busy.
    ///
    /// # Errors
    /// The demonstration fails.
    pub fn look_again(&mut self) -> Result<Duration> {
        self.seconds = self.seconds.max(self.measured()?);
        Ok(self.limit())
    }
}
