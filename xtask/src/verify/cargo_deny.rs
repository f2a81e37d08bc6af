//! `cargo deny`: the check of `deny.toml` by the field's own tool.
//!
//! One that is installed is taken. Where nothing may be skipped a missing one is built into
//! the build directory, once; that takes minutes, so elsewhere it is only told how.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Failure, Result, Workspace, process};

/// What is built; later ones read the same `deny.toml`.
const VERSION: &str = "0.20.2";

/// The program.
#[derive(Debug, Clone)]
pub struct CargoDeny(PathBuf);

impl CargoDeny {
    /// The one on the search path or in the build directory; with `make`, built if need be.
    ///
    /// # Errors
    /// There is none, or it cannot be built.
    pub fn find_or_make(workspace: &Workspace, make: bool) -> Result<Self> {
        let folder = workspace.tools_target_dir().join("cargo-deny");
        let built = folder.join("bin/cargo-deny");
        if let Some(found) = process::find_program("cargo-deny") {
            return Ok(Self(found));
        }
        if !built.is_file() {
            if !make {
                return Err(Failure::new("cargo-deny is not installed")
                    .advise(format!("cargo install --locked cargo-deny@{VERSION}")));
            }
            eprintln!(
                "licences: building cargo-deny {VERSION} into {}, once",
                folder.display()
            );
            process::run(&mut install(workspace, &folder))?;
        }
        Ok(Self(built))
    }

    /// The check of licences, sources and doubled packages.
    pub fn check(&self, workspace: &Workspace) -> Command {
        let mut command = Command::new(&self.0);
        command.current_dir(workspace.root()).args([
            "--all-features",
            "check",
            "bans",
            "licenses",
            "sources",
        ]);
        command
    }
}

/// Unoptimised: built in half the time, and it checks in seconds all the same.
fn install(workspace: &Workspace, folder: &Path) -> Command {
    let mut cargo = process::host_cargo(workspace);
    cargo
        .args(["install", "--quiet", "--locked", "--debug"])
        .arg(format!("cargo-deny@{VERSION}"))
        .arg("--root")
        .arg(folder)
        .arg("--target-dir")
        .arg(folder.join("target"));
    cargo
}
