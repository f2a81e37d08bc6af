//! Listening to machine tools: recursive ARMA identification of the vibration of
//! a cut, at every sample, on a microcontroller.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod act;
pub mod advice;
pub mod condition;
pub mod decide;
pub mod estimate;
pub mod monitor;
mod order;
pub mod real;
pub mod spectrum;
mod ud;
pub mod verdict;
pub use monitor::Monitor;
pub use order::Order;
pub use real::Real;
pub use ud::UdFactors;
