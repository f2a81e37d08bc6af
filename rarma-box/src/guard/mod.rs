//! What keeps the box and the machine safe: faults, modes, limits, deadlines.
//!
//! Arithmetic and state machines only; no clock, pin or link. Everything here runs once
//! a millisecond; the trips that cannot wait are the current loop's.

mod duties;
mod fault;
mod mode;
mod rig;
mod supervisor;
mod watch;

pub use duties::{CheckIns, Duty};
pub use fault::{Class, FaultCode, FaultRecord, KEPT_BYTES, Severity};
pub use mode::{Mode, Stage};
pub use rig::{GAP_TRIP, GAP_WARN, RigCodes, RigCoils, RigLimits, RigSeen, RigState, RigWatch};
pub use supervisor::{
    CALIBRATION_US, Denial, Facts, PRECHARGE_US, Permission, RELEASED_US, Supervisor,
};
pub use watch::{Disobedience, Follows, Heat, InARow, Steady, Still, thermistor_k};
