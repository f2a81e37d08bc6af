//! Options of `identify` and `order`, and the estimators.

use super::{BandArgs, ChannelArgs, Criterion, InputArgs, forgetting, long_order, random_walk};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `identify`.
#[derive(Debug, Clone, Args)]
pub struct IdentifyArgs {
    /// The recording.
    #[command(flatten)]
    pub input: InputArgs,
    /// Orders of A and C, 0 to 30 each; P to 60 for autoregressive methods.
    #[arg(long, value_name = "P,Q", value_parser = long_order)]
    pub order: (usize, usize),
    /// Estimator.
    #[arg(long, value_enum, default_value_t = Method::Pem)]
    pub method: Method,
    /// Where it looks.
    #[command(flatten)]
    pub band: BandArgs,
    /// What is removed before the fit.
    #[arg(long, value_enum, default_value_t = Detrend::Mean)]
    pub detrend: Detrend,
    /// Forgetting factor per sample, 0.9 to 1.
    #[arg(long, value_name = "LAMBDA", default_value_t = 1.0, value_parser = forgetting)]
    pub forgetting: f64,
    /// Random walk of every parameter, variance per sample, 0 to 0.01.
    #[arg(long, value_name = "VARIANCE", default_value_t = 0.0, value_parser = random_walk)]
    pub random_walk: f64,
    /// Several channels at once.
    #[command(flatten)]
    pub several: ChannelArgs,
    /// Write a page with pictures into this folder: poles over orders, the model's density,
    /// residuals, other methods.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Options of `order`.
#[derive(Debug, Clone, Args)]
pub struct OrderArgs {
    /// The recording.
    #[command(flatten)]
    pub input: InputArgs,
    /// Largest p; candidates are (p, p-1) and (p, p).
    #[arg(long, value_name = "P", default_value_t = 10,
          value_parser = |text: &str| text.parse::<usize>().ok().filter(|p| (1..=30).contains(p)).ok_or("must lie between 1 and 30"))]
    pub max: usize,
    /// Where it looks.
    #[command(flatten)]
    pub band: BandArgs,
    /// What chooses.
    #[arg(long, value_enum, default_value_t = Criterion::Bic)]
    pub criterion: Criterion,
    /// Write a page with pictures into this folder: the stabilisation diagram and the chosen model.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Estimators of `identify`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Prediction error method over the whole series (conditional on its start).
    Pem,
    /// Exact Gaussian maximum likelihood, for short series.
    Ml,
    /// Recursive prediction error method.
    Rpem,
    /// Recursive pseudo-linear regression (extended least squares).
    Rplr,
    /// Recursive normalised gradient: little work a sample, less accurate.
    Gradient,
    /// Recursive instrumental variables for A, innovations algorithm for C.
    Riv,
    /// Instrumental variables for A, innovations algorithm for C.
    Iv,
    /// Burg, autoregressive.
    Burg,
    /// Yule–Walker, autoregressive.
    YuleWalker,
    /// Least squares, autoregressive.
    LeastSquares,
    /// Lattice with geometric-mean reflection coefficients, autoregressive.
    Lattice,
    /// A from the signal subspace, for close tones; C by the innovations algorithm.
    Esprit,
    /// Undamped tones in white noise by maximum likelihood; p is twice their number,
    /// q is p or 0.
    Tones,
}

impl Method {
    /// As it is spelled on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pem => "pem",
            Self::Ml => "ml",
            Self::Rpem => "rpem",
            Self::Rplr => "rplr",
            Self::Gradient => "gradient",
            Self::Riv => "riv",
            Self::Iv => "iv",
            Self::Burg => "burg",
            Self::YuleWalker => "yule-walker",
            Self::LeastSquares => "least-squares",
            Self::Lattice => "lattice",
            Self::Esprit => "esprit",
            Self::Tones => "tones",
        }
    }

    /// Fits A only.
    pub fn is_autoregressive(self) -> bool {
        matches!(
            self,
            Self::Burg | Self::YuleWalker | Self::LeastSquares | Self::Lattice
        )
    }
}

/// What is removed before a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Detrend {
    /// Nothing.
    None,
    /// The mean.
    Mean,
    /// A straight line.
    Linear,
}
