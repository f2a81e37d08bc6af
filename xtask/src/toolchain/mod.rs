//! A compiler for a target that is not this machine, from wherever it can be had.
//!
//! In this order: the rustup target that is installed; `rustup target add`, unless
//! the user forbade downloads with `RUSTUP_AUTO_INSTALL=0`; Debian's packages, whose
//! compiler builds the target's libraries from Debian's sources into a private sysroot.
//! The user's rustup toolchains are never changed but by that one `target add`.

pub mod debian;
pub mod packages;

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Failure, Result, TARGET, Workspace, process};

/// What images and pages are built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    /// Its name for rustc.
    pub triple: &'static str,
    /// The libraries that it needs, as cargo's `-Zbuild-std` names them.
    libraries: &'static str,
    /// The folder of its sysroot in the build directory.
    folder: &'static str,
}

/// Boards with a Cortex-M4F.
pub const ARM: Target = Target {
    triple: TARGET,
    libraries: "core,alloc",
    folder: "arm-toolchain",
};

/// Boards with a Cortex-M33 and its FPU.
pub const ARM_V8: Target = Target {
    triple: "thumbv8m.main-none-eabihf",
    libraries: "core,alloc",
    folder: "arm-v8-toolchain",
};

/// Browsers.
pub const WEB: Target = Target {
    triple: "wasm32-unknown-unknown",
    libraries: "std,panic_abort",
    folder: "web-toolchain",
};

/// A cargo and a rustc that build for a [`Target`].
#[derive(Debug, Clone)]
pub struct Toolchain {
    target: Target,
    cargo: PathBuf,
    rustc: PathBuf,
    description: String,
}

impl Toolchain {
    /// The first toolchain of the list above that works here, made if need be.
    ///
    /// # Errors
    /// When none can be had; the failure names the commands that would bring one.
    pub fn find_or_make(workspace: &Workspace, target: Target) -> Result<Self> {
        let triple = target.triple;
        if rustup_target_is_installed(triple) {
            return Ok(Self::rustup(target, "installed rustup target"));
        }
        let refused = match add_rustup_target(triple) {
            Ok(()) => return Ok(Self::rustup(target, "rustup target, added now")),
            Err(refused) => refused,
        };
        let sysroot = debian::find_or_build_sysroot(workspace, target).map_err(|failure| {
            Failure::new(format!("no compiler for {triple}"))
                .because(&failure)
                .advise(format!(
                    "with rustup: `rustup target add {triple}`; on Debian, as root: {}",
                    packages::install_line(debian::PACKAGES)
                ))
        })?;
        Ok(Self {
            target,
            cargo: PathBuf::from(debian::CARGO),
            rustc: sysroot.rustc(),
            description: format!(
                "Debian's compiler with the sysroot {} ({refused})",
                sysroot.folder().display()
            ),
        })
    }

    fn rustup(target: Target, how: &str) -> Self {
        Self {
            target,
            cargo: PathBuf::from("cargo"),
            rustc: PathBuf::from("rustc"),
            description: format!("{how} {}", target.triple),
        }
    }

    /// What it builds for.
    pub fn target(&self) -> Target {
        self.target
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
fn rustup_target_is_installed(triple: &str) -> bool {
    let mut command = Command::new("rustc");
    process::forget_outer_cargo(&mut command).args([
        "--print",
        "target-libdir",
        "--target",
        triple,
    ]);
    process::output(&mut command).is_ok_and(|folder| Path::new(folder.trim()).is_dir())
}

/// Has rustup download the target, or says why it may not.
fn add_rustup_target(triple: &str) -> std::result::Result<(), String> {
    if downloads_are_forbidden(env::var_os("RUSTUP_AUTO_INSTALL")) {
        return Err(format!(
            "no rustup target {triple}, and RUSTUP_AUTO_INSTALL=0 forbids downloads"
        ));
    }
    if process::find_program("rustup").is_none() {
        return Err(format!("no rustup to add the target {triple} with"));
    }
    let mut command = Command::new("rustup");
    process::forget_outer_cargo(&mut command).args(["target", "add", triple]);
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
