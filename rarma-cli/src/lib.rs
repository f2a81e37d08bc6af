//! The `rarma` command as a library, so that tests can call what it does.
//!
//! Files and screens live here; arithmetic does not.

#![warn(clippy::print_stdout)]

/// Prints a line. That it could not be written is told when the command ends, see
/// [`output::stdout`].
macro_rules! say {
    ($($text:tt)*) => {
        $crate::output::stdout::line(format_args!($($text)*))
    };
}

/// A notice on standard error, unless the caller wants none. Where it cannot be written there is
/// nobody to tell, and no reason to end the work, as the standard library's own would.
macro_rules! eprintln {
    ($($text:tt)*) => {
        if !$crate::output::is_quiet() {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), $($text)*);
        }
    };
}

pub mod advice;
pub mod args;
pub mod banded;
pub mod bridge;
pub mod cers;
pub mod collect;
pub mod commands;
pub mod controller;
pub mod ear;
pub mod els;
pub mod export;
pub mod failure;
pub mod frames;
pub mod input;
pub mod key;
pub mod ldbb;
mod one_line;
pub mod output;
pub mod population;
pub mod port;
mod progress;
pub mod raw_streams;
mod readings;
pub mod record;
pub mod report;
pub mod scenario;
mod signals;
pub mod sound_card;
pub mod speech;
mod standing;
mod translate;
pub mod truth;

pub use failure::Failure;
