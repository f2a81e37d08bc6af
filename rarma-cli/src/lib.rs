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

/// A notice on standard error, see [`output::notice`]; the standard library's own would end the
/// program where it cannot be written.
macro_rules! eprintln {
    ($($text:tt)*) => {
        $crate::output::notice(format_args!($($text)*))
    };
}

pub mod advice;
pub mod args;
pub mod bridge;
pub mod collect;
pub mod commands;
pub mod controller;
pub mod failure;
pub mod frames;
pub mod key;
pub mod output;
pub mod port;
mod progress;
mod readings;
pub mod record;
pub mod report;
mod screen;
mod signals;
pub mod sound_card;
mod standing;
mod translate;
mod wording;

pub use failure::Failure;
