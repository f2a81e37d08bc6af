//! The loaded double ball bar: from pressures and gauge readings to the errors of a
//! machine and its stiffness in every direction, and the sequence that gets them.
//!
//! The bar stands between a ball in the spindle and one on the table. A pneumatic cylinder
//! in it pushes the two apart while the machine runs a circle about the table's ball, and
//! a gauge reads how much longer the bar has become. Slow path (once a millisecond or
//! less); works on borrowed slices and fixed bins, allocates nothing, refuses with a
//! reason ([`LdbbError`]).
//!
//! * [`ForceLaw`], pressure to force and its calibration; [`Setting`], what an
//!   inclined bar needs;
//! * [`Trace`], one run as means in fixed bins of angle; [`AngleMap`], time to angle from
//!   both triggers;
//! * [`ErrorFit`], the machine errors of a circle by least squares, with covariance;
//!   [`spikes`], what happens at reversals; [`Deviation`], circular deviation and hysteresis;
//! * [`StiffnessMap`], compliance in every direction by regression on force,
//!   [`Harmonics`], the same smoothed; [`LoadCycle`], hysteresis of a load cycle;
//! * [`ValveLoop`], the pressure; [`Procedure`], the sequence of a whole
//!   test, [`Standing`], that of the static one.
//!
//! Signs and words: θ runs from +X towards +Y (of the plane that is measured); d = +1
//! counter-clockwise, −1 clockwise; Δr > 0 is a longer bar; *deflection*, Δr at a load less
//! that at the smallest; *compliance* c = dΔr/dF, m/N; *stiffness* k = 1/c; *feed*, speed
//! of the spindle along the circle, m/s.

mod deviation;
mod error;
mod error_fit;
mod force;
mod harmonics;
mod hysteresis;
mod inclination;
mod procedure;
mod procedure_config;
mod procedure_event;
mod recorder;
mod reversals;
mod schedule;
mod spikes;
mod standing;
mod stiffness;
mod terms;
mod trace;
mod valve;

pub use deviation::{Deviation, bidirectional, circular_deviation};
pub use error::LdbbError;
pub use error_fit::{ErrorFit, MachineErrors, Measured};
pub use force::{ForceCalibration, ForceLaw, HOLDING_N};
pub use harmonics::Harmonics;
pub use hysteresis::LoadCycle;
pub use inclination::{BarSet, Inclination, Setting};
pub use procedure::{Asked, Procedure, Seen, Stage};
pub use procedure_config::ProcedureConfig;
pub use procedure_event::{Event, Proof, RunDone, RunFault};
pub use recorder::{Beside, CELLS, Recorder};
pub use reversals::Reversals;
pub use schedule::{MAX_PRESSURES, Run, Schedule};
pub use spikes::{Spike, spikes};
pub use standing::{Held, Standing, StandingConfig, StandingEvent};
pub use stiffness::{Direction, StiffnessMap};
pub use terms::{Circle, MAX_TERMS, Sense, Terms};
pub use trace::{AngleMap, Trace};
pub use valve::{ValveConfig, ValveLoop, ValveOut};
