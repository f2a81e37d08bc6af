//! Bars and signs of life on standard error; a browser has none.

#[cfg(not(target_family = "wasm"))]
mod drawn;
#[cfg(target_family = "wasm")]
mod none;

#[cfg(not(target_family = "wasm"))]
pub use drawn::{ProgressBar, progress, waiting};
#[cfg(target_family = "wasm")]
pub use none::{ProgressBar, progress, waiting};
