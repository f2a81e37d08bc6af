//! What the command line says of itself.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// Completions.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// Whose.
    pub shell: Shell,
}

/// Pages for `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// Folder for the pages; those of the same name in it are replaced.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}
