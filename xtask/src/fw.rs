//! `cargo fw build|run|test [BOARD] [CARGO ARGS] [-- IMAGE ARGS]`.
//!
//! The emulated board runs in QEMU; a real one is flashed by probe-rs, which then shows the
//! image's log.

use std::path::PathBuf;
use std::process::Command;

use crate::toolchain::{ARM, Toolchain};
use crate::{EMULATED_BOARD, EMULATED_BOX, Failure, Result, TARGET, Workspace, process};

/// The cargo profile of a board's images: on a chip with little flash, the small one.
fn profile(board: &str) -> &'static str {
    if board == EMULATED_BOARD {
        "fw"
    } else {
        "fw-small"
    }
}

/// The program that flashes a real board, as cargo's runner; every real board there is has
/// this chip.
const FLASHER: &str = "probe-rs";
const FLASH_RUNNER: &str = "probe-rs run --chip STM32G474RETx";
const RUNNER_VARIABLE: &str = "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUNNER";

/// Cargo options that choose what is built; with one of them no choice is made here.
const SELECTORS: [&str; 7] = [
    "--bin",
    "--bins",
    "--test",
    "--tests",
    "--lib",
    "--examples",
    "--all-targets",
];

/// What to do with the firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// Link the board's image.
    Build,
    /// Link it and run it: in QEMU, or flashed onto a real board.
    Run,
    /// Link and run the on-target tests.
    Test,
}

impl Verb {
    fn name(self) -> &'static str {
        match self {
            Self::Build => "build",
            Self::Run => "run",
            Self::Test => "test",
        }
    }
}

/// A parsed `cargo fw` command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// What to do.
    pub verb: Verb,
    /// For which board.
    pub board: String,
    /// Write the image's path to stdout at the end.
    pub print_elf: bool,
    /// Arguments for cargo.
    pub cargo_arguments: Vec<String>,
    /// Arguments for the image or the test, after `--`.
    pub image_arguments: Vec<String>,
}

impl Request {
    /// Builds the image of `board`, nothing else asked.
    pub fn build(board: &str) -> Self {
        Self::plain(Verb::Build, board)
    }

    /// Builds the whole box for the emulated board.
    pub fn build_box() -> Self {
        Self {
            cargo_arguments: ["--bin", EMULATED_BOX].map(str::to_owned).to_vec(),
            ..Self::build(EMULATED_BOARD)
        }
    }

    /// Runs the on-target tests of `board`.
    pub fn test(board: &str) -> Self {
        Self::plain(Verb::Test, board)
    }

    fn plain(verb: Verb, board: &str) -> Self {
        Self {
            verb,
            board: board.to_owned(),
            print_elf: false,
            cargo_arguments: Vec::new(),
            image_arguments: Vec::new(),
        }
    }

    /// Reads the arguments after `cargo fw`.
    ///
    /// # Errors
    /// When the verb is unknown, or `--print-elf` stands where nothing is only built.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let split = arguments
            .iter()
            .position(|word| word == "--")
            .unwrap_or(arguments.len());
        let (ours, image) = arguments.split_at(split);
        let verb = match ours.first().map(String::as_str) {
            None | Some("build") => Verb::Build,
            Some("run") => Verb::Run,
            Some("test") => Verb::Test,
            Some(other) => {
                return Err(Failure::usage(format!("`cargo fw {other}`: no such verb"))
                    .advise("cargo fw build|run|test [BOARD] [CARGO ARGS] [-- IMAGE ARGS]"));
            }
        };
        let mut rest = ours.get(1..).unwrap_or_default();
        let mut board = EMULATED_BOARD.to_owned();
        if let Some((first, others)) = rest
            .split_first()
            .filter(|(first, _)| !first.starts_with('-'))
        {
            board.clone_from(first);
            rest = others;
        }
        let print_elf = rest.iter().any(|word| word == "--print-elf");
        if print_elf && verb != Verb::Build {
            return Err(
                Failure::usage(format!("`cargo fw {}` takes no --print-elf", verb.name()))
                    .advise("use `cargo fw build [BOARD] --print-elf`"),
            );
        }
        Ok(Self {
            verb,
            board,
            print_elf,
            cargo_arguments: rest
                .iter()
                .filter(|word| *word != "--print-elf")
                .cloned()
                .collect(),
            image_arguments: image.iter().skip(1).cloned().collect(),
        })
    }

    fn is_emulated(&self) -> bool {
        self.board == EMULATED_BOARD
    }

    /// The binary that a build makes: the one chosen with `--bin`, else the board's.
    fn binary(&self) -> &str {
        let mut words = self.cargo_arguments.iter();
        while let Some(word) = words.next() {
            if let Some(name) = word.strip_prefix("--bin=") {
                return name;
            }
            if word == "--bin" {
                return words.next().unwrap_or(&self.board);
            }
        }
        &self.board
    }

    /// Everything after `cargo`, without the build directory.
    fn cargo_line(&self) -> Vec<String> {
        let mut line: Vec<String> = [
            self.verb.name(),
            "--package",
            "firmware",
            "--target",
            TARGET,
            "--profile",
            profile(&self.board),
            "--features",
        ]
        .map(str::to_owned)
        .to_vec();
        line.push(format!("board-{}", self.board));
        let chosen = self.cargo_arguments.iter().any(|word| {
            SELECTORS
                .iter()
                .any(|selector| word == selector || word.starts_with(&format!("{selector}=")))
        });
        if !chosen {
            match self.verb {
                Verb::Build | Verb::Run => line.extend(["--bin".to_owned(), self.board.clone()]),
                Verb::Test => line.extend(["--test".to_owned(), "*".to_owned()]),
            }
        }
        line.extend(self.cargo_arguments.iter().cloned());
        if !self.image_arguments.is_empty() {
            line.push("--".to_owned());
            line.extend(self.image_arguments.iter().cloned());
        }
        line
    }
}

/// Path of a board's linked image, by the name of its binary.
pub fn elf_path(workspace: &Workspace, board: &str, binary: &str) -> PathBuf {
    workspace
        .firmware_target_dir()
        .join(TARGET)
        .join(profile(board))
        .join(binary)
}

/// The cargo command for a request, with a toolchain that has the target.
pub fn command(workspace: &Workspace, toolchain: &Toolchain, request: &Request) -> Command {
    let mut command = toolchain.cargo(workspace);
    command
        .args(same_anywhere(workspace))
        .args(request.cargo_line())
        .env("CARGO_TARGET_DIR", workspace.firmware_target_dir())
        .env("RARMA_XTASK", workspace.program());
    if request.verb == Verb::Run && !request.is_emulated() {
        command.env(RUNNER_VARIABLE, FLASH_RUNNER);
    }
    command
}

/// Options by which an image is the same wherever it is built: the texts of its panics hold the paths
/// of its sources.
fn same_anywhere(workspace: &Workspace) -> [String; 2] {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let folders = [
        home.map(|home| (home, "cargo")),
        Some((workspace.target_dir().to_path_buf(), "target")),
        Some((workspace.root().to_path_buf(), "rarma")),
    ];
    // Of those that fit, the compiler takes the last.
    let flags: Vec<String> = folders
        .into_iter()
        .flatten()
        .rev()
        .map(|(folder, name)| format!("--remap-path-prefix={}={name}", folder.display()))
        .collect();
    let flags = format!("target.{TARGET}.rustflags={flags:?}");
    ["--config".to_owned(), flags]
}

/// Builds a board's image and returns its path.
///
/// # Errors
/// When no toolchain has the target, or the build fails.
pub fn build_image(workspace: &Workspace, board: &str) -> Result<PathBuf> {
    let toolchain = Toolchain::find_or_make(workspace, ARM)?;
    let request = Request::build(board);
    process::run(&mut command(workspace, &toolchain, &request))?;
    Ok(elf_path(workspace, board, board))
}

/// Boards that have a memory map.
///
/// # Errors
/// When the folder of memory maps cannot be listed.
pub fn boards(workspace: &Workspace) -> Result<Vec<String>> {
    let folder = workspace.root().join("firmware/memory");
    let entries = std::fs::read_dir(&folder).map_err(|why| {
        Failure::new(format!("cannot list the boards in {}", folder.display())).because(why)
    })?;
    let mut boards: Vec<String> = entries
        .flatten()
        .filter_map(|entry| Some(entry.file_name().to_str()?.strip_suffix(".x")?.to_owned()))
        .collect();
    boards.sort();
    Ok(boards)
}

/// The command `cargo fw`.
///
/// # Errors
/// When the arguments are wrong, no toolchain has the target, or cargo cannot be started.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let boards = boards(workspace)?;
    if !boards.contains(&request.board) {
        return Err(
            Failure::usage(format!("no board `{}`", request.board)).advise(format!(
                "boards with a map in firmware/memory: {}",
                boards.join(", ")
            )),
        );
    }
    if request.verb == Verb::Test && !request.is_emulated() {
        return Err(
            Failure::usage(format!("board `{}` is not emulated", request.board)).advise(format!(
                "`cargo fw test {EMULATED_BOARD}`; `cargo fw run {}` flashes the image",
                request.board
            )),
        );
    }
    if request.verb == Verb::Run
        && !request.is_emulated()
        && process::find_program(FLASHER).is_none()
    {
        return Err(
            Failure::new(format!("no {FLASHER} to flash the board with"))
                .advise("`cargo install probe-rs-tools --locked`, then connect the board by USB"),
        );
    }

    let toolchain = Toolchain::find_or_make(workspace, ARM)?;
    eprintln!("fw: {}", toolchain.description());
    let status = process::status(&mut command(workspace, &toolchain, &request))?;
    if !status.success() {
        return Ok(process::exit_code(status));
    }
    if request.print_elf {
        println!(
            "{}",
            elf_path(workspace, &request.board, request.binary()).display()
        );
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Request> {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        Request::parse(&words)
    }

    #[test]
    fn builds_the_emulated_board_by_default() {
        let request = parse("").expect("no arguments are fine");
        assert_eq!(
            (request.verb, request.board.as_str()),
            (Verb::Build, EMULATED_BOARD)
        );
        assert!(
            request
                .cargo_line()
                .ends_with(&["--bin".to_owned(), EMULATED_BOARD.to_owned()])
        );
    }

    #[test]
    fn board_cargo_and_image_arguments_are_told_apart() {
        let request = parse("run other --verbose -- monitor a.wav --fs 10").expect("valid");
        assert_eq!(request.board, "other");
        assert_eq!(request.cargo_arguments, ["--verbose"]);
        assert_eq!(request.image_arguments, ["monitor", "a.wav", "--fs", "10"]);
        assert!(
            request
                .cargo_line()
                .join(" ")
                .ends_with("--bin other --verbose -- monitor a.wav --fs 10")
        );
    }

    #[test]
    fn an_option_is_no_board() {
        let request = parse("build --print-elf --bin count").expect("valid");
        assert_eq!(request.board, EMULATED_BOARD);
        assert!(request.print_elf);
        assert_eq!(request.binary(), "count");
        assert!(
            !request.cargo_line().contains(&EMULATED_BOARD.to_owned()),
            "a chosen --bin stands alone"
        );
    }

    #[test]
    fn a_real_board_has_the_small_profile_and_its_own_runner() {
        let line = |words: &str| parse(words).expect("valid").cargo_line().join(" ");
        assert!(line("build nucleo-g474re").contains("--profile fw-small "));
        assert!(line("build").contains("--profile fw "));
        assert!(!parse("run nucleo-g474re").expect("valid").is_emulated());
        assert!(FLASH_RUNNER.starts_with(FLASHER));
        let target = TARGET.to_uppercase().replace('-', "_");
        assert_eq!(RUNNER_VARIABLE, format!("CARGO_TARGET_{target}_RUNNER"));
    }

    #[test]
    fn wrong_lines_are_refused_by_name() {
        assert!(parse("flash").is_err_and(|failure| failure.to_string().contains("flash")));
        assert!(parse("run --print-elf").is_err_and(|failure| failure.exit_code() == 2));
    }
}
