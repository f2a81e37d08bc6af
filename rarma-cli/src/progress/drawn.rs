//! Drawn by a library.

pub use indicatif::ProgressBar;

use indicatif::{ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::Duration;

/// Somebody looks on, and has not asked for quiet.
fn shows_progress() -> bool {
    io::stderr().is_terminal() && !crate::output::is_quiet()
}

/// A bar on standard error, on a terminal only.
pub fn progress(length: u64, what: &str) -> ProgressBar {
    let target = if shows_progress() {
        ProgressDrawTarget::stderr_with_hz(10)
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// A sign of life and the time it has taken, for work whose end cannot be foretold; on
/// standard error, on a terminal only.
pub fn waiting(what: String) -> ProgressBar {
    if !shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{msg} {spinner} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
