//! `cargo deny`: the check of `deny.toml` by the field's own tool.
//!
//! One that is installed is taken; a missing one is built into the build directory, once: two
//! minutes of one core.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Failure, Result, Workspace, process};

/// What is built; later ones read the same `deny.toml`.
const VERSION: &str = "0.20.2";

/// The program.
#[derive(Debug, Clone)]
pub struct CargoDeny(PathBuf);

impl CargoDeny {
    /// The one on the search path or in the build directory, built if need be.
    ///
    /// # Errors
    /// There is none and it cannot be built.
    pub fn find_or_make(workspace: &Workspace) -> Result<Self> {
        let folder = workspace.tools_target_dir().join("cargo-deny");
        let built = folder.join("bin/cargo-deny");
        if let Some(found) = process::find_program("cargo-deny") {
            return Ok(Self(found));
        }
        if !built.is_file() {
            eprintln!(
                "licences: building cargo-deny {VERSION} into {}, once",
                folder.display()
            );
            process::run(&mut install(workspace, &folder)).map_err(|failure| {
                Failure::new("no cargo-deny")
                    .because(failure)
                    .advise(format!("cargo install --locked cargo-deny@{VERSION}"))
            })?;
            // A gigabyte that nothing needs any more; if it stays it does no harm.
            let _ = fs::remove_dir_all(folder.join("target"));
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
        .arg(folder.join("target"))
        // Nobody looks into it.
        .env("CARGO_PROFILE_DEV_DEBUG", "0");
    cargo
}
