//! Every command of the pages: each command in a code block for a shell in README.md and docs is
//! run in a scratch folder, or it is known which other stage runs it, or why nobody can.
//!
//! [`pages`] finds the lines, [`shell`] takes them apart, [`plan`] says what is done with a
//! command, [`roles`](crate::inputs::roles) what its arguments are; [`inputs`](crate::inputs) makes stand-ins for a reader's own
//! files, [`run`] runs, `lookup` asks whether named tests exist. What is not known is a failure.

mod lookup;
pub mod pages;
pub mod plan;
pub mod run;
mod runner;
pub mod shell;
mod tally;
mod wanted;
mod yardstick;

use super::bench::Bench;
use super::summary::Outcome;
use crate::{Failure, Result, Workspace, demo, process};
use runner::Runner;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use tally::Tally;

/// The check.
///
/// # Errors
/// Something it needs itself cannot be built, made or read.
pub fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    let workspace = bench.workspace;
    // First what `cargo demo` builds, which is not the demonstration's time.
    let mut demo = process::host_cargo(workspace);
    process::run(demo.args(["build", "--quiet"]).args(demo::PROGRAM))?;
    let rarma = process::rarma(workspace)?;
    let scratch = workspace.target_dir().join("commands");
    let cannot = |why| Failure::new(format!("cannot empty {}", scratch.display())).because(why);
    if scratch.exists() {
        fs::remove_dir_all(&scratch).map_err(cannot)?;
    }
    fs::create_dir_all(&scratch).map_err(cannot)?;
    let mut runner = Runner::new(bench, &rarma, scratch)?;
    let mut tally = Tally::default();
    for page in pages_of(workspace.root())? {
        let path = workspace.root().join(&page);
        let text = fs::read_to_string(&path)
            .map_err(|why| Failure::new(format!("cannot read {page}")).because(why))?;
        match pages::blocks(&page, &text) {
            Err(why) => tally.fail(why),
            Ok(blocks) => {
                for block in blocks {
                    runner.block(&block, &mut tally)?;
                }
            }
        }
    }
    Ok(tally.outcome())
}

/// README.md and every page under docs, by their paths from the root.
fn pages_of(root: &Path) -> Result<Vec<String>> {
    let mut out = vec!["README.md".to_owned()];
    let mut folders = vec![PathBuf::from("docs")];
    while let Some(folder) = folders.pop() {
        let cannot = |why| Failure::new(format!("cannot list {}", folder.display())).because(why);
        for entry in fs::read_dir(root.join(&folder)).map_err(cannot)? {
            let name = entry.map_err(cannot)?.file_name();
            let path = folder.join(name);
            if root.join(&path).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                out.push(path.display().to_string());
            }
        }
    }
    out.sort();
    Ok(out)
}

/// Aliases of cargo in this workspace.
fn aliases(workspace: &Workspace) -> Result<BTreeMap<String, String>> {
    let path = workspace.root().join(".cargo/config.toml");
    let cannot = |why: String| Failure::new(format!("cannot read {}", path.display())).because(why);
    let text = fs::read_to_string(&path).map_err(|why| cannot(why.to_string()))?;
    let config: toml::Table = text.parse().map_err(|_| cannot("not TOML".to_owned()))?;
    let aliases = config.get("alias").and_then(toml::Value::as_table);
    Ok(aliases
        .into_iter()
        .flatten()
        .filter_map(|(name, line)| Some((name.clone(), format!("{} ", line.as_str()?))))
        .collect())
}

/// The commands that README.md's table of exit codes names for 1.
fn may_end_with_one(workspace: &Workspace) -> Result<Vec<String>> {
    let path = workspace.root().join("README.md");
    let text = fs::read_to_string(&path)
        .map_err(|why| Failure::new("cannot read README.md").because(why))?;
    let row = text.lines().find(|line| line.starts_with("| 1 |"));
    let row = row.ok_or_else(|| Failure::new("README.md has no line for the exit code 1"))?;
    Ok(row
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::plan::Known;
    use super::*;

    #[test]
    fn every_command_of_the_pages_is_known() {
        let workspace = Workspace::locate().expect("the workspace");
        let known = Known {
            aliases: aliases(&workspace).expect("aliases"),
        };
        let mut count = 0;
        for page in pages_of(workspace.root()).expect("pages") {
            let text = fs::read_to_string(workspace.root().join(&page)).expect("a page");
            let blocks = pages::blocks(&page, &text).unwrap_or_else(|why| panic!("{why}"));
            for (number, text) in blocks.iter().flat_map(|block| &block.lines) {
                let line =
                    shell::parse(text).unwrap_or_else(|why| panic!("{page}:{number}: {why}"));
                assert_eq!(line.commented(), None, "{page}:{number}");
                for step in line.pipelines.iter().flatten() {
                    if let Err(why) = known.plan(step) {
                        panic!("{page}:{number}: {step}: {why}");
                    }
                    count += 1;
                }
            }
        }
        assert!(count > 50, "{count} commands only: are the blocks found?");
    }

    #[test]
    fn what_may_end_with_one_stands_in_the_readme() {
        let workspace = Workspace::locate().expect("the workspace");
        let one = may_end_with_one(&workspace).expect("a row");
        for command in ["monitor", "advise", "act", "target", "box"] {
            assert!(one.iter().any(|name| name == command), "{one:?}");
        }
    }
}
