//! Options of `ldbb`.

use super::{number, within};
use crate::args::OutArgs;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// The commands of `ldbb`.
#[derive(Debug, Clone, Subcommand)]
pub enum LdbbCommand {
    /// A whole test on a simulated machine: valve, sequence, readings, findings.
    Run(LdbbRunArgs),
    /// Readings of a test to machine errors, stiffness all round and hysteresis.
    Analyse(LdbbAnalyseArgs),
    /// Several machines, feeds or inclinations side by side.
    Compare(LdbbCompareArgs),
}

/// What is known beside the readings.
#[derive(Debug, Clone, Args)]
pub struct KnownArgs {
    /// Compliance of the bar and its joints, µm/N, taken off.
    #[arg(long, value_name = "UM_PER_N", default_value_t = 0.0, value_parser = not_negative)]
    pub bar_compliance: f64,
    /// Highest order of the smoothed stiffness, 0 to 6.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u8).range(0..=6))]
    pub smooth: u8,
    /// Standard deviation of the force's gain, percent: every stiffness shares it.
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = not_negative)]
    pub force_sd: f64,
    /// Look for a cyclic error of this pitch, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = not_negative)]
    pub pitch: f64,
    /// Circular deviation that is allowed, µm: compared with G(b), or with G of one direction, at
    /// the smallest force.
    #[arg(long, value_name = "UM", value_parser = crate::args::positive)]
    pub tolerance: Option<f64>,
}

/// Options of `ldbb run`.
#[derive(Debug, Clone, Args)]
pub struct LdbbRunArgs {
    /// A TOML file, or the name of a shipped test.
    #[arg(required_unless_present_any = ["list", "schema"])]
    pub scenario: Option<String>,
    /// Write the readings, one table a run, and the findings into this folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the shipped tests.
    #[arg(long)]
    pub list: bool,
    /// Print the JSON schema of a test's file.
    #[arg(long)]
    pub schema: bool,
    /// What is known beside the readings.
    #[command(flatten)]
    pub known: KnownArgs,
    /// Where results go.
    #[command(flatten)]
    pub show: OutArgs,
}

/// Options of `ldbb analyse`.
#[derive(Debug, Clone, Args)]
pub struct LdbbAnalyseArgs {
    /// Tables of readings, or folders of them.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// What is known beside the readings.
    #[command(flatten)]
    pub known: KnownArgs,
    /// Write the findings, for `rarma ldbb compare`.
    #[arg(long, value_name = "FILE.json")]
    pub save: Option<PathBuf>,
    /// Where results go.
    #[command(flatten)]
    pub show: OutArgs,
}

/// Options of `ldbb compare`.
#[derive(Debug, Clone, Args)]
pub struct LdbbCompareArgs {
    /// Folders that `rarma ldbb run --out` wrote, or files that `analyse --save` wrote.
    #[arg(required = true, num_args = 2..)]
    pub tests: Vec<PathBuf>,
    /// Where results go.
    #[command(flatten)]
    pub show: OutArgs,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let _ = number(text)?;
    within(text, 0.0, 1e3)
}
