//! The exciter: an active magnetic bearing that shakes a turning spindle.
//!
//! Arithmetic only; timing and switches are the firmware's, magnets and spindles the
//! simulator's.
//!
//! * [`Geometry`], what a magnet is made of and what it can do;
//! * [`Magnet`] and [`AxisForce`], force from measured currents and the momentary gap;
//!   [`calibrate`], their constants from measured pairs; [`Eddy`], the lag of the flux;
//! * [`BandNoise`], [`Prbs`], [`multisine`], [`Sweep`], what excites; [`RealFft`], its spectra;
//! * [`ExcitationJob`], [`Source`], [`LineCollector`], a signal on the box and the response by
//!   stepped sine;
//! * [`Frf`], the response to the force by instruments and by the classical estimators;
//! * [`remove_orders`], what repeats with the spindle;
//! * [`Regulator`], the current of one coil; [`GapSchedule`], its gain with the gap.

mod calibration;
mod current;
mod design;
mod eddy;
mod error;
mod excitation;
mod exciter;
mod force;
mod frf;
mod orders;
mod schedule;
mod spectra;

pub use calibration::{Calibration, CalibrationConfig, ForcePair, calibrate};
pub use current::{Drive, Regulator, RegulatorConfig, RegulatorError, Tuning};
pub use design::{Geometry, MU_0};
pub use eddy::Eddy;
pub use error::CersError;
pub use excitation::{
    BandNoise, BandNoiseConfig, Course, Dodge, LineSet, Lines, Phases, Prbs, Sweep, VoltageShape,
    crest_factor, lower_crest, multisine,
};
pub use exciter::{
    BLOCKS, Block, Direction, ExcitationJob, JobField, LineCollector, LineResponse, OutOfReach,
    Reach, Seen, SensorPath, Signal, Source,
};
pub use force::{AxisForce, Force, Linear, Magnet, TRUSTED_PART};
pub use frf::{Frf, FrfLine, Path, Quantity, Window};
pub use orders::remove_orders;
pub use schedule::GapSchedule;
pub use spectra::RealFft;
