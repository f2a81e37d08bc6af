//! Modes and mode shapes of several sensors at once: covariance-driven stochastic subspace
//! identification, with the uncertainty of everything it says.
//!
//! Rate: slow path, on a host: this module allocates, in `f64` alone, and is there with the
//! feature `channels` only.
//!
//! ```text
//! R(k) = mean of y(t+k)·y_ref(t)ᵀ          k = 1 … 2·rows − 1
//! H    = [R(i+j+1)],  i, j = 0 … rows−1    block Hankel matrix
//! H    = U S Vᵀ,  O = first n columns of U   observability, up to a basis
//! O↑·A = O↓ (least squares),  C = first rows of O,  A φ = λ φ
//! f = |ln λ|·fs/2π,  ζ = −Re ln λ/|ln λ|,  ψ = C φ
//! ```
//!
//! Source of the method: Peeters and De Roeck, Mechanical Systems and Signal Processing 13
//! (1999). White noise of the sensors enters R(0) only, which is left out. The uncertainty is
//! that of first order of Reynders, Pintelon and De Roeck (2008) in the form of Döhler and Mevel
//! (2013): what each stretch of the record says otherwise than the whole is carried through the
//! decomposition, the eigenvalues and the shapes, stretch by stretch, and no matrix of the size of
//! the covariance of H is ever formed.
//!
//! Words: *reference*, a channel that the others are correlated with; *shape*, what the channels
//! show of a mode, complex, the largest of them 1.

mod config;
mod error;
mod hankel;
mod modes;
mod perturbation;
mod recursive;
mod shape;
mod subspace;
#[cfg(test)]
mod tests;

pub use config::SubspaceConfig;
pub use error::ChannelError;
pub use recursive::{
    ChannelStatus, ChannelStep, MOST_CHANNELS, MOST_PARAMETERS, RecursiveChannels, SharedMode,
    SharedPart, Weights,
};
pub use shape::{ChannelMode, ShapePart, mac};
pub use subspace::Subspace;
