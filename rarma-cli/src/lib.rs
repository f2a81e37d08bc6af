//! The `rarma` command as a library, so that tests can call what it does.
//!
//! Files and screens live here; arithmetic does not.

pub mod args;
pub mod collect;
pub mod commands;
pub mod failure;
pub mod input;
pub mod record;
pub mod report;

pub use failure::Failure;
