//! `cargo xtask fuzz`: the targets of `fuzz/` under libFuzzer, on all cores.
//!
//! The program is built with the coverage counters of LLVM, which a stable compiler has
//! (`-C passes=sancov-module`), and with libFuzzer from source, which takes a C++ compiler.
//! What is found is kept in `target/fuzz/TARGET`, and is where the next run begins.

mod engine;
mod log;

pub use engine::{Engine, TIMEOUT_S};
pub use log::Log;

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use std::{fmt, fs};

use crate::side_by_side::side_by_side;
use crate::{Failure, Result, Workspace, long};

const USAGE: &str = "cargo xtask fuzz [--seconds N | --markdown FILE] [--seed N] [TARGET...], or cargo xtask fuzz TARGET --case FILE, or cargo xtask fuzz --list";

/// How long each target runs, s: always, and in the long form.
pub const SECONDS: u64 = 30;
/// See [`SECONDS`].
pub const LONG_SECONDS: u64 = 600;

/// A parsed `cargo xtask fuzz` command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    targets: Vec<String>,
    seconds: Option<u64>,
    markdown: Option<PathBuf>,
    seed: Option<u32>,
    case: Option<PathBuf>,
    list: bool,
}

impl Request {
    /// Reads the arguments after `fuzz`.
    ///
    /// # Errors
    /// Names the option that is unknown or lacks what it needs.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let usage = |what: String| Failure::usage(what).advise(USAGE);
        let mut request = Self {
            targets: Vec::new(),
            seconds: None,
            markdown: None,
            seed: None,
            case: None,
            list: false,
        };
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            let mut value = || {
                words
                    .next()
                    .ok_or_else(|| usage(format!("`{word}` needs a value")))
            };
            let number = |text: &String| {
                text.parse::<u32>()
                    .map_err(|_| usage(format!("`{text}` is not a number")))
            };
            match word.as_str() {
                "--seconds" => request.seconds = Some(number(value()?)?.max(1).into()),
                "--markdown" => request.markdown = Some(value()?.into()),
                "--seed" => request.seed = Some(number(value()?)?),
                "--case" => request.case = Some(value()?.into()),
                "--list" => request.list = true,
                option if option.starts_with('-') => {
                    return Err(usage(format!("`fuzz` knows no `{option}`")));
                }
                target => request.targets.push(target.to_owned()),
            }
        }
        if request.case.is_some() && request.targets.len() != 1 {
            return Err(usage("a case is one target's".to_owned()));
        }
        if request.markdown.is_some() && request.seconds.is_some() {
            let what = format!("`--markdown` notes runs of {LONG_SECONDS} s");
            return Err(usage(what));
        }
        Ok(request)
    }
}

/// The command `fuzz`.
///
/// # Errors
/// When the arguments are wrong, or the program cannot be built or started.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let known = targets(workspace)?;
    if request.list {
        println!("{}", known.join("\n"));
        return Ok(0);
    }
    if let Some(wrong) = request.targets.iter().find(|name| !known.contains(name)) {
        return Err(Failure::usage(format!("no target `{wrong}`"))
            .advise(format!("there are {}", known.join(", "))));
    }
    let engine = Engine::build(workspace)?;
    if let (Some(case), [target]) = (&request.case, &request.targets[..]) {
        return engine.again(target, case);
    }
    let chosen = if request.targets.is_empty() {
        known
    } else {
        request.targets
    };
    let usual = request.markdown.as_ref().map_or(SECONDS, |_| LONG_SECONDS);
    let seconds = request.seconds.unwrap_or(usual);
    let runs = run_all(&engine, &chosen, seconds, request.seed)?;
    println!("{}", Table(&runs));
    if let Some(path) = &request.markdown {
        note(workspace, path, &runs)?;
    }
    let found = defects(&runs);
    print!("{}", found.join("\n"));
    Ok(u8::from(!found.is_empty()))
}

/// The names of the targets: each has a folder of cases.
///
/// # Errors
/// The folder of the corpus cannot be read.
pub fn targets(workspace: &Workspace) -> Result<Vec<String>> {
    let folder = workspace.root().join("fuzz/corpus");
    let unreadable = |why| Failure::new(format!("cannot read {}", folder.display())).because(why);
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder).map_err(unreadable)? {
        names.push(
            entry
                .map_err(unreadable)?
                .file_name()
                .to_string_lossy()
                .into_owned(),
        );
    }
    names.sort();
    Ok(names)
}

/// The name of a target's long form in the table of all.
pub fn long_form(target: &str) -> String {
    format!("fuzzing::{target}")
}

/// Writes what came of long runs into the table of a page, each target's in the place of its
/// last one.
///
/// # Errors
/// The page has no such table, or cannot be written.
pub fn note(workspace: &Workspace, path: &Path, runs: &[Run]) -> Result<()> {
    for run in runs {
        let seconds = run.log.seconds.unwrap_or(0) as f64;
        let passed = run.defect.is_none();
        long::note(workspace, path, &long_form(&run.target), passed, seconds)?;
    }
    Ok(())
}

/// What came of one target.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The target.
    pub target: String,
    /// What its log says.
    pub log: Log,
    /// The case that shows a defect, and the file of its log; none if there is none.
    pub defect: Option<(PathBuf, PathBuf)>,
}

/// Runs every target for so long, as many at once as there are cores.
///
/// # Errors
/// A run cannot be started, or ended without a case and without success.
pub fn run_all(
    engine: &Engine,
    targets: &[String],
    seconds: u64,
    seed: Option<u32>,
) -> Result<Vec<Run>> {
    let seed = seed.unwrap_or_else(|| {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        now.map_or(1, |since| since.subsec_nanos().max(1))
    });
    let runs = side_by_side(targets, |target| engine.run(target, seconds, seed));
    let mut runs = runs.into_iter().collect::<Result<Vec<Run>>>()?;
    runs.sort_by(|a, b| a.target.cmp(&b.target));
    Ok(runs)
}

/// Each defect: what it is, its case, how to run it again, how to keep it.
pub fn defects(runs: &[Run]) -> Vec<String> {
    runs.iter()
        .filter_map(|run| {
            let (case, log) = run.defect.as_ref()?;
            Some(format!(
                "{target}: {what}\n  case: {case}\n  log: {log}\n  seed: {seed}\n  again: cargo xtask fuzz {target} --case {case}\n  once mended, keep it: cp {case} fuzz/corpus/{target}/\n",
                target = run.target,
                what = run.log.why.as_deref().unwrap_or("ended by itself, see its log"),
                case = case.display(),
                log = log.display(),
                seed = run.log.seed.unwrap_or(0),
            ))
        })
        .collect()
}

/// The runs as a table.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a>(pub &'a [Run]);

impl fmt::Display for Table<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "| target | cases a minute | edges: corpus | edges: end | peak MB | defects |\n|---|---|---|---|---|---|"
        )?;
        for run in self.0 {
            let cases = run.log.cases_a_minute();
            writeln!(
                out,
                "| `{}` | {} | {} | {} | {} | {} |",
                run.target,
                cases.map_or("ended at its find".to_owned(), |n| n.to_string()),
                run.log.edges_of_corpus,
                run.log.edges,
                run.log.peak_mb,
                u8::from(run.defect.is_some())
            )?;
        }
        Ok(())
    }
}

/// Where a target keeps what it finds.
fn folder_of(target_dir: &Path, target: &str) -> PathBuf {
    target_dir.join("fuzz").join(target)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Request> {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        Request::parse(&words)
    }

    #[test]
    fn reads_what_it_knows_and_refuses_the_rest() {
        let request = parse("wav --seconds 5 uff --seed 3").expect("valid");
        assert_eq!(request.targets, ["wav", "uff"]);
        assert_eq!((request.seconds, request.seed), (Some(5), Some(3)));
        assert_eq!(parse("").map(|r| r.seconds), Ok(None));
        for wrong in [
            "--seconds",
            "--seconds x",
            "--fast",
            "--case a",
            "a b --case c",
            "--seconds 60 --markdown a.md",
        ] {
            assert!(
                parse(wrong).is_err_and(|why| why.exit_code() == 2),
                "{wrong}"
            );
        }
    }

    #[test]
    fn a_defect_says_how_to_see_it_again_and_how_to_keep_it() {
        let run = Run {
            target: "wav".to_owned(),
            log: Log {
                seed: Some(7),
                why: Some("not one line".to_owned()),
                ..Log::default()
            },
            defect: Some((
                "target/fuzz/wav/crash-1".into(),
                "target/fuzz/wav/log".into(),
            )),
        };
        let [text] = &defects(std::slice::from_ref(&run))[..] else {
            panic!("one defect");
        };
        for part in [
            "wav: not one line",
            "case: target/fuzz/wav/crash-1",
            "seed: 7",
            "cargo xtask fuzz wav --case target/fuzz/wav/crash-1",
            "cp target/fuzz/wav/crash-1 fuzz/corpus/wav/",
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
        assert!(
            defects(&[Run {
                defect: None,
                ..run
            }])
            .is_empty()
        );
    }
}
