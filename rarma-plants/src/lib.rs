//! Simulated machines: the physics of the outside world.
//!
//! Models in f64 and SI units that know neither the firmware nor its simulated
//! hardware (`hal-sim` stands on them); each can be used alone. Everything random
//! is seeded: the same build on the same platform repeats to the bit.
//!
//! * [`modal`] the linear structure, [`modal_noise`] its response to white
//!   noise with exactly known poles (the accuracy bench of the estimators);
//! * [`process`] what cutting models share, [`milling`] and [`turning`] the
//!   regenerative cuts, [`workpiece`] what they meet on
//!   their way;
//! * [`stability`] limits in closed form, [`growth`] limits from the simulation,
//!   [`delay`] limits and operational damping by semi-discretisation;
//! * [`forced`] what teeth and runout force of a stable cut;
//! * [`variation`] a spindle speed that swings;
//! * [`ldbb`] a machine under a loaded ball bar, and the bar's air;
//! * [`cers`] magnets, amplifiers, sensors and the structure of the exciter;
//! * [`els`] tool, holder and spindle as beams, joints and bearings, the elastic link;
//! * [`surface`] what the cut leaves on the workpiece;
//! * [`resample`], [`sound`] and [`converter`] what a microphone makes of it,
//!   [`cut`] a whole scenario
//!   and [`truth`] what is true of it;
//! * [`population`] machines and cuts drawn at random, by seed, each with its truth.

pub mod cers;
mod condition;
pub mod converter;
pub mod cut;
pub mod delay;
pub mod els;
pub mod error;
pub mod forced;
pub mod growth;
pub mod ldbb;
mod linalg;
pub mod milling;
mod milling_config;
mod milling_motion;
pub mod modal;
pub mod modal_noise;
pub mod population;
pub mod process;
pub mod resample;
pub mod sound;
pub mod stability;
pub mod surface;
pub mod truth;
pub mod turning;
pub mod variation;
pub mod workpiece;

pub use error::PlantError;
