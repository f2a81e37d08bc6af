//! `rarma`: listens to machine tools.

use rarma_cli::Failure;
use rarma_cli::args::Cli;
use rarma_cli::output::stdout;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    match ended() {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            if failure != Failure::Closed {
                let _ = writeln!(std::io::stderr(), "rarma: {failure}");
            }
            ExitCode::from(failure.code())
        }
    }
}

/// The command's exit code, once the last line it said has left.
fn ended() -> Result<u8, Failure> {
    let code = match Cli::read(std::env::args_os()) {
        Ok(cli) => rarma_cli::commands::run(&cli)?,
        // Help and version are no errors, and are said on standard output.
        Err(said) => {
            let printed = said.print();
            if !said.use_stderr() {
                stdout::wrote(printed)?;
            }
            said.exit_code() as u8
        }
    };
    stdout::end()?;
    Ok(code)
}
