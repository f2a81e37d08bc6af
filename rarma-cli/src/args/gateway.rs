//! Options of `gateway`.

use clap::Args;
use std::path::PathBuf;

/// Options of `gateway`.
#[derive(Debug, Clone, Args)]
pub struct GatewayArgs {
    /// The gateway's file (TOML): boxes, broker, journal; docs/plant.md has an example.
    pub file: PathBuf,
    /// Read the file, keys and certificates it names, say what is wrong, and go.
    #[arg(long)]
    pub check: bool,
    /// Seconds between two lines that tell how it stands.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = super::every)]
    pub every: f64,
    /// One JSON object a line on standard output.
    #[arg(long)]
    pub json: bool,
}
