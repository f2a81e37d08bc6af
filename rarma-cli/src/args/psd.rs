//! Options of `psd`, and criteria of `order`.

use super::convert::unit;
use super::{BandArgs, InputArgs, any_order, positive};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `psd`.
#[derive(Debug, Clone, Args)]
pub struct PsdArgs {
    /// The recording.
    #[command(flatten)]
    pub input: InputArgs,
    /// Estimator.
    #[arg(long, value_enum)]
    pub method: PsdMethod,
    /// Orders of A and C for a model, 0 to 30 each.
    #[arg(long, value_name = "P,Q", value_parser = any_order)]
    pub order: Option<(usize, usize)>,
    /// Where it looks.
    #[command(flatten)]
    pub band: BandArgs,
    /// At this one frequency in Hz instead of on a grid.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub at: Option<f64>,
    /// Write it to a file: .csv, .uff, .unv (universal file, dataset 58) or .mat (MATLAB level 5).
    #[arg(long, value_name = "FILE", conflicts_with = "at")]
    pub out: Option<PathBuf>,
    /// Unit of the samples, such as m/s^2 [default: what the recording says, else 1, parts of full scale].
    #[arg(long, value_name = "UNIT", value_parser = unit, requires = "out")]
    pub unit: Option<String>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Criteria of `order`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Criterion {
    /// Akaike.
    Aic,
    /// Akaike, corrected for short series.
    Aicc,
    /// Schwarz.
    Bic,
    /// Final prediction error.
    Fpe,
}

impl Criterion {
    /// As it is spelled on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aic => "aic",
            Self::Aicc => "aicc",
            Self::Bic => "bic",
            Self::Fpe => "fpe",
        }
    }
}

/// Estimators of `psd`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PsdMethod {
    /// Squared Fourier transform of the whole recording.
    Periodogram,
    /// Mean over half-overlapping stretches under a Hann window.
    Welch,
    /// Autoregressive model (Burg); needs --order P,0.
    Ar,
    /// ARMA model (prediction error); needs --order P,Q.
    Arma,
}
