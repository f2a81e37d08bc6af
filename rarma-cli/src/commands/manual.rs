//! `rarma completions` and `rarma man`: what the command line says of itself, for a shell and
//! for `man`.

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Failure;
use crate::output;
use crate::output::stdout;
use clap::Command;
use std::io::Write;
use std::path::Path;

/// Completions for a shell, on standard output.
///
/// # Errors
/// It cannot be written.
pub(super) fn completions(args: &CompletionsArgs) -> Result<u8, Failure> {
    // The generator ends the program where it cannot write: it is given memory.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command_line(), "rarma", &mut script);
    stdout::wrote(stdout::Stdout.write_all(&script))?;
    Ok(0)
}

/// A page for each command into a folder.
///
/// # Errors
/// The folder or a page cannot be written.
pub(super) fn man(args: &ManArgs) -> Result<u8, Failure> {
    output::folder(&args.out)?;
    let mut command = Cli::command_line().disable_help_subcommand(true);
    command.build();
    let pages = pages(&command, &args.out)?;
    say!("{pages} pages in {}", args.out.display());
    Ok(0)
}

/// The page of a command and those of the commands below it; how many.
fn pages(command: &Command, folder: &Path) -> Result<usize, Failure> {
    let man = clap_mangen::Man::new(command.clone());
    let file = folder.join(man.get_filename());
    let mut bytes = Vec::new();
    man.render(&mut bytes)
        .map_err(|why| output::failed(&file, "write", &why))?;
    output::write(&file, &bytes)?;
    let mut count = 1;
    for sub in command.get_subcommands() {
        count += pages(sub, folder)?;
    }
    Ok(count)
}
