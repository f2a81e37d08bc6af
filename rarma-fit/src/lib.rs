//! Models from a whole series of samples at once, where `rarma-core` has a new one at each.
//!
//! Rate: slow path, on the host or once per command; everything works on borrowed
//! slices with arrays of a capacity given as a const generic (`N` ≥ p + q) and the
//! order as a value. Nothing allocates, nothing panics; every refusal names its
//! cause ([`FitError`]). Pass series with their mean removed ([`mean`]).
//!
//! * autoregressive: [`yule_walker`], [`burg`], [`geometric_lattice`],
//!   [`covariance`], [`modified_covariance`], and [`instrumental_variables`] for
//!   the autoregressive part of an ARMA model;
//! * the response to a known input: [`arx`], least squares; [`arx_instruments`], for
//!   noise on the output;
//! * lines, closer than the Fourier transform resolves: [`esprit`], poles from the
//!   signal subspace; [`tones`], exact likelihood of undamped ones;
//! * moving average: [`innovations_algorithm`];
//! * ARMA: [`Pem`], conditional prediction error, for records; [`Ml`], exact
//!   likelihood, for short series;
//! * what is possible: [`Bound`]; which order: [`Criteria`], [`stabilise`]; is anything left
//!   over: [`Whiteness`];
//! * power spectral density: [`model_density`], [`welch_density`], [`windowed_density`];
//! * linear least squares, one row at a time: [`Triangle`];
//! * several sensors at once, with mode shapes: `Subspace`, and at every sample with shared poles
//!   `RecursiveChannels`; with the feature `channels`, which allocates.
//!
//! Words: *residual*, the one-step prediction error of the fitted model;
//! *reflection coefficient*, the last coefficient of the model of each order;
//! *instrument*, a signal correlated with the output but not with the noise.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

#[cfg(feature = "channels")]
extern crate alloc;

mod ar;
mod arx;
mod arx_fit;
mod before;
mod block;
mod bound;
#[cfg(feature = "channels")]
mod channels;
mod columns;
mod criteria;
mod delta;
mod density;
mod eigen;
mod error;
mod fit;
mod instruments;
mod kalman;
mod lattice;
mod levenberg;
mod ml;
mod moving_average;
mod pem;
mod polynomial;
mod prediction;
mod regression;
mod series;
mod stabilisation;
mod starts;
mod subspace;
mod tones;
mod triangle;
mod whiteness;

#[cfg(test)]
mod ar_tests;
#[cfg(test)]
mod arma_tests;
#[cfg(test)]
mod arx_tests;
#[cfg(test)]
mod bench;
#[cfg(test)]
mod lines_tests;

pub use ar::{ArFit, yule_walker};
pub use arx::{arx, arx_instruments};
pub use arx_fit::{ArxFit, ArxOrder, Response};
pub use before::{Before, earlier_errors};
pub use bound::Bound;
#[cfg(feature = "channels")]
pub use channels::{
    ChannelError, ChannelMode, ChannelStatus, ChannelStep, MOST_CHANNELS, MOST_PARAMETERS,
    RecursiveChannels, ShapePart, SharedMode, SharedPart, Subspace, SubspaceConfig, Weights, mac,
};
pub use criteria::Criteria;
pub use delta::PoleDeviation;
pub use density::{model_density, welch_density, windowed_density};
pub use error::FitError;
pub use fit::ArmaFit;
pub use lattice::{burg, geometric_lattice};
pub use ml::{Likelihood, Ml, MlConfig, likelihood};
pub use moving_average::{MaFit, innovations_algorithm};
pub use pem::{Pem, PemConfig};
pub use prediction::Residuals;
pub use regression::{covariance, instrumental_variables, modified_covariance};
pub use series::mean;
pub use stabilisation::{StabilisationConfig, StabilisationError, Stability, stabilise};
pub use subspace::esprit;
pub use tones::{Tone, ToneFit, tones};
pub use triangle::Triangle;
pub use whiteness::Whiteness;

/// Longest autoregression that stands in for an ARMA model at a start.
const LONGEST_AR: usize = 256;
