//! `cargo demo`: the main job on the host, nothing installed but Rust.

use crate::{Result, Workspace, process};

/// Runs `rarma demo` in release and lets it write to the terminal as it goes. It needs no
/// decoders and no sound card, and is built without: a quarter of a minute less.
///
/// # Errors
/// When cargo cannot be started.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let mut command = process::host_cargo(workspace);
    command
        .args([
            "run",
            "--release",
            "--package",
            "rarma-cli",
            "--no-default-features",
            "--",
            "demo",
            "--out",
        ])
        .arg(workspace.root().join("target/demo"))
        .args(arguments);
    Ok(process::exit_code(process::status(&mut command)?))
}
