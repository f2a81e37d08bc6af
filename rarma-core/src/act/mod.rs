//! From advice to an order: what may be ordered of a controller, when, and when it is given
//! back.
//!
//! Slow path, some fifty times a second. [`Policy`] is a state machine that is told what the
//! controller reports, whether it chatters, and which speeds are proposed; it answers with what
//! to order. It knows no controller and does no input or output, so that every fault can be
//! played to it.
//!
//! Glossary: *override*, the speed over the programmed one, 1 = 100 %, as the controller shows it;
//! *operator's own*, what the operator has set on his panel; *give back*, return to what was in
//! force before the first order; *leave*, order nothing and change nothing; *barred*, nothing is
//! ordered until the next program starts.

mod config;
mod lever;
mod policy;
#[cfg(test)]
mod tests;
mod told;

pub use config::{ActConfig, ActError};
pub use policy::Policy;
pub use told::{ActOrder, Overrides, Reading, Said, Step, Why};
