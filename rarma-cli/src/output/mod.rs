//! Everything `rarma` writes: standard output, files, records of a box.
//!
//! * [`stdout`]: lines. The first one that cannot be written ends the command.
//! * `aside`: lines that would spoil a screen, until it is gone.
//! * Files: those of [`rarma_recordings::output`].
//!
//! Each failure names the file, and has exit code 4.

#[cfg_attr(
    any(not(feature = "screen"), target_family = "wasm"),
    allow(dead_code, reason = "without a screen nothing is kept")
)]
pub(crate) mod aside;
pub mod stdout;

pub use rarma_recordings::output::{
    Files, LiveWav, NewFile, RecordFile, WavFile, Whole, check, failed, folder, keep, most_samples,
    must_be_new, write, write_all,
};

use crate::failure::Failure;
use rarma_recordings::export::Table;
use rarma_recordings::output::WriteProblem;
use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// No notices and no progress from now on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Neither notices nor progress are wanted.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// A notice on standard error, unless none is wanted. Where it cannot be written there is nobody
/// to tell, and no reason to end the work.
pub(crate) fn notice(text: fmt::Arguments<'_>) {
    if !is_quiet() && !aside::keeps(aside::Way::Error, text) {
        let _ = writeln!(io::stderr(), "{text}");
    }
}

/// What does not work, was lost or was refused while the program goes on: on standard error, wanted or not.
#[cfg(feature = "fleet")]
pub(crate) fn trouble(text: fmt::Arguments<'_>) {
    if !aside::keeps(aside::Way::Error, text) {
        let _ = writeln!(io::stderr(), "{text}");
    }
}

/// The screen is gone: what was kept aside is written.
#[cfg_attr(
    any(not(feature = "screen"), target_family = "wasm"),
    allow(dead_code, reason = "without a screen nothing is kept")
)]
pub(crate) fn end_aside() {
    let (left_out, lines) = aside::end();
    if left_out > 0 {
        let _ = writeln!(io::stderr(), "({left_out} lines before these are left out)");
    }
    for (way, line) in lines {
        match way {
            aside::Way::Output => stdout::line(format_args!("{line}")),
            // Where it cannot be written there is nobody to tell.
            aside::Way::Error => drop(writeln!(io::stderr(), "{line}")),
        }
    }
}

/// Opens a record of a box to append to; that its disk has no locks is told.
///
/// # Errors
/// See [`RecordFile::open`].
pub(crate) fn record(path: &Path) -> Result<RecordFile, Failure> {
    Ok(RecordFile::open(path, notice)?)
}

/// Writes a table in the format of the ending of the file that `option` names.
///
/// # Errors
/// See [`rarma_recordings::export::write`]; another ending is wrong usage.
pub(crate) fn export(path: &Path, option: &str, table: &Table) -> Result<Whole, Failure> {
    rarma_recordings::export::write(path, table).map_err(|why| match why.problem {
        WriteProblem::Ending => {
            Failure::Usage(format!("{option}: {} {}", why.file.display(), why.what))
        }
        _ => why.into(),
    })
}
