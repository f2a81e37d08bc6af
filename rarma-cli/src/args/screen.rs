//! The option `--screen`.

use clap::{Arg, ValueEnum};

/// When a live screen is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ScreenArg {
    /// On a terminal, where sound or a box is live, without --json and --quiet.
    Auto,
    /// Always; where it cannot be, it is said why.
    On,
    /// Never: lines as they come.
    Off,
}

/// A command that has no screen.
pub(super) fn none(option: Arg) -> Arg {
    option.hide(true).value_parser(|_: &str| {
        Err::<ScreenArg, _>("only monitor, listen and connect have a screen")
    })
}
