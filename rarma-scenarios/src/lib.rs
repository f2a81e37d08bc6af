//! Scenario files to simulated machines and rigs: what they are, what they truly do, and what a measurement on a rig says.
//!
//! * [`scenario`]: TOML files and the shipped ones, with units in their names, to plants in SI; what is wrong is one
//!   line ([`ScenarioError`]). From the same calls come their JSON schemas.
//! * [`truth`], [`ear`]: what a cut truly does; what is heard of it, conditioned as the box does ([`banded`]).
//! * [`measure`], [`cers`]: a measurement on the simulated exciter; records to responses, modes and tracks.
//! * [`ldbb`]: loaded ball bar tests to machine errors and stiffness.
//! * [`els`]: a machine under load, directions, hammer blows.
//! * [`speech`]: commands to the box in words, as scenarios and people say them.
//!
//! ```
//! use rarma_scenarios::ear::{self, Forced};
//! use rarma_scenarios::scenario;
//!
//! let mut loaded = scenario::load("chatter-onset", Some(7))?;
//! loaded.scenario.duration_s = 0.6;
//! let heard = ear::hear(&loaded.scenario, loaded.band(), Forced::Kept)?;
//! assert!(!heard.band.is_empty() && heard.band_fs < heard.fs);
//! # Ok::<(), rarma_scenarios::ScenarioError>(())
//! ```

pub mod banded;
pub mod cers;
pub mod ear;
pub mod els;
mod error;
pub mod ldbb;
pub mod measure;
pub mod scenario;
pub mod speech;
pub mod truth;

pub use error::ScenarioError;
