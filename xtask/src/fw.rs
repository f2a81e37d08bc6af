//! `cargo fw build|run|test [BOARD] [CARGO ARGS] [-- IMAGE ARGS]`.
//!
//! An emulated board runs in QEMU; a real one is flashed by a program of its own, see
//! [`crate::board`].

use std::path::PathBuf;
use std::process::Command;

use crate::board::{self, Board, Runner};
use crate::toolchain::Toolchain;
use crate::{EMULATED_BOARD, EMULATED_BOX, Failure, Result, Workspace, pico, process};

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
    pub board: &'static Board,
    /// Write the image's path to stdout at the end.
    pub print_elf: bool,
    /// Arguments for cargo.
    pub cargo_arguments: Vec<String>,
    /// Arguments for the image or the test, after `--`.
    pub image_arguments: Vec<String>,
}

impl Request {
    /// Builds the image of `board`, nothing else asked.
    ///
    /// # Errors
    /// When there is no such board.
    pub fn build(board: &str) -> Result<Self> {
        Self::plain(Verb::Build, board)
    }

    /// Builds the whole box for the emulated board.
    ///
    /// # Errors
    /// None: there is that board.
    pub fn build_box() -> Result<Self> {
        Ok(Self {
            cargo_arguments: ["--bin", EMULATED_BOX].map(str::to_owned).to_vec(),
            ..Self::build(EMULATED_BOARD)?
        })
    }

    /// Runs the on-target tests of `board`.
    ///
    /// # Errors
    /// When there is no such board.
    pub fn test(board: &str) -> Result<Self> {
        Self::plain(Verb::Test, board)
    }

    fn plain(verb: Verb, board: &str) -> Result<Self> {
        Ok(Self {
            verb,
            board: known(board)?,
            print_elf: false,
            cargo_arguments: Vec::new(),
            image_arguments: Vec::new(),
        })
    }

    /// Reads the arguments after `cargo fw`.
    ///
    /// # Errors
    /// When the verb or the board is unknown, or `--print-elf` stands where nothing is only built.
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
        let mut board = EMULATED_BOARD;
        if let Some((first, others)) = rest
            .split_first()
            .filter(|(first, _)| !first.starts_with('-'))
        {
            board = first;
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
            board: known(board)?,
            print_elf,
            cargo_arguments: rest
                .iter()
                .filter(|word| *word != "--print-elf")
                .cloned()
                .collect(),
            image_arguments: image.iter().skip(1).cloned().collect(),
        })
    }

    /// The binary that a build makes: the one chosen with `--bin`, else the board's.
    fn binary(&self) -> &str {
        let mut words = self.cargo_arguments.iter();
        while let Some(word) = words.next() {
            if let Some(name) = word.strip_prefix("--bin=") {
                return name;
            }
            if word == "--bin" {
                return words.next().map_or(self.board.name, String::as_str);
            }
        }
        self.board.name
    }

    /// Options by which cargo runs the image of a real board with what flashes it. No variable: with a dot in
    /// the triple cargo would put its words behind those of the file.
    fn runner(&self) -> Vec<String> {
        let triple = self.board.target.triple;
        match (self.verb, self.board.runner) {
            (Verb::Run, Runner::Flasher { line, .. }) => {
                vec![
                    "--config".to_owned(),
                    format!("target.{triple}.runner={line:?}"),
                ]
            }
            _ => Vec::new(),
        }
    }

    /// Everything after `cargo`, without the build directory.
    fn cargo_line(&self) -> Vec<String> {
        let mut line: Vec<String> = [
            self.verb.name(),
            "--package",
            "firmware",
            "--target",
            self.board.target.triple,
            "--profile",
            self.board.profile,
            "--features",
        ]
        .map(str::to_owned)
        .to_vec();
        line.push(format!("board-{}", self.board.name));
        let chosen = self.cargo_arguments.iter().any(|word| {
            SELECTORS
                .iter()
                .any(|selector| word == selector || word.starts_with(&format!("{selector}=")))
        });
        if !chosen {
            match self.verb {
                Verb::Build | Verb::Run => {
                    line.extend(["--bin", self.board.name].map(str::to_owned));
                }
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

/// The board of that name.
fn known(name: &str) -> Result<&'static Board> {
    Board::of(name).ok_or_else(|| {
        Failure::usage(format!("no board `{name}`"))
            .advise(format!("boards: {}", boards().join(", ")))
    })
}

/// Path of a board's linked image, by the name of its binary.
pub fn elf_path(workspace: &Workspace, board: &Board, binary: &str) -> PathBuf {
    workspace
        .firmware_target_dir()
        .join(board.target.triple)
        .join(board.profile)
        .join(binary)
}

/// The cargo command for a request, with a toolchain that has the target.
pub fn command(workspace: &Workspace, toolchain: &Toolchain, request: &Request) -> Command {
    let mut command = toolchain.cargo(workspace);
    command
        .args(same_anywhere(workspace, toolchain))
        .args(request.runner())
        .args(request.cargo_line())
        .env("CARGO_TARGET_DIR", workspace.firmware_target_dir())
        .env("RARMA_XTASK", workspace.program());
    command
}

/// Options by which an image is the same wherever it is built: the texts of its panics hold the paths
/// of its sources.
fn same_anywhere(workspace: &Workspace, toolchain: &Toolchain) -> [String; 2] {
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
    // A triple may hold a dot: cargo looks it up by its two parts, as it stands.
    let flags = format!("target.{}.rustflags={flags:?}", toolchain.target().triple);
    ["--config".to_owned(), flags]
}

/// Builds a board's image and returns its path.
///
/// # Errors
/// When no toolchain has the target, or the build fails.
pub fn build_image(workspace: &Workspace, board: &str) -> Result<PathBuf> {
    let request = Request::build(board)?;
    let toolchain = Toolchain::find_or_make(workspace, request.board.target)?;
    process::run(&mut command(workspace, &toolchain, &request))?;
    Ok(elf_path(workspace, request.board, board))
}

/// Names of the boards.
pub fn boards() -> Vec<String> {
    let mut boards = board::ALL.map(|board| board.name.to_owned()).to_vec();
    boards.sort();
    boards
}

/// The command `cargo fw`.
///
/// # Errors
/// When the arguments are wrong, no toolchain has the target, or cargo cannot be started.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let name = request.board.name;
    if request.verb == Verb::Test && !request.board.is_emulated() {
        return Err(
            Failure::usage(format!("board `{name}` is not emulated")).advise(format!(
                "`cargo fw test {EMULATED_BOARD}`; `cargo fw run {name}` flashes the image"
            )),
        );
    }
    if let (
        Verb::Run,
        Runner::Flasher {
            program, advice, ..
        },
    ) = (request.verb, request.board.runner)
        && process::find_program(program).is_none()
    {
        return Err(Failure::new(format!("no {program} to flash the board with")).advise(advice));
    }

    let toolchain = Toolchain::find_or_make(workspace, request.board.target)?;
    eprintln!("fw: {}", toolchain.description());
    let status = process::status(&mut command(workspace, &toolchain, &request))?;
    if !status.success() {
        return Ok(process::exit_code(status));
    }
    if request.verb == Verb::Build && request.binary() == pico::BOARD {
        let elf = elf_path(workspace, request.board, pico::BOARD);
        eprintln!(
            "fw: to flash it by drag and drop: {}",
            pico::finish(&elf)?.display()
        );
    }
    if request.print_elf {
        println!(
            "{}",
            elf_path(workspace, request.board, request.binary()).display()
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
            (request.verb, request.board.name),
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
        let request = parse("run pico2 --verbose -- monitor a.wav --fs 10").expect("valid");
        assert_eq!(request.board.name, "pico2");
        assert_eq!(request.cargo_arguments, ["--verbose"]);
        assert_eq!(request.image_arguments, ["monitor", "a.wav", "--fs", "10"]);
        assert!(
            request
                .cargo_line()
                .join(" ")
                .ends_with("--bin pico2 --verbose -- monitor a.wav --fs 10")
        );
    }

    #[test]
    fn an_option_is_no_board() {
        let request = parse("build --print-elf --bin count").expect("valid");
        assert_eq!(request.board.name, EMULATED_BOARD);
        assert!(request.print_elf);
        assert_eq!(request.binary(), "count");
        assert!(
            !request.cargo_line().contains(&EMULATED_BOARD.to_owned()),
            "a chosen --bin stands alone"
        );
    }

    #[test]
    fn a_board_has_its_profile_and_its_core() {
        let line = |words: &str| parse(words).expect("valid").cargo_line().join(" ");
        let nucleo = line("build nucleo-g474re");
        assert!(nucleo.contains("--target thumbv7em-none-eabihf --profile fw-small "));
        let pico = line("build pico2");
        assert!(pico.contains("--target thumbv8m.main-none-eabihf --profile fw-small "));
        assert!(line("build").contains("--profile fw "));
        assert!(
            !parse("run nucleo-g474re")
                .expect("valid")
                .board
                .is_emulated()
        );
    }

    #[test]
    fn every_memory_map_is_a_boards() {
        let maps = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/memory");
        let entries = std::fs::read_dir(maps).expect("a folder of maps").flatten();
        let mut names: Vec<String> = entries
            .filter_map(|entry| Some(entry.file_name().to_str()?.strip_suffix(".x")?.to_owned()))
            .collect();
        names.sort();
        assert_eq!(names, boards());
    }

    #[test]
    fn wrong_lines_are_refused_by_name() {
        assert!(parse("flash").is_err_and(|failure| failure.to_string().contains("flash")));
        assert!(parse("run other").is_err_and(|failure| failure.to_string().contains("pico2")));
        assert!(parse("run --print-elf").is_err_and(|failure| failure.exit_code() == 2));
    }
}
