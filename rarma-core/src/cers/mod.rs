//! The exciter: an active magnetic bearing that shakes a turning spindle.

mod current;

pub use current::{Drive, Regulator, RegulatorConfig, RegulatorError, Tuning};
