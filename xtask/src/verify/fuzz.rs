//! Every parser under libFuzzer: half a minute each, ten minutes with `--long`.

use std::path::Path;

use super::summary::Outcome;
use crate::fuzz::{Engine, LONG_SECONDS, SECONDS, Table, defects, note, run_all, targets};
use crate::{Failure, Result, Workspace};

/// Every day's runs begin alike, so that one change is judged like the next; the long form
/// begins anywhere.
const SEED: u32 = 1;

/// Builds the program and runs every target; notes the results of the long form in a page, if
/// one is named.
///
/// # Errors
/// The build fails, or a case shows a defect: which, and how to run it again.
pub fn check(workspace: &Workspace, long: bool, markdown: Option<&Path>) -> Result<Outcome> {
    if let Err(failure) = Engine::needs() {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    let engine = Engine::build(workspace)?;
    let seconds = if long { LONG_SECONDS } else { SECONDS };
    let targets = targets(workspace)?;
    let runs = run_all(&engine, &targets, seconds, (!long).then_some(SEED))?;
    println!("{}", Table(&runs));
    if let (true, Some(path)) = (long, markdown) {
        note(workspace, path, &runs)?;
    }
    let found = defects(&runs);
    if found.is_empty() {
        let cases: u64 = runs.iter().map(|run| run.log.cases).sum();
        return Ok(Outcome::Passed(format!(
            "{} targets, {seconds} s each, {cases} cases",
            runs.len()
        )));
    }
    print!("{}", found.join("\n"));
    let names: Vec<&str> = runs
        .iter()
        .filter(|run| run.defect.is_some())
        .map(|run| run.target.as_str())
        .collect();
    Err(
        Failure::new(format!("fuzzing found a defect in {}", names.join(", ")))
            .advise("see above for the cases and how to run them again"),
    )
}
