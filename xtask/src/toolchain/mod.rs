//! A compiler for the Cortex-M4F, from wherever this machine can have one.
//!
//! In this order: the rustup target that is installed; `rustup target add`, unless
//! the user forbade downloads with `RUSTUP_AUTO_INSTALL=0`; Debian's packages, whose
//! compiler builds `core` and `alloc` from Debian's sources into a private sysroot.
//! The user's rustup toolchains are never changed but by that one `target add`.

pub mod debian;
pub mod packages;

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Failure, Result, TARGET, Workspace, process};

/// A cargo and a rustc that build for [`TARGET`].
#[derive(Debug, Clone)]
pub struct ArmToolchain {
    cargo: PathBuf,
    rustc: PathBuf,
    description: String,
}

impl ArmToolchain {
    /// The first toolchain of the list above that works here, made if need be.
    ///
    /// # Errors
    /// When none can be had; the failure names the commands that would bring one.
    pub fn find_or_make(workspace: &Workspace) -> Result<Self> {
        if rustup_target_is_installed() {
            return Ok(Self::rustup("installed rustup target"));
        }
        let refused = match add_rustup_target() {
            Ok(()) => return Ok(Self::rustup("rustup target, added now")),
            Err(refused) => refused,
        };
        let sysroot = debian::find_or_build_sysroot(workspace).map_err(|failure| {
            Failure::new(format!("no compiler for {TARGET}"))
                .because(&failure)
                .advise(format!(
                    "with rustup: `rustup target add {TARGET}`; on Debian, as root: {}",
                    packages::install_line(debian::PACKAGES)
                ))
        })?;
        Ok(Self {
            cargo: PathBuf::from(debian::CARGO),
            rustc: sysroot.rustc(),
            description: format!(
                "Debian's compiler with the sysroot {} ({refused})",
                sysroot.folder().display()
            ),
        })
    }

    fn rustup(how: &str) -> Self {
        Self {
            cargo: PathBuf::from("cargo"),
            rustc: PathBuf::from("rustc"),
            description: format!("{how} {TARGET}"),
        }
    }

    /// Which toolchain was taken, for people.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// A cargo that calls this toolchain's compiler, in the workspace.
    pub fn cargo(&self, workspace: &Workspace) -> Command {
        let mut command = Command::new(&self.cargo);
        process::forget_outer_cargo(&mut command).current_dir(workspace.root());
        if self.rustc.is_absolute() {
            command.env("RUSTC", &self.rustc);
        }
        command
    }

    /// The compiler's version, e.g. `rustc 1.90.0`.
    ///
    /// # Errors
    /// When the compiler cannot be started.
    pub fn compiler_version(&self) -> Result<String> {
        let mut command = Command::new(&self.rustc);
        let line = process::output(process::forget_outer_cargo(&mut command).arg("--version"))?;
        Ok(line
            .split_whitespace()
            .take(2)
            .collect::<Vec<_>>()
            .join(" "))
    }
}

/// Whether the default rustc has the target's standard library.
fn rustup_target_is_installed() -> bool {
    let mut command = Command::new("rustc");
    process::forget_outer_cargo(&mut command).args([
        "--print",
        "target-libdir",
        "--target",
        TARGET,
    ]);
    process::output(&mut command).is_ok_and(|folder| Path::new(folder.trim()).is_dir())
}

/// Has rustup download the target, or says why it may not.
fn add_rustup_target() -> std::result::Result<(), String> {
    if downloads_are_forbidden(env::var_os("RUSTUP_AUTO_INSTALL")) {
        return Err(format!(
            "no rustup target {TARGET}, and RUSTUP_AUTO_INSTALL=0 forbids downloads"
        ));
    }
    if process::find_program("rustup").is_none() {
        return Err(format!("no rustup to add the target {TARGET} with"));
    }
    let mut command = Command::new("rustup");
    process::forget_outer_cargo(&mut command).args(["target", "add", TARGET]);
    process::run(&mut command).map_err(|failure| failure.to_string())
}

/// Whether the user's setting keeps rustup from downloading.
fn downloads_are_forbidden(setting: Option<OsString>) -> bool {
    setting.is_some_and(|value| value == "0")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_zero_forbids_downloads() {
        assert!(downloads_are_forbidden(Some("0".into())));
        assert!(!downloads_are_forbidden(Some("1".into())));
        assert!(!downloads_are_forbidden(None));
    }
}
