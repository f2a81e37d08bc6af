//! What keeps the box and the machine safe: faults, modes, limits, deadlines.
//!
//! Arithmetic and state machines only; no clock, pin or link. Rates: the coil
//! protection runs once a period of the current loop, everything else once a
//! millisecond.

mod fault;
mod mode;

pub use fault::{Class, FaultCode, FaultRecord, KEPT_BYTES, Severity};
pub use mode::{Mode, Stage};
