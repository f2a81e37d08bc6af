//! The `rarma` command as a library, so that tests can call what it does.
//!
//! Files and screens live here; arithmetic does not.

/// Prints a line for people. A reader that has gone away (`| head`) is no failure.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

pub mod args;
pub mod cers;
pub mod collect;
pub mod commands;
pub mod ear;
pub mod els;
pub mod failure;
pub mod frames;
pub mod input;
pub mod ldbb;
mod one_line;
pub mod port;
pub mod record;
pub mod report;
pub mod scenario;
pub mod speech;
mod translate;
pub mod truth;

pub use failure::Failure;
