//! Options of `cers`.

use super::pair;
use crate::args::OutArgs;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// The commands of `cers`.
#[derive(Debug, Clone, Subcommand)]
pub enum CersCommand {
    /// A whole measurement on the simulated rig: calibration, bias, signal, record, modes.
    Run(CersRunArgs),
    /// A record to responses, modes and tracks.
    Analyse(CersAnalyseArgs),
}

/// What responses are shown and exported as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum KindArg {
    /// Displacement over force, m/N.
    Receptance,
    /// Velocity over force, m/(N·s).
    Mobility,
    /// Acceleration over force, 1/kg.
    Accelerance,
}

/// How a record is read.
#[derive(Debug, Clone, Args)]
pub struct ReadingArgs {
    /// Band of the modes, Hz.
    #[arg(long, value_name = "LO:HI", default_value = "250:3000", value_parser = band)]
    pub band: (f64, f64),
    /// What responses are shown and exported as.
    #[arg(long, value_enum, default_value_t = KindArg::Receptance)]
    pub quantity: KindArg,
    /// Without the two methods in time, which take most of the time.
    #[arg(long)]
    pub quick: bool,
    /// Write the responses as a table, real and imaginary parts, with coherence.
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write the receptances as a universal file (dataset 58).
    #[arg(long, value_name = "FILE.uff")]
    pub uff: Option<PathBuf>,
    /// Write the modes of x and y for `rarma monitor --structure` into this folder.
    #[arg(long, value_name = "DIR")]
    pub structure: Option<PathBuf>,
}

/// Options of `cers run`.
#[derive(Debug, Clone, Args)]
pub struct CersRunArgs {
    /// A TOML file, or the name of a shipped measurement.
    #[arg(required_unless_present_any = ["list", "schema"])]
    pub scenario: Option<String>,
    /// Write the record into this folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the shipped measurements.
    #[arg(long)]
    pub list: bool,
    /// Print the JSON schema of a measurement's file.
    #[arg(long)]
    pub schema: bool,
    /// How the record is read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Where results go.
    #[command(flatten)]
    pub show: OutArgs,
}

/// Options of `cers analyse`.
#[derive(Debug, Clone, Args)]
pub struct CersAnalyseArgs {
    /// A folder with record.toml and signals.wav.
    pub record: PathBuf,
    /// How the record is read.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Where results go.
    #[command(flatten)]
    pub show: OutArgs,
}

fn band(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI, such as 250:3000")?;
    (low >= 20.0 && high >= 1.5 * low && high <= 4500.0)
        .then_some((low, high))
        .ok_or("must lie between 20 and 4500 Hz, the upper edge 1.5 times the lower".to_owned())
}
