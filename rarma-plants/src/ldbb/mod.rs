//! A machine tool with a loaded ball bar between spindle and table, and the air behind it.
//!
//! * [`machine`] geometric errors by exact geometry (not by the terms that evaluation
//!   fits), deflection, hysteresis, all growing with load;
//! * [`stiffness`] a stiffness all round from a few figures;
//! * [`air`] regulator with dead time and lag, cylinder with a sticking seal, transducer;
//! * [`motion`] the machine's program: in along the radius, the arc, out again, and what
//!   can go wrong with it;
//! * [`mod@bench`] all of it together, a millisecond at a time, [`drive`] a whole test of it.
//!
//! Signs as in [`rarma_rigs::ldbb`]: θ from +X towards +Y, a longer bar is positive.

pub mod air;
pub mod bench;
pub mod drive;
pub mod machine;
pub mod motion;
pub mod stiffness;

pub use air::{Air, AirConfig};
pub use bench::{Bench, BenchConfig, GaugeConfig, Reading};
pub use machine::{Geometry, Machine, MachineConfig};
pub use motion::{Motion, MotionFault, Place, Program};
pub use stiffness::Around;
