//! The elastic linked system as a computational model: tool, holder and spindle as beam
//! finite elements, joints and bearings as rings of springs, the cutting process as an
//! elastic link between the tool joint and a rigid table.
//!
//! Slow path, f64 and SI units throughout; dense matrices (nalgebra), a hundred or two
//! degrees of freedom.
//!
//! * [`beam`] one element and a body of segments, [`ring`] joints and bearings,
//!   [`link`] the elastic link and how its stiffness follows its load;
//! * [`ElsConfig`] the whole system, [`ElsModel`] assembled: natural frequencies and
//!   shapes, receptances, static deflection;
//! * [`fit`] joint stiffness from measured load steps and receptances.
//!
//! Coordinates: z along the spindle axis from the tool joint upward, x and y across; each
//! node has x, its slope dx/dz, y, its slope dy/dz, and the twist about z. No axial motion.
//!
//! Words: *tool joint*, the ball at the tip where the load bar holds; *grounded*, the tip
//! held by a link of great stiffness; *loss factor* η, share of the stiffness that turns by 90°:
//! damping that does not depend on frequency, ζ = η/2 of a mode that has nothing else.

mod assembly;
pub mod beam;
mod config;
mod error;
pub mod fit;
pub mod link;
mod modes;
mod response;
pub mod ring;
mod statics;
#[cfg(test)]
mod tests;

pub use assembly::ElsModel;
pub use config::{Clamping, ElsConfig, Place};
pub use error::ElsModelError;
pub use modes::{NaturalMode, Shape};
pub use statics::Deflection;
