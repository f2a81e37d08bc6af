//! QEMU's counting plugin: built when first needed, its report read back.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Failure, Result, Workspace, process, qemu};

/// What the plugin counted between the two marks.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Report {
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles estimated for them.
    pub cycles: u64,
    /// Addresses of the instructions that were executed.
    pub executed: Vec<u64>,
}

impl Report {
    /// Reads the plugin's report.
    ///
    /// # Errors
    /// Quotes the line that is not understood.
    pub fn parse(text: &str) -> std::result::Result<Self, String> {
        let mut report = Self::default();
        for line in text.lines() {
            let not_understood = || format!("line `{line}` is not understood");
            let mut words = line.split(' ');
            match (words.next(), words.next()) {
                (Some("instructions"), Some(count)) => {
                    report.instructions = count.parse().map_err(|_| not_understood())?
                }
                (Some("cycles"), Some(count)) => {
                    report.cycles = count.parse().map_err(|_| not_understood())?
                }
                (Some("executed"), Some(address)) => {
                    report
                        .executed
                        .push(u64::from_str_radix(address, 16).map_err(|_| not_understood())?);
                }
                (Some("class"), Some(_)) => {}
                _ => return Err(not_understood()),
            }
        }
        if report.instructions == 0 {
            return Err("nothing was executed between the marks".to_owned());
        }
        Ok(report)
    }
}

/// Builds the plugin for the installed QEMU and returns its path.
///
/// # Errors
/// When QEMU does not tell its version or the build fails.
pub fn build(workspace: &Workspace) -> Result<PathBuf> {
    let version = process::output(Command::new(qemu::PROGRAM).arg("--version"))?;
    let api = interface_version(&version).ok_or_else(|| {
        Failure::new(format!(
            "cannot read QEMU's version from `{}`",
            version.trim()
        ))
    })?;
    let folder = process::build_tool_with(workspace, "m4-cycles", &[("M4_CYCLES_API", api)])?;
    Ok(folder.join("libm4_cycles.so"))
}

/// The plugin interface that a QEMU accepts, from what `--version` prints.
fn interface_version(version: &str) -> Option<&'static str> {
    let number = version.split_once("version ")?.1;
    let major: u32 = number.split('.').next()?.parse().ok()?;
    Some(if major >= 9 { "2" } else { "1" })
}

/// Value of QEMU's `-plugin`: the library, the two marks, the report's file.
pub fn argument(library: &Path, begin: u64, end: u64, report: &Path) -> OsString {
    let quoted = |path: &Path| path.to_string_lossy().replace(',', ",,");
    format!(
        "{},begin={begin:x},end={end:x},out={}",
        quoted(library),
        quoted(report)
    )
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_a_report() {
        let text = "instructions 6\ncycles 10\nclass FloatAdd instructions 2 cycles 2\nexecuted 10\nexecuted 1a\n";
        let report = Report {
            instructions: 6,
            cycles: 10,
            executed: vec![0x10, 0x1a],
        };
        assert_eq!(Report::parse(text), Ok(report));
        assert!(Report::parse("").is_err());
        assert!(Report::parse("instructions many").is_err_and(|why| why.contains("many")));
    }

    #[test]
    fn the_interface_follows_qemus_version() {
        assert_eq!(
            interface_version("QEMU emulator version 7.2.19 (Debian 1:7.2)\n"),
            Some("1")
        );
        assert_eq!(
            interface_version("QEMU emulator version 10.0.2\n"),
            Some("2")
        );
        assert_eq!(interface_version("something else"), None);
    }

    #[test]
    fn marks_are_hexadecimal_and_commas_doubled() {
        let argument = argument(Path::new("a,b/lib.so"), 0x1a4, 0x1b0, Path::new("out.txt"));
        assert_eq!(argument, "a,,b/lib.so,begin=1a4,end=1b0,out=out.txt");
    }
}
