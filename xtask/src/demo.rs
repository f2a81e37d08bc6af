//! `cargo demo`: the main job on the host, nothing installed but Rust.

use crate::{Result, Workspace, process};

/// The program of the demonstration is built without what it does not need (decoders, the live screen, the emulated
/// chip), so that it is there in two minutes.
pub const PROGRAM: [&str; 4] = [
    "--release",
    "--package",
    "rarma-cli",
    "--no-default-features",
];

/// Runs `rarma demo` in release and lets it write to the terminal as it goes.
///
/// # Errors
/// When cargo cannot be started.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let mut command = process::host_cargo(workspace);
    command
        .arg("run")
        .args(PROGRAM)
        .args(["--", "demo", "--out"])
        .arg(workspace.root().join("target/demo"))
        .args(arguments);
    Ok(process::exit_code(process::status(&mut command)?))
}
