//! `cargo verify [--ci] [--long]`: every check, one after the other, and a table at the end.
//!
//! A check that fails does not stop the others. A check that cannot run on this machine
//! is skipped with its reason; with `--ci` (or `CI=true`) a skip is a failure.

pub mod commands;
pub mod dependencies;
mod spdx;
mod stages;
pub mod summary;

use std::env;
use std::time::Instant;

use crate::{Failure, Result, Workspace};
use stages::Bench;
use summary::{Entry, Outcome, Summary};

/// The command `verify`.
///
/// # Errors
/// When the arguments are wrong; failed checks are exit code 1, after the table.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let mut ci = env::var("CI").is_ok_and(|value| value == "true");
    let mut long = false;
    for word in arguments {
        match word.as_str() {
            "--ci" => ci = true,
            "--long" => long = true,
            other => {
                return Err(Failure::usage(format!("`verify` knows no `{other}`"))
                    .advise("cargo verify [--ci] [--long]"));
            }
        }
    }
    let mut bench = Bench::new(workspace, ci, long);
    let mut summary = Summary::new(ci);
    for (number, (name, check)) in stages::ALL.iter().enumerate() {
        println!("\n==> {}/{} {name}", number + 1, stages::ALL.len());
        let begun = Instant::now();
        let outcome =
            check(&mut bench).unwrap_or_else(|failure| Outcome::Failed(failure.to_string()));
        println!("<== {name}: {outcome}");
        summary.add(Entry {
            name,
            outcome,
            seconds: begun.elapsed().as_secs_f32(),
        });
    }
    print!("\n{summary}");
    Ok(u8::from(summary.failed() > 0))
}
