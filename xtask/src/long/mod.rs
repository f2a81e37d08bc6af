//! `cargo xtask long`: the tests that take too long for every day, and what became of them.
//!
//! A long form is a test that is `#[ignore]`d and whose name ends with `_long`; the test of
//! that name without the ending judges the same promise in short, every day. Ten minutes of
//! a fuzzing target are one, too ([`crate::fuzz`]). The results stand in a table of
//! docs/bench.md, each row with its own date and commit, so that a run of some of them leaves
//! the others as they were.

mod forms;
mod needs;
pub mod table;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::{Failure, Result, Workspace, page, process};
pub use forms::{Forms, LongForm};
use needs::Needs;
use table::{Became, Row, Table};

/// The page that has the table.
pub const PAGE: &str = "docs/bench.md";

/// A parsed `cargo xtask long` command line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Request {
    /// Only the long forms of these test files; all when empty.
    pub files: Vec<String>,
    /// Only name them.
    pub list: bool,
    /// Write each result into the table of this file as soon as it is there.
    pub markdown: Option<PathBuf>,
    /// Only those that have not passed by the table of that file.
    pub missing: bool,
}

impl Request {
    /// Reads the arguments after `long`.
    ///
    /// # Errors
    /// Names the option that is unknown or lacks its file.
    pub fn parse(arguments: &[String]) -> Result<Self> {
        let mut request = Self::default();
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "--list" => request.list = true,
                "--missing" => request.missing = true,
                "--markdown" => {
                    let file = words.next().map(PathBuf::from);
                    request.markdown =
                        Some(file.ok_or_else(|| Failure::usage("`--markdown` needs a file"))?);
                }
                option if option.starts_with('-') => {
                    return Err(
                        Failure::usage(format!("`long` knows no `{option}`")).advise(
                            "cargo xtask long [--list] [--markdown FILE [--missing]] [TEST...]",
                        ),
                    );
                }
                file => request.files.push(file.to_owned()),
            }
        }
        if request.missing && request.markdown.is_none() {
            return Err(Failure::usage("`--missing` goes with `--markdown`"));
        }
        Ok(request)
    }
}

/// The command `long`.
///
/// # Errors
/// When the tests do not build, one has no short form, or the table cannot be written.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let mut forms = Forms::find(workspace, &request.files)?;
    if let (true, Some(path)) = (request.missing, &request.markdown) {
        let table = table_of(path)?;
        forms.long.retain(|form| !table.passed(&form.name()));
    }
    if request.list {
        for form in &forms.long {
            println!("{}", form.name());
        }
        return Ok(0);
    }
    let bench = |_: &mut Command| {};
    let failed = run_all(workspace, &forms, request.markdown.as_deref(), &bench)?;
    println!("{} of {} failed", failed.len(), forms.long.len());
    Ok(u8::from(!failed.is_empty()))
}

/// Runs long forms one after the other, and notes each in the table of a page, if one is
/// named; `prepare` may add variables. Returns the names of those that failed.
///
/// # Errors
/// When one cannot be started, or the table cannot be written.
pub fn run_all(
    workspace: &Workspace,
    forms: &Forms,
    markdown: Option<&Path>,
    prepare: &dyn Fn(&mut Command),
) -> Result<Vec<String>> {
    let mut failed = Vec::new();
    let mut needs = Needs::default();
    for form in &forms.long {
        let mut cargo = process::host_cargo(workspace);
        cargo.args(form.arguments());
        needs.tell(workspace, form, &mut cargo);
        prepare(&mut cargo);
        println!("\n{}", process::spelled(&cargo));
        let begun = Instant::now();
        let passed = process::status(&mut cargo)?.success();
        if !passed {
            failed.push(form.name());
        }
        if let Some(path) = markdown {
            let seconds = begun.elapsed().as_secs_f64();
            note(workspace, path, &form.name(), passed, seconds)?;
        }
    }
    Ok(failed)
}

/// Writes one result into the table of a page, in the place of that name's last one.
///
/// # Errors
/// When git or `date` say nothing, or the page has no such table.
pub fn note(
    workspace: &Workspace,
    path: &Path,
    name: &str,
    passed: bool,
    seconds: f64,
) -> Result<()> {
    let row = Row {
        name: name.to_owned(),
        became: if passed {
            Became::Passed
        } else {
            Became::Failed
        },
        seconds: seconds.round(),
        date: line(Command::new("date").args(["-u", "+%Y-%m-%d"]))?,
        commit: commit(workspace)?,
    };
    let mut table = table_of(path)?;
    table.put(row);
    let text = table.written_into(&page::read(path)?).map_err(|why| {
        Failure::new(format!("cannot put the result into {}", path.display())).because(why)
    })?;
    page::write(path, &text)
}

fn table_of(path: &Path) -> Result<Table> {
    Table::found_in(&page::read(path)?).map_err(|why| {
        Failure::new(format!("no results of long forms in {}", path.display())).because(why)
    })
}

/// Fails unless each of these long forms passed when it ran last, by the table of [`PAGE`],
/// or stands there as one that has not been run yet; names those.
///
/// # Errors
/// Names each that has no result or failed, and each result of a long form that is gone.
pub fn check(workspace: &Workspace, names: &[String]) -> Result<Vec<String>> {
    let table = table_of(&workspace.root().join(PAGE))?;
    let objections = table.objections(names);
    if objections.is_empty() {
        return Ok(table.not_run().map(str::to_owned).collect());
    }
    Err(Failure::new(format!("long forms are not as {PAGE} says"))
        .because(format!("\n  {}", objections.join("\n  ")))
        .advise(format!(
            "cargo xtask long --markdown {PAGE} --missing; \
             of fuzzing: cargo xtask fuzz TARGET --markdown {PAGE}"
        )))
}

/// The commit that is checked out; a `+` behind it says that sources differ from it.
fn commit(workspace: &Workspace) -> Result<String> {
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        command.current_dir(workspace.root()).args(arguments);
        process::output(&mut command)
    };
    let commit = git(&["rev-parse", "--short", "HEAD"])?;
    // The page itself changes with every result.
    let changed = git(&[
        "status",
        "--porcelain",
        "--untracked-files=no",
        "--",
        "*.rs",
        "*.toml",
    ])?;
    let plus = if changed.trim().is_empty() { "" } else { "+" };
    Ok(format!("{}{plus}", commit.trim()))
}

fn line(command: &mut Command) -> Result<String> {
    Ok(process::output(command)?.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Request> {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        Request::parse(&words)
    }

    #[test]
    fn reads_files_and_options() {
        let request = parse("health --markdown a.md tracking --list").expect("valid");
        assert_eq!(request.files, ["health", "tracking"]);
        assert_eq!(request.markdown, Some("a.md".into()));
        assert!(request.list);
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        assert!(parse("--markdown").is_err_and(|why| why.exit_code() == 2));
        assert!(parse("--fast").is_err_and(|why| why.exit_code() == 2));
        assert!(parse("--missing").is_err_and(|why| why.exit_code() == 2));
    }
}
