//! The emulated cores: how QEMU is called, and `xtask qemu` as cargo's runner.
//!
//! QEMU is for arithmetic, programs and exit codes; it models no time and no
//! interrupt latency.

use std::env;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::arm_image::ArmImage;
use crate::board::Machine;
use crate::toolchain::packages;
use crate::{EMULATED_BOX, Failure, Result, Workspace, process};

/// The emulator's name on the search path, and of Debian's package.
pub const PROGRAM: &str = "qemu-system-arm";

/// Longest run of one image unless `RARMA_QEMU_TIMEOUT` (seconds) says otherwise.
const TIMEOUT: Duration = Duration::from_secs(600);

/// Makes sure that the emulator is here.
///
/// # Errors
/// When it is not and cannot be installed.
pub fn ensure_installed() -> Result<()> {
    if process::find_program(PROGRAM).is_some() {
        return Ok(());
    }
    packages::install(&[PROGRAM]).map_err(|failure| {
        Failure::new(format!("no {PROGRAM} on this machine"))
            .because(&failure)
            .advise("install QEMU for ARM with your package manager; the rest works without it")
    })
}

/// QEMU with an image for a machine; `arguments` reach it as its semihosting command line, joined by blanks.
pub fn qemu_command(machine: Machine, elf: &Path, arguments: &[String]) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args(machine.options())
        .args(["-nographic", "-monitor", "none", "-serial", "none"])
        // One instruction is one tick of virtual time: runs repeat exactly.
        .args(["-icount", "shift=0"])
        .args(["-semihosting-config", &semihosting_config(arguments)])
        .arg("-kernel")
        .arg(elf);
    command
}

/// QEMU with the image of the whole box: its serial port waits at `address`
/// (HOST:PORT), and time is that of this machine.
pub fn box_command(elf: &Path, address: &str) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args(Machine::An386.options())
        .args(["-nographic", "-monitor", "none"])
        .arg("-serial")
        .arg(format!("tcp:{address},server=on,wait=off"))
        .args(["-semihosting-config", &semihosting_config(&[])])
        .arg("-kernel")
        .arg(elf);
    command
}

/// Where the box's serial port waits unless [`LISTEN`] says otherwise.
const ADDRESS: &str = "127.0.0.1:7000";
const LISTEN: &str = "RARMA_BOX_LISTEN";

/// Runs the whole box until it is interrupted.
fn run_box(elf: &Path) -> Result<u8> {
    let address = env::var(LISTEN).unwrap_or_else(|_| ADDRESS.to_owned());
    println!("the box listens: rarma connect tcp:{address} (Ctrl-C here ends it)");
    let mut command = box_command(elf, &address);
    let status = command
        .status()
        .map_err(|why| process::cannot_start(&command, &why))?;
    Ok(process::exit_code(status))
}

/// The value of `-semihosting-config`: a comma inside an argument is doubled.
///
/// Without any `arg=` QEMU would hand the image its own path as command line, so an
/// empty one is given.
fn semihosting_config(arguments: &[String]) -> String {
    let mut config = "enable=on,target=native".to_owned();
    if arguments.is_empty() {
        config += ",arg=";
    }
    for argument in arguments {
        config += ",arg=";
        config += &argument.replace(',', ",,");
    }
    config
}

/// Waits for a child, and ends it when it runs too long.
///
/// # Errors
/// When waiting fails or the time is over.
pub fn wait(child: &mut Child, elf: &Path) -> Result<ExitStatus> {
    let limit = timeout(env::var_os("RARMA_QEMU_TIMEOUT").as_deref())?;
    let begun = Instant::now();
    let cannot = |why: io::Error| Failure::new("cannot wait for QEMU").because(why);
    loop {
        if let Some(status) = child.try_wait().map_err(cannot)? {
            return Ok(status);
        }
        if begun.elapsed() > limit {
            child.kill().and_then(|()| child.wait()).map_err(cannot)?;
            return Err(Failure::new(format!(
                "{} ran longer than {} s in QEMU and was ended",
                elf.display(),
                limit.as_secs()
            ))
            .advise("if it only needs longer, set RARMA_QEMU_TIMEOUT to more seconds"));
        }
        thread::sleep(Duration::from_millis(5));
    }
}

fn timeout(setting: Option<&OsStr>) -> Result<Duration> {
    let Some(setting) = setting else {
        return Ok(TIMEOUT);
    };
    setting
        .to_str()
        .and_then(|seconds| seconds.parse().ok())
        .map(Duration::from_secs)
        .ok_or_else(|| {
            Failure::usage(format!(
                "RARMA_QEMU_TIMEOUT is `{}`, not whole seconds",
                setting.display()
            ))
        })
}

/// The command `xtask qemu ELF [ARGS]`: runs an image and passes on its exit code.
///
/// # Errors
/// When there is no image, no QEMU, or the image runs too long.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let Some((elf, arguments)) = arguments.split_first() else {
        return Err(Failure::usage(
            "`xtask qemu` needs the path of an ELF image",
        ));
    };
    let elf = Path::new(elf);
    let image = ArmImage::read(elf)?;
    let logs = image.has_defmt_log();
    ensure_installed()?;
    if elf.file_stem().is_some_and(|stem| stem == EMULATED_BOX) {
        return run_box(elf);
    }

    let mut command = qemu_command(Machine::of_entry(image.entry()), elf, arguments);
    let decoder = if logs { log_decoder(workspace) } else { None };
    let Some(decoder) = decoder else {
        let mut child = command
            .spawn()
            .map_err(|why| process::cannot_start(&command, &why))?;
        return Ok(process::exit_code(wait(&mut child, elf)?));
    };

    let mut child = command
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|why| process::cannot_start(&command, &why))?;
    let mut decoding = Command::new(decoder);
    decoding.arg(elf);
    if let Some(stdout) = child.stdout.take() {
        decoding.stdin(stdout);
    }
    let mut decoding_child = match decoding.spawn() {
        Ok(decoding_child) => decoding_child,
        Err(why) => {
            // An image nobody listens to would block; its end is of no use now.
            let _ = child.kill();
            return Err(process::cannot_start(&decoding, &why));
        }
    };
    // The pipe's reading end in this process must close, or QEMU never sees a dead reader.
    drop(decoding);
    let status = wait(&mut child, elf);
    let decoded = decoding_child.wait();
    if !decoded.is_ok_and(|status| status.success()) {
        eprintln!("warning: the image's log could not be decoded to its end");
    }
    Ok(process::exit_code(status?))
}

/// The program that decodes defmt logs, built on first use.
///
/// A log that nobody can read is no reason not to run the image: without the decoder
/// its exit code still counts.
fn log_decoder(workspace: &Workspace) -> Option<PathBuf> {
    match process::build_tool(workspace, "defmt-log") {
        Ok(folder) => Some(folder.join("defmt-log")),
        Err(failure) => {
            eprintln!("warning: the image's log is shown undecoded: {failure}");
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn commas_in_arguments_are_doubled() {
        assert_eq!(
            semihosting_config(&words("--order 8,7")),
            "enable=on,target=native,arg=--order,arg=8,,7"
        );
    }

    #[test]
    fn no_argument_is_an_empty_one() {
        assert_eq!(semihosting_config(&[]), "enable=on,target=native,arg=");
    }

    #[test]
    fn the_image_comes_last() {
        let command = qemu_command(Machine::An386, Path::new("image.elf"), &[]);
        let line = process::spelled(&command);
        assert!(
            line.starts_with("qemu-system-arm -cpu cortex-m4 -machine mps2-an386"),
            "{line}"
        );
        assert!(line.ends_with("-kernel image.elf"), "{line}");
    }

    #[test]
    fn timeouts_are_whole_seconds() {
        assert_eq!(timeout(None), Ok(TIMEOUT));
        assert_eq!(timeout(Some(OsStr::new("7"))), Ok(Duration::from_secs(7)));
        assert!(timeout(Some(OsStr::new("soon"))).is_err());
    }
}
