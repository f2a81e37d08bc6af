//! The image `count` (firmware/src/bin/count/main.rs), built and run kernel by kernel.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use super::calls::Unwanted;
use super::plugin::{self, Report};
use crate::arm_image::ArmImage;
use crate::board::Machine;
use crate::fw::{self, Request};
use crate::toolchain::{ARM, ARM_V8, Target, Toolchain};
use crate::{EMULATED_BOARD, EMULATED_M33, Failure, Result, Workspace, process, qemu};

/// The image's binary in the firmware package.
const BINARY: &str = "count";

/// Its feature that puts single functions in the place of the kernels.
const FUNCTIONS: &str = "count-functions";

/// Functions that the image calls right before and after a kernel's loop.
const MARKS: [&str; 2] = ["roi_begin", "roi_end"];

/// One kernel's run, the loop around it included.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// Samples the kernel was given.
    pub samples: u64,
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles estimated.
    pub cycles: u64,
    /// Bytes of all functions entered.
    pub code_bytes: u64,
    /// Deepest use of the stack.
    pub stack_bytes: u64,
    /// Size of the kernel's state.
    pub state_bytes: u64,
    /// Calls that it should not have.
    pub unwanted: Unwanted,
}

/// The built image.
#[derive(Debug)]
pub struct CountImage {
    elf: PathBuf,
    image: ArmImage,
    marks: [u64; 2],
    machine: Machine,
}

/// A core that is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Core {
    /// Cortex-M4F: instructions, and cycles estimated by its manual's table.
    M4,
    /// Cortex-M33: instructions alone, for its manual has no table of their times.
    M33,
}

impl Core {
    fn board(self) -> &'static str {
        match self {
            Self::M4 => EMULATED_BOARD,
            Self::M33 => EMULATED_M33,
        }
    }

    fn machine(self) -> Machine {
        match self {
            Self::M4 => Machine::An386,
            Self::M33 => Machine::An505,
        }
    }

    /// What it needs.
    pub fn target(self) -> Target {
        match self {
            Self::M4 => ARM,
            Self::M33 => ARM_V8,
        }
    }
}

impl CountImage {
    /// Builds the image for the emulated board with this core, with its kernels or with single functions.
    ///
    /// # Errors
    /// When it does not build or lacks the marks.
    pub fn build(
        workspace: &Workspace,
        toolchain: &Toolchain,
        core: Core,
        functions: bool,
    ) -> Result<Self> {
        let mut request = Request::build(core.board())?;
        request.cargo_arguments = vec!["--bin".to_owned(), BINARY.to_owned()];
        if functions {
            let feature = ["--features".to_owned(), FUNCTIONS.to_owned()];
            request.cargo_arguments.extend(feature);
        }
        process::run(&mut fw::command(workspace, toolchain, &request))?;
        let elf = fw::elf_path(workspace, request.board, BINARY);
        let image = ArmImage::read(&elf)?;
        let mark = |name: &str| {
            image.function(name).map(|function| function.code.start).ok_or_else(|| {
                Failure::new(format!("{} has no function `{name}`", elf.display()))
                    .advise("the count image must define it `extern \"C\"`, not inlined, name not mangled")
            })
        };
        let marks = [mark(MARKS[0])?, mark(MARKS[1])?];
        Ok(Self {
            marks,
            image,
            machine: core.machine(),
            elf,
        })
    }

    /// Names of its kernels, in its order.
    ///
    /// # Errors
    /// When it cannot be run.
    pub fn kernels(&self) -> Result<Vec<String>> {
        let said = self.run(None, "--list")?;
        Ok(said
            .lines()
            .filter_map(|line| line.strip_prefix("kernel "))
            .map(|name| name.trim().to_owned())
            .collect())
    }

    /// Runs one kernel under the plugin.
    ///
    /// # Errors
    /// When it cannot be run, or the image or the plugin says something unexpected.
    pub fn measure(&self, plugin: &Path, kernel: &str) -> Result<Measured> {
        // Its own: kernels run side by side. That of an earlier run must not be taken for this one's.
        let report = self.elf.with_extension(format!("{kernel}.report"));
        let _ = fs::remove_file(&report);
        let [begin, end] = self.marks;
        let counting = plugin::argument(plugin, begin, end, &report);
        let said = self.run(Some(counting), kernel)?;
        let failed =
            |why: String| Failure::new(format!("cannot count kernel `{kernel}`")).because(why);
        let sizes = Sizes::parse(&said)
            .ok_or_else(|| failed(format!("the image said `{}`, not its sizes", said.trim())))?;
        let report = fs::read_to_string(&report).map_err(|why| {
            failed(format!(
                "the plugin wrote no report {}: {why}",
                report.display()
            ))
        })?;
        let report = Report::parse(&report).map_err(failed)?;
        Ok(Measured {
            samples: sizes.samples,
            instructions: report.instructions,
            cycles: report.cycles,
            code_bytes: self.image.code_bytes(&report.executed),
            stack_bytes: sizes.stack_bytes,
            state_bytes: sizes.state_bytes,
            unwanted: Unwanted::find(&self.image, &report.executed),
        })
    }

    /// Runs the image with one argument and returns what it says.
    fn run(&self, plugin: Option<OsString>, argument: &str) -> Result<String> {
        let mut command = qemu::qemu_command(self.machine, &self.elf, &[argument.to_owned()]);
        if let Some(plugin) = plugin {
            command.arg("-plugin").arg(plugin);
        }
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|why| process::cannot_start(&command, &why))?;
        // A few lines: they fit into the pipe while we wait.
        let status = qemu::wait(&mut child, &self.elf)?;
        let mut said = String::new();
        if let Some(mut stdout) = child.stdout.take() {
            std::io::Read::read_to_string(&mut stdout, &mut said)
                .map_err(|why| Failure::new("cannot read what the image says").because(why))?;
        }
        if status.success() {
            return Ok(said);
        }
        Err(
            Failure::new(format!("`{}` failed", process::spelled(&command)))
                .because(format!("{status}\n{said}")),
        )
    }
}

/// What the image itself knows: `samples 2000 state_bytes 4 stack_bytes 16`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sizes {
    samples: u64,
    state_bytes: u64,
    stack_bytes: u64,
}

impl Sizes {
    fn parse(said: &str) -> Option<Self> {
        let line = said.lines().find(|line| line.starts_with("samples "))?;
        let words: Vec<_> = line.split_whitespace().collect();
        match words.as_slice() {
            [
                "samples",
                samples,
                "state_bytes",
                state,
                "stack_bytes",
                stack,
            ] => Some(Self {
                samples: samples.parse().ok().filter(|samples| *samples > 0)?,
                state_bytes: state.parse().ok()?,
                stack_bytes: stack.parse().ok()?,
            }),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_sizes_among_other_lines() {
        let said = "hello\nsamples 2000 state_bytes 64 stack_bytes 128\n";
        assert_eq!(
            Sizes::parse(said),
            Some(Sizes {
                samples: 2000,
                state_bytes: 64,
                stack_bytes: 128
            })
        );
        assert_eq!(Sizes::parse("samples 0 state_bytes 1 stack_bytes 1"), None);
        assert_eq!(Sizes::parse("samples 2000"), None);
    }
}
