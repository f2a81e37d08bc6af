//! Where things are: the sources, the build directories, this very program.

use std::env;
use std::path::{Path, PathBuf};

use crate::{Failure, Result};

/// Paths that every command needs, found once at the start.
#[derive(Debug, Clone)]
pub struct Workspace {
    root: PathBuf,
    target_dir: PathBuf,
    program: PathBuf,
}

impl Workspace {
    /// Finds the workspace this program was built in.
    ///
    /// The program's own path is taken now: once a later build replaces the file,
    /// the operating system no longer tells its name.
    ///
    /// # Errors
    /// When the operating system does not tell the program's or the current path.
    pub fn locate() -> Result<Self> {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
        let root = manifest.parent().unwrap_or(manifest).to_path_buf();
        let program = env::current_exe()
            .map_err(|why| Failure::new("cannot find the path of this program").because(why))?;
        let current = env::current_dir()
            .map_err(|why| Failure::new("cannot find the current directory").because(why))?;
        let target_dir = ["CARGO_TARGET_DIR", "CARGO_BUILD_TARGET_DIR"]
            .into_iter()
            .find_map(env::var_os)
            .map_or_else(|| root.join("target"), |chosen| current.join(chosen));
        Ok(Self {
            root,
            target_dir,
            program,
        })
    }

    /// The folder of the workspace's `Cargo.toml`.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where host builds go: `CARGO_TARGET_DIR`, or `target`.
    pub fn target_dir(&self) -> &Path {
        &self.target_dir
    }

    /// Where images go; apart from host builds, so that neither waits for the other.
    pub fn firmware_target_dir(&self) -> PathBuf {
        self.target_dir.join("fw")
    }

    /// Where helper programs with a workspace of their own are built (`tools/`).
    pub fn tools_target_dir(&self) -> PathBuf {
        self.target_dir.join("tools")
    }

    /// This program.
    pub fn program(&self) -> &Path {
        &self.program
    }
}
