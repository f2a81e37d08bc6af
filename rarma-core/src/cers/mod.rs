//! The exciter: an active magnetic bearing that shakes a turning spindle.
//!
//! Arithmetic only; timing and switches are the firmware's, magnets and spindles the
//! simulator's.
//!
//! * [`Geometry`], what a magnet is made of and what it can do;
//! * [`Magnet`] and [`AxisForce`], force from measured currents and the momentary gap;
//!   [`calibrate`], their constants from measured pairs; [`Eddy`], the lag of the flux;
//! * [`Regulator`], the current of one coil; [`GapSchedule`], its gain with the gap.

mod calibration;
mod current;
mod design;
mod eddy;
mod error;
mod force;
mod schedule;

pub use calibration::{Calibration, CalibrationConfig, ForcePair, calibrate};
pub use current::{Drive, Regulator, RegulatorConfig, RegulatorError, Tuning};
pub use design::{Geometry, Linear, MU_0};
pub use eddy::Eddy;
pub use error::CersError;
pub use force::{AxisForce, Force, Magnet, TRUSTED_PART};
pub use schedule::GapSchedule;
