//! Everything `rarma` writes: standard output, files, records of a box.
//!
//! * [`stdout`]: lines. The first one that cannot be written ends the command.
//! * [`NewFile`], [`WavFile`]: a file that takes its name only once it is whole; what had
//!   the name before stays until then.
//! * [`RecordFile`]: a record is appended to, never replaced, and by one program at a time.
//! * [`LiveWav`]: sound that is recorded as it is heard, under its own name, valid at every moment.
//! * [`check`]: before anything is done: nothing is written onto what is read.
//!
//! Each failure names the file, and has exit code 4.

mod check;
mod live_wav;
mod new_file;
mod place;
mod record;
pub mod stdout;
mod wav;

pub use check::{Files, check};
pub use live_wav::{LiveWav, must_be_new};
pub use new_file::{NewFile, Whole, keep, write, write_all};
pub use record::RecordFile;
pub use wav::{WavFile, most_samples};

use crate::failure::Failure;
use crate::input::system_words;
use std::fs;
use std::io;
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

/// Makes a folder, with those above it, if it is not there.
///
/// # Errors
/// It cannot be made.
pub fn folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|why| failed(path, "make the folder", &why))
}

/// What is said of a write that failed: file, step, reason, remedy.
pub fn failed(file: impl AsRef<Path>, step: &str, why: &io::Error) -> Failure {
    use io::ErrorKind as Kind;
    let file = file.as_ref().display();
    let other = "write to another place";
    let words = system_words(why);
    let (what, remedy) = match why.kind() {
        Kind::StorageFull => ("the disk is full", "make room, or write to another disk"),
        Kind::QuotaExceeded => ("the quota is used up", "make room, or ask for more"),
        Kind::FileTooLarge => ("a file may not become so large here", other),
        Kind::ReadOnlyFilesystem => ("the disk can only be read", other),
        Kind::NotFound => ("no such folder", "make it first, or check the spelling"),
        Kind::IsADirectory => ("is a folder", "name a file in it"),
        Kind::NotADirectory | Kind::AlreadyExists => ("a file is where a folder should be", other),
        _ => (words.as_str(), other),
    };
    Failure::System(format!("{file}: {step}: {what} ({remedy})"))
}
