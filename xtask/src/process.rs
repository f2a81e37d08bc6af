//! Starting other programs: clean environment, readable failures.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use crate::{Failure, Result, Workspace};

/// Variables that cargo and rustup set for the programs they start; an inner cargo
/// that inherits them would use the outer one's toolchain.
const OUTER_CARGO: [&str; 6] = [
    "RUSTUP_TOOLCHAIN",
    "CARGO",
    "RUSTC",
    "RUSTDOC",
    "RUSTC_WRAPPER",
    "RUSTC_WORKSPACE_WRAPPER",
];

/// Removes what the outer cargo left in the environment of `command`.
pub fn forget_outer_cargo(command: &mut Command) -> &mut Command {
    for variable in OUTER_CARGO {
        command.env_remove(variable);
    }
    command
}

/// `cargo` for the host, in the workspace, with the toolchain the user called.
pub fn host_cargo(workspace: &Workspace) -> Command {
    let mut command = Command::new("cargo");
    command.current_dir(workspace.root());
    // What cargo says of this package is nothing to another build: a package whose build looks at one of
    // these (`ring` does) would be built anew after each build by hand.
    for (name, _) in env::vars_os() {
        let name_of = name.to_string_lossy();
        if name_of.starts_with("CARGO_PKG_") || name_of.starts_with("CARGO_MANIFEST_") {
            command.env_remove(name);
        }
    }
    command
}

/// What every check chooses that builds for the host: cargo gives a shared dependency the features that
/// all chosen packages ask for, so that another choice would build nearly everything anew.
pub const HOST: [&str; 3] = ["--workspace", "--features", "rarma-cli/fleet"];

/// Builds `rarma` as the checks do, with every command; where a copy of it is, for other checks build the program with other
/// features in the same place.
///
/// # Errors
/// It does not build, or there is no room for the copy.
pub fn rarma(workspace: &Workspace) -> Result<PathBuf> {
    let mut build = host_cargo(workspace);
    build.args(["build", "--release", "--quiet", "--bin", "rarma"]);
    run(build.args(HOST))?;
    let folder = workspace.target_dir().join("every-command");
    let (new, copy) = (folder.join("rarma.new"), folder.join("rarma"));
    // Under another name first: the one that is there may be running.
    let copied = fs::create_dir_all(&folder)
        .and_then(|()| fs::copy(workspace.target_dir().join("release/rarma"), &new))
        .and_then(|_| fs::rename(&new, &copy));
    copied.map_err(|why| {
        Failure::new(format!("no copy of rarma in {}", folder.display())).because(why)
    })?;
    Ok(copy)
}

/// The command line as one would type it, for messages.
pub fn spelled(command: &Command) -> String {
    std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .map(|word| {
            if word.contains(' ') {
                format!("'{word}'")
            } else {
                word.into_owned()
            }
        })
        .collect::<Vec<_>>()
        .join(" ")
}

/// Runs `command` with the terminal's input and output, and waits for it.
///
/// # Errors
/// When it cannot be started.
pub fn status(command: &mut Command) -> Result<ExitStatus> {
    command.status().map_err(|why| cannot_start(command, &why))
}

/// Runs `command` and fails unless it succeeds.
///
/// # Errors
/// When it cannot be started or does not exit with 0.
pub fn run(command: &mut Command) -> Result<()> {
    let status = status(command)?;
    if status.success() {
        return Ok(());
    }
    Err(Failure::new(format!("`{}` failed", spelled(command))).because(status))
}

/// Runs `command` quietly and returns what it wrote to stdout.
///
/// # Errors
/// When it cannot be started or does not exit with 0; the failure quotes its stderr.
pub fn output(command: &mut Command) -> Result<String> {
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|why| cannot_start(command, &why))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let stderr = String::from_utf8_lossy(&output.stderr);
    Err(
        Failure::new(format!("`{}` failed", spelled(command))).because(format!(
            "{}\n{}",
            output.status,
            stderr.trim_end()
        )),
    )
}

/// The failure to start a program at all.
pub fn cannot_start(command: &Command, why: &std::io::Error) -> Failure {
    Failure::new(format!("cannot start `{}`", spelled(command))).because(why)
}

/// Exit code to pass on to our own caller; a child ended by a signal counts as 1.
pub fn exit_code(status: ExitStatus) -> u8 {
    status
        .code()
        .and_then(|code| u8::try_from(code).ok())
        .unwrap_or(1)
}

/// Finds a program on the search path.
pub fn find_program(name: &str) -> Option<PathBuf> {
    let given = Path::new(name);
    if given.components().count() > 1 {
        return given.is_file().then(|| given.to_path_buf());
    }
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|candidate| candidate.is_file())
}

/// Builds a helper from `tools/<name>`, which is a workspace of its own so that nothing
/// else waits for it, and returns the folder of what was built.
///
/// # Errors
/// When the build fails.
pub fn build_tool(workspace: &Workspace, name: &str) -> Result<PathBuf> {
    build_tool_with(workspace, name, &[])
}

/// [`build_tool`] with variables that its build reads.
///
/// # Errors
/// When the build fails.
pub fn build_tool_with(
    workspace: &Workspace,
    name: &str,
    variables: &[(&str, &str)],
) -> Result<PathBuf> {
    let built = workspace.tools_target_dir();
    let mut command = host_cargo(workspace);
    command
        .args(["build", "--quiet", "--release", "--manifest-path"])
        .arg(workspace.root().join("tools").join(name).join("Cargo.toml"))
        .env("CARGO_TARGET_DIR", &built)
        .envs(variables.iter().copied());
    run(&mut command)?;
    Ok(built.join("release"))
}

/// Ticks of Linux' tables a second, on every processor that Rust's host tools are made for.
const TICKS_PER_S: f64 = 100.0;

/// What the programs that were started here and have ended took of the processor, s; none where it cannot be told.
pub fn processor_s() -> Option<f64> {
    of_ended(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// Fields 16 and 17 of such a line, user's and system's; the second, a name in brackets, may hold anything.
fn of_ended(stat: &str) -> Option<f64> {
    let (_, from_third) = stat.rsplit_once(')')?;
    let mut fields = from_third.split_whitespace().skip(13);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_s_time_is_read_past_any_name() {
        let line = "7 (a ) b) S 1 7 7 0 -1 4194304 9 9 9 9 11 12 250 50 20 0 1 0";
        assert_eq!(of_ended(line), Some(3.0));
        assert_eq!(of_ended("7 (a) S 1"), None);
        assert_eq!(of_ended(""), None);
    }

    #[test]
    fn spells_a_command_as_typed() {
        let mut command = Command::new("cargo");
        command.args(["build", "--features", "a b"]);
        assert_eq!(spelled(&command), "cargo build --features 'a b'");
    }

    #[test]
    fn a_missing_program_is_not_found() {
        assert_eq!(find_program("no-program-has-this-name"), None);
        assert_eq!(find_program("/no/such/folder/sh"), None);
    }
}
