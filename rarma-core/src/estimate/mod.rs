//! Models from samples, a new one at each.
//!
//! Words: *innovation*, the one-step prediction error e; *gradient* ψ, minus its
//! derivative by the parameters; *forgetting* λ, the weight of a sample relative
//! to the next; *random walk*, the variance by which parameters are allowed to
//! wander between samples.

mod bounded;
mod config;
mod iv;
mod rarma;
mod running_whiteness;
pub mod schur;
mod state;
mod status;

pub use crate::ud::UdFactors;
pub use crate::visit::StateVisitor;
pub use bounded::BoundedArma;
pub use config::{ConfigError, Gain, Gradient, RarmaConfig};
pub use iv::{IvConfig, RecursiveIv};
pub use rarma::{Arma21, Arma22, Arma43, Arma44, Arma65, Arma66, Arma87, Arma88, RecursiveArma};
pub use running_whiteness::{RUNNING_LAGS, RunningWhiteness};
pub use status::{Limit, Status, Step};
