//! What the sensor box and the computer beside it share: frames, settings, and the rules that keep
//! the machine safe.
//!
//! Types, arithmetic and state machines only; no clock, pin or link. Nothing allocates, nothing panics.
//!
//! * [`wire`], telemetry and commands, and how they become bytes;
//! * [`settings`], what can be set, from one table;
//! * [`guard`], modes, faults, deadlines, and when outputs are permitted.
//!
//! With the feature `defmt` a firmware can log faults, modes, stages and why it is not armed.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod guard;
mod key;
pub mod settings;
pub mod wire;
