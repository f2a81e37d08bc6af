//! Evaluation of loaded ball bar tests, for the commands and for tests of them.

pub mod circularity;
pub mod compare;
pub mod errors;
pub mod evaluate;
pub mod options;
pub mod runs;
pub mod steady;
pub mod stiffness;

pub use evaluate::{Findings, evaluate};
pub use options::Options;
pub use runs::{from_recorded, without_its_other};
