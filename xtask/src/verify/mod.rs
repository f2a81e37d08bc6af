//! `cargo verify [--ci] [--long]`: every check, one after the other but for those that stand on their own (module `beside`), and
//! a table at the end.
//!
//! A check that fails does not stop the others. A check that cannot run on this machine, or
//! only in part, says so with its reason; with `--ci` (or `CI=true`) that is a failure. With
//! `--long` the long forms of tests and of checks run, too, which takes hours.

mod ahead;
mod bench;
mod beside;
mod browser;
mod cargo_deny;
pub mod commands;
pub mod dependencies;
mod fuzz;
mod manifests;
mod on_embassy;
mod packed;
mod plant;
mod plant_gateway;
mod python;
mod spdx;
mod stages;
pub mod summary;

use std::env;
use std::path::PathBuf;
use std::time::Instant;

use crate::{Failure, Result, Workspace, process};
use bench::Bench;
use beside::Beside;
use summary::{Entry, Outcome, Summary};

/// A parsed `cargo verify` command line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Request {
    /// What did not run counts as failed.
    pub ci: bool,
    /// The long forms run, too.
    pub long: bool,
    /// Note the results of the long forms in the table of this file.
    pub markdown: Option<PathBuf>,
    /// Only these checks, in this order; all of them where none is named.
    pub only: Vec<String>,
}

impl Request {
    /// Reads the arguments after `verify`.
    ///
    /// # Errors
    /// Names the option that is unknown or lacks what it needs.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let usage = |what: String| {
            Failure::usage(what)
                .advise("cargo verify [--ci] [--long [--markdown FILE]] [--only CHECK]…")
        };
        let mut request = Self::default();
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "--ci" => request.ci = true,
                "--long" => request.long = true,
                "--markdown" => match words.next() {
                    Some(file) => request.markdown = Some(file.into()),
                    None => return Err(usage("`--markdown` needs a file".to_owned())),
                },
                "--only" => match words.next() {
                    Some(name) if stages::ALL.iter().any(|(known, _)| known == name) => {
                        request.only.push(name.clone());
                    }
                    Some(name) => return Err(usage(format!("no check is called `{name}`"))),
                    None => return Err(usage("`--only` needs the name of a check".to_owned())),
                },
                other => return Err(usage(format!("`verify` knows no `{other}`"))),
            }
        }
        if request.markdown.is_some() && !request.long {
            return Err(usage("`--markdown` goes with `--long`".to_owned()));
        }
        Ok(request)
    }
}

/// The command `verify`.
///
/// # Errors
/// When the arguments are wrong or the table of long forms cannot be written; failed checks
/// are exit code 1, after the table.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let mut request = Request::parse(arguments)?;
    request.ci |= env::var("CI").is_ok_and(|value| value == "true");
    let mut summary = Summary::new(request.ci);
    let only = request.only.clone();
    let all = only.is_empty();
    // The long forms take hours, and are read as they run.
    let apart = all && !request.long;
    let mut bench = Bench::new(workspace, request);
    if all {
        bench.fetching = Some(ahead::begin(workspace));
    }
    let begun = Instant::now();
    for (number, (name, check)) in chosen(&only).enumerate() {
        if apart && beside::CHECKS.contains(name) {
            continue;
        }
        let after = begun.elapsed().as_secs();
        let used = process::processor_s().map(|s| format!(", {s:.0} s of the processor"));
        let used = used.unwrap_or_default();
        println!("\n==> {} {name} (after {after} s{used})", number + 1);
        let begun = Instant::now();
        let outcome =
            check(&mut bench).unwrap_or_else(|failure| Outcome::Failed(failure.to_string()));
        let entry = Entry {
            name,
            outcome,
            seconds: begun.elapsed().as_secs_f32(),
        };
        println!("{}", entry.line());
        summary.add(entry);
        if apart && bench.fetching.is_none() && bench.beside.is_none() {
            bench.beside = Some(Beside::begin(workspace, &bench.request)?);
        }
    }
    if apart {
        let beside = match bench.beside.take() {
            Some(beside) => beside,
            None => Beside::begin(workspace, &bench.request)?,
        };
        println!("\n==> beside these: {}", beside::CHECKS.join(", "));
        let (said, entries) = beside.end();
        println!("{said}");
        entries.into_iter().for_each(|entry| summary.add(entry));
    }
    print!("\n{summary}");
    Ok(u8::from(summary.failed() > 0))
}

/// All checks, or those that are named, in the order in which they are.
fn chosen(only: &[String]) -> impl Iterator<Item = &'static (&'static str, stages::Check)> {
    let named = only
        .iter()
        .filter_map(|name| stages::ALL.iter().find(|(known, _)| known == name));
    let all = only.is_empty().then(|| stages::ALL.iter());
    named.chain(all.into_iter().flatten())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_come_in_the_order_in_which_they_are_named() {
        let names = |only: &[&str]| {
            let only: Vec<String> = only.iter().map(|name| (*name).to_owned()).collect();
            chosen(&only).map(|(name, _)| *name).collect::<Vec<_>>()
        };
        assert_eq!(names(&["python", "format"]), ["python", "format"]);
        assert_eq!(names(&[]).len(), stages::ALL.len());
    }

    fn parse(line: &str) -> Result<Request> {
        parse_words(&line.split_whitespace().collect::<Vec<_>>())
    }

    fn parse_words(words: &[&str]) -> Result<Request> {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        Request::parse(&words)
    }

    #[test]
    fn reads_what_it_knows_and_refuses_the_rest() {
        let request = parse("--long --markdown a.md --ci").expect("valid");
        assert!(request.ci && request.long && request.markdown == Some("a.md".into()));
        assert_eq!(parse(""), Ok(Request::default()));
        let request = parse_words(&["--only", "clippy", "--only", "long forms"]).expect("valid");
        assert_eq!(request.only, ["clippy", "long forms"]);
        for wrong in [
            "--fast",
            "--long --markdown",
            "--markdown a.md",
            "long",
            "--only",
            "--only x",
        ] {
            assert!(
                parse(wrong).is_err_and(|why| why.exit_code() == 2),
                "{wrong}"
            );
        }
    }

    #[test]
    fn checks_have_names_of_their_own() {
        let names: Vec<&str> = stages::ALL.iter().map(|(name, _)| *name).collect();
        for (k, name) in names.iter().enumerate() {
            assert!(!names[..k].contains(name), "{name}");
        }
    }
}
