//! Standard output, checked.
//!
//! `say!` is used in the middle of sentences that have no way to fail, so the
//! first failure is kept here; nothing is written after it. A command that prints as it goes
//! asks [`check`] now and then and stops; every other is told by [`end`], when its files are
//! in place.

use super::{aside, failed};
use crate::failure::Failure;
use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is said of it in place of a file's name.
const NAME: &str = "standard output";

static FIRST: Mutex<Option<Failure>> = Mutex::new(None);

fn first() -> MutexGuard<'static, Option<Failure>> {
    FIRST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a line.
pub fn line(text: Arguments<'_>) {
    if check().is_err() || aside::keeps(aside::Way::Output, text) {
        return;
    }
    if let Err(why) = writeln!(io::stdout().lock(), "{text}") {
        kept(&why);
    }
}

/// Whether all that was said could be written so far.
///
/// # Errors
/// It could not: the disk is full, or whoever read it has gone away.
pub fn check() -> Result<(), Failure> {
    first().clone().map_or(Ok(()), Err)
}

/// [`check`], once the last line has left.
///
/// # Errors
/// As [`check`].
pub fn end() -> Result<(), Failure> {
    if let Err(why) = Stdout.flush() {
        kept(&why);
    }
    check()
}

/// What somebody else has written.
///
/// # Errors
/// It could not be written.
pub fn wrote<T>(result: io::Result<T>) -> Result<T, Failure> {
    result.map_err(|why| {
        kept(&why);
        check().err().unwrap_or(Failure::Closed)
    })
}

/// Standard output to be written to in bulk; its failures are kept, too.
#[derive(Debug, Clone, Copy)]
pub struct Stdout;

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if first().is_some() {
            return Err(io::ErrorKind::Other.into());
        }
        io::stdout().write(bytes).inspect_err(kept)
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stdout().flush().inspect_err(kept)
    }
}

fn kept(why: &io::Error) {
    let failure = if why.kind() == io::ErrorKind::BrokenPipe {
        Failure::Closed
    } else {
        failed(NAME, "write", why).into()
    };
    first().get_or_insert(failure);
}
