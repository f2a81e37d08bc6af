//! `rarma`: listens to machine tools.

use clap::Parser;
use rarma_cli::args::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    match rarma_cli::commands::run(&Cli::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            eprintln!("rarma: {failure}");
            ExitCode::from(failure.code())
        }
    }
}
