//! What is done with a documented command: run here, left to another stage, or not run, and why.

use super::shell::Step;
use crate::fw::{Request, Verb};
use crate::{EMULATED_BOARD, EMULATED_BOX, pico};
use std::collections::BTreeMap;
use std::path::Path;

/// What is done with a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Plan {
    /// `rarma` with these arguments is run.
    Rarma(Vec<String>),
    /// One of this program's own commands is run.
    Own(Vec<String>),
    /// An emulated box is started, for the commands after it to talk to.
    EmulatedBox(Vec<String>),
    /// A usual program is run.
    Tool(Vec<String>),
    /// Tests that another stage runs; that they exist is looked up.
    Tests(Tests),
    /// A bench; run where long ones are.
    Bench(String),
    /// Another stage of the same checks does it.
    Stage(&'static str),
    /// It cannot be run here: why.
    Not(&'static str),
}

impl Plan {
    /// Whether it needs the image of the emulated chip, which not every machine can build.
    pub fn needs_image(&self) -> bool {
        match self {
            Self::Rarma(words) => words.first().is_some_and(|word| word == "target"),
            Self::Tool(words) => words.first().is_some_and(|word| word == "size"),
            Self::EmulatedBox(_) => true,
            _ => false,
        }
    }
}

/// A command line of `cargo test`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tests {
    /// The package.
    pub package: String,
    /// Test files by their names; none: the tests in the library.
    pub files: Vec<String>,
    /// What the tests' names hold.
    pub filter: Option<String>,
    /// Those that are ignored otherwise.
    pub ignored: bool,
    /// Features that are switched on.
    pub features: Vec<String>,
}

/// What classifying needs to know of the workspace.
#[derive(Debug, Clone)]
pub struct Known {
    /// Aliases of cargo and what they stand for.
    pub aliases: BTreeMap<String, String>,
}

/// The stage that listens to sound cards.
const SOUND_CARD: &str = "sound card";

/// The stage that keeps records of a plant.
const PLANT: &str = "plant records";
/// The stage that runs a gateway.
const GATEWAY: &str = "plant gateway";

/// Programs that are no part of this project and may stand in the pages.
const TOOLS: [&str; 2] = ["cmp", "size"];

impl Known {
    /// What is done with a command.
    ///
    /// # Errors
    /// The form is not known: what to do about it.
    pub fn plan(&self, step: &Step) -> Result<Plan, String> {
        let Some((program, rest)) = step.words.split_first() else {
            return Err("no program".to_owned());
        };
        match program.as_str() {
            "rarma" if rest.iter().any(|word| word == "--set-key") => {
                Ok(Plan::Not("a key is set at a box's own serial port only"))
            }
            "rarma"
                if rest
                    .iter()
                    .any(|word| word.starts_with("linuxcnc") || word.starts_with("grbl:")) =>
            {
                Ok(Plan::Not(
                    "it wants a machine's controller and its live sound",
                ))
            }
            "rarma" => Ok(ours(rest.to_vec())),
            "cargo" => self.cargo(rest),
            "maturin" | "python3" => python(program, rest),
            tool if TOOLS.contains(&tool) => Ok(Plan::Tool(step.words.clone())),
            other => Err(format!(
                "`{other}` is no program that the pages may use (known: rarma, cargo, maturin, python3, {})",
                TOOLS.join(", ")
            )),
        }
    }

    fn cargo(&self, words: &[String]) -> Result<Plan, String> {
        let Some((verb, rest)) = words.split_first() else {
            return Err("`cargo` alone".to_owned());
        };
        match verb.as_str() {
            "run" => program(rest).map(ours),
            "test" => tests(rest).map(Plan::Tests),
            "bench" => bench(rest).map(Plan::Bench),
            alias => {
                let expanded = self
                    .aliases
                    .get(alias)
                    .ok_or(format!("`cargo {alias}` is no alias in .cargo/config.toml"))?;
                let own = expanded
                    .split_once(" -- ")
                    .map_or("", |(_, command)| command);
                let own: Vec<String> = own
                    .split_whitespace()
                    .map(str::to_owned)
                    .chain(rest.iter().cloned())
                    .collect();
                self.own(&own)
            }
        }
    }

    fn own(&self, words: &[String]) -> Result<Plan, String> {
        let (verb, rest) = words.split_first().ok_or("`cargo xtask` alone")?;
        match verb.as_str() {
            "demo" => Ok(Plan::Own(words.to_vec())),
            "verify" => Ok(Plan::Not("it is this run")),
            "count" => Ok(Plan::Stage("instruction counts")),
            "chip" if rest.first().is_some_and(|word| word == "benchmarks") => Ok(Plan::Not(
                "it wants a C compiler and two sources from elsewhere",
            )),
            "chip" => Ok(Plan::Stage("board figures")),
            "fuzz" => Ok(Plan::Stage("fuzzing")),
            "long" => Ok(Plan::Stage("long forms")),
            "web" => Ok(Plan::Stage("browser page")),
            "screens" => Ok(Plan::Stage("sound card")),
            "book" => Ok(Plan::Stage("book")),
            "gallery" if rest.iter().any(|word| word == "--against") => {
                Ok(Plan::Not("it builds an older version of the program"))
            }
            "gallery" => Ok(Plan::Stage("book")),
            "fw" => self.firmware(words, rest),
            "qemu" => match rest.first() {
                Some(elf)
                    if Path::new(elf)
                        .file_stem()
                        .is_some_and(|s| s == EMULATED_BOX) =>
                {
                    Ok(Plan::EmulatedBox(words.to_vec()))
                }
                Some(_) => Ok(Plan::Not("the bare image wants a job in its folder")),
                None => Err("`qemu` without an image".to_owned()),
            },
            other => Err(format!("`cargo xtask {other}`: no such command")),
        }
    }

    fn firmware(&self, words: &[String], rest: &[String]) -> Result<Plan, String> {
        let request = Request::parse(rest).map_err(|why| why.to_string())?;
        let emulated = request.board.name == EMULATED_BOARD;
        let whole_box = request.cargo_arguments.iter().any(|a| a == EMULATED_BOX);
        match request.verb {
            Verb::Build if emulated => Ok(Plan::Stage("firmware image")),
            Verb::Build if request.board.name == pico::BOARD => Ok(Plan::Stage("Pico image")),
            Verb::Build if request.board.is_emulated() => Ok(Plan::Stage("instruction counts")),
            Verb::Build => Ok(Plan::Stage("board image")),
            Verb::Test => Ok(Plan::Stage("on-target tests")),
            Verb::Run if whole_box => Ok(Plan::EmulatedBox(words.to_vec())),
            Verb::Run if emulated => Ok(Plan::Not("the bare image wants a job in the root")),
            Verb::Run => Ok(Plan::Not("it flashes a board")),
        }
    }
}

/// What is done with a command of `rarma`.
fn ours(arguments: Vec<String>) -> Plan {
    match arguments.first().map(String::as_str) {
        // Not in the program that the other commands are run with.
        Some("listen") => Plan::Stage(SOUND_CARD),
        Some("store") if arguments.get(1).is_some_and(|word| word == "receive") => {
            Plan::Stage(GATEWAY)
        }
        Some("store" | "trends" | "plant") => Plan::Stage(PLANT),
        Some("gateway") => Plan::Stage(GATEWAY),
        _ => Plan::Rarma(arguments),
    }
}

/// What is done with the Python package.
fn python(program: &str, words: &[String]) -> Result<Plan, String> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match (program, &words[..]) {
        ("maturin", ["build", ..]) | ("python3", ["-m", "venv" | "pip", ..]) => {
            Ok(Plan::Stage("python"))
        }
        ("python3", [script, ..]) if script.starts_with("rarma-py/") => match *script {
            "rarma-py/benchmark.py" => {
                Ok(Plan::Not("it measures times, which wants a machine alone"))
            }
            "rarma-py/notebooks/run.py" | "rarma-py/compare" | "rarma-py/compare/several.py" => {
                Ok(Plan::Stage("python"))
            }
            _ => Err(format!("`{script}`: no such script")),
        },
        _ => Err(format!(
            "`{program} {}` is not known here",
            words.first().unwrap_or(&"")
        )),
    }
}

/// Arguments of `rarma` behind `cargo run`.
fn program(words: &[String]) -> Result<Vec<String>, String> {
    let form = "`cargo run` must have the form `cargo run --release -p rarma-cli -- COMMAND`, or with `--features sound-card` before `-- listen`";
    let split = words.iter().position(|word| word == "--").ok_or(form)?;
    let (ours, rest) = words.split_at(split);
    let arguments = rest.get(1..).unwrap_or_default().to_vec();
    let (usual, more) = ours.split_at(ours.len().min(3));
    let listens = arguments.first().is_some_and(|word| word == "listen");
    let features: &[&str] = if listens {
        &["--features", "sound-card"]
    } else {
        &[]
    };
    if usual != ["--release", "-p", "rarma-cli"] || more != features {
        return Err(form.to_owned());
    }
    Ok(arguments)
}

fn tests(words: &[String]) -> Result<Tests, String> {
    let mut out = Tests::default();
    let (mut release, mut library, mut passed_on) = (false, false, false);
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        let mut value = || {
            words
                .next()
                .map(str::to_owned)
                .ok_or(format!("`{word}` without a value"))
        };
        match word {
            "--" if !passed_on => passed_on = true,
            "--release" if !passed_on => release = true,
            "-p" | "--package" if !passed_on => out.package = value()?,
            "--test" if !passed_on => out.files.push(value()?),
            "--lib" if !passed_on => library = true,
            "--features" if !passed_on => {
                out.features.extend(value()?.split(',').map(str::to_owned));
            }
            "--ignored" if passed_on => out.ignored = true,
            "--nocapture" if passed_on => {}
            "--test-threads" if passed_on => drop(value()?),
            option if option.starts_with('-') => {
                return Err(format!("`cargo test` with `{option}` is not known here"));
            }
            filter if out.filter.is_none() => out.filter = Some(filter.to_owned()),
            second => return Err(format!("a second filter `{second}`")),
        }
    }
    if !release {
        return Err("`cargo test` without `--release`: the checks build no other".to_owned());
    }
    if out.package.is_empty() || library != out.files.is_empty() {
        return Err("name a package and its `--lib` or `--test NAME`".to_owned());
    }
    Ok(out)
}

fn bench(words: &[String]) -> Result<String, String> {
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["-p", "host-tests", "--bench", name] => Ok(name.to_owned()),
        _ => Err(
            "`cargo bench` must have the form `cargo bench -p host-tests --bench NAME`".to_owned(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::commands::shell;

    fn plan(text: &str) -> Result<Plan, String> {
        let alias = |name: &str, own: &str| {
            (
                name.to_owned(),
                format!("run --quiet --package xtask -- {own}"),
            )
        };
        let known = Known {
            aliases: [
                alias("demo", "demo"),
                alias("verify", "verify"),
                alias("fw", "fw"),
                (
                    "xtask".to_owned(),
                    "run --quiet --package xtask -- ".to_owned(),
                ),
            ]
            .into(),
        };
        let line = shell::parse(text).expect("sound");
        known.plan(&line.pipelines[0][0])
    }

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn the_program_by_both_names() {
        let want = Ok(Plan::Rarma(words("psd my.wav --method welch")));
        assert_eq!(plan("rarma psd my.wav --method welch"), want);
        let long = "cargo run --release -p rarma-cli -- psd my.wav --method welch";
        assert_eq!(plan(long), want);
    }

    #[test]
    fn what_others_do_and_what_nobody_can() {
        for (text, stage) in [
            ("cargo fw build", "firmware image"),
            ("cargo fw build nucleo-g474re", "board image"),
            ("cargo fw test", "on-target tests"),
            ("cargo xtask count", "instruction counts"),
            ("cargo xtask chip", "board figures"),
            ("cargo xtask web --serve", "browser page"),
            ("cargo xtask book --serve", "book"),
            ("cargo xtask gallery", "book"),
            ("rarma listen --list", "sound card"),
            (
                "cargo run --release -p rarma-cli --features sound-card -- listen --rpm 1656",
                "sound card",
            ),
            ("maturin build --release", "python"),
            ("python3 -m pip install rarma.whl", "python"),
            ("python3 rarma-py/notebooks/run.py", "python"),
            ("python3 rarma-py/compare", "python"),
            ("python3 rarma-py/compare/several.py", "python"),
        ] {
            assert_eq!(plan(text), Ok(Plan::Stage(stage)), "{text}");
            let there = crate::verify::stages::ALL
                .iter()
                .any(|(name, _)| *name == stage);
            assert!(there, "no stage {stage}");
        }
        for text in [
            "cargo verify",
            "cargo fw run nucleo-g474re",
            "cargo fw run",
            "cargo xtask gallery --against HEAD~1",
        ] {
            assert!(matches!(plan(text), Ok(Plan::Not(_))), "{text}");
        }
        assert_eq!(plan("cargo demo"), Ok(Plan::Own(words("demo"))));
        let whole_box = plan("cargo fw run mps2-an386 --bin mps2-an386-box");
        assert!(
            matches!(whole_box, Ok(Plan::EmulatedBox(_))),
            "{whole_box:?}"
        );
    }

    #[test]
    fn tests_of_a_file_and_of_a_library() {
        let found = plan(
            "cargo test --release -p host-tests --test health --test a -- --ignored --nocapture --test-threads 1 million",
        );
        let want = Tests {
            package: "host-tests".to_owned(),
            files: words("health a"),
            filter: Some("million".to_owned()),
            ignored: true,
            features: Vec::new(),
        };
        assert_eq!(found, Ok(Plan::Tests(want)));
        let found =
            plan("cargo test --release -p rarma-fit --features channels --lib arx -- --nocapture");
        let Ok(Plan::Tests(found)) = found else {
            panic!("{found:?}")
        };
        assert!(found.files.is_empty() && found.filter.as_deref() == Some("arx"));
        assert_eq!(found.features, ["channels"]);
    }

    #[test]
    fn an_unknown_form_is_refused() {
        for text in [
            "ls",
            "cargo",
            "cargo frobnicate",
            "cargo run -p rarma-cli -- demo",
            "cargo run --release -p xtask -- demo",
            "cargo run --release -p rarma-cli -- listen",
            "cargo run --release -p rarma-cli --features sound-card -- demo",
            "cargo test -p host-tests --test health",
            "cargo test --release --test health",
            "cargo test --release -p host-tests",
            "cargo test --release -p host-tests --test health -- --skip a",
            "cargo bench",
            "cargo fw flash",
            "cargo fw build no-board",
            "cargo xtask frobnicate",
            "maturin publish",
            "python3 -m http.server",
            "python3 rarma-py/no-such.py",
        ] {
            assert!(plan(text).is_err(), "{text}: {:?}", plan(text));
        }
    }
}
