//! Arithmetic of the test rigs that load or shake a machine tool: what is measured with them,
//! and the sequences that measure it.
//!
//! No clock, pin or file; nothing allocates, nothing panics. Rate, units and words stand with each rig:
//!
//! * [`cers`], an active magnetic bearing that shakes a turning spindle;
//! * [`ldbb`], a ball bar that loads the machine;
//! * [`els`], what a machine's receptances say about the cut that it stands.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod cers;
pub mod els;
pub mod ldbb;
