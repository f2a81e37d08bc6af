//! The exciter's outside world: four magnets on their amplifiers, a rotor in a structure,
//! sensors.
//!
//! f64, SI. Directions x and y of the machine; coils +x, −x, +y, −y. Knows nothing of the
//! regulator: duty in, readings out.
//!
//! * [`Coil`], one magnet with iron, eddy currents and back-EMF;
//! * [`Structure`], the modes of the thesis' table 3, changing with speed;
//! * [`ExciterPlant`], all of it, period by period of the current loop.

mod coil;
mod rig;
mod sensors;
mod structure;

pub use coil::{Coil, CoilConfig};
pub use rig::{COILS, ExciterConfig, ExciterPlant, Reading, Truth};
pub use sensors::{SensorConfig, Sensors};
pub use structure::{Structure, StructureConfig, TABLE_3_X, TABLE_3_Y, WithSpeed};
