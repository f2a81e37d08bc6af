//! Files out.
//!
//! * [`NewFile`], [`WavFile`]: a file that takes its name only once it is whole; what had
//!   the name before stays until then.
//! * [`RecordFile`]: a record is appended to, never replaced, and by one program at a time.
//! * [`LiveWav`]: sound that is recorded as it is heard, under its own name, valid at every moment.
//! * [`check`]: before anything is done: nothing is written onto what is read.
//!
//! Each failure names the file, see [`WriteError`].

mod check;
mod error;
mod live_wav;
mod new_file;
mod place;
mod record;
mod wav;

pub use check::{Files, check};
pub use error::{WriteError, WriteProblem};
pub use live_wav::{LiveWav, must_be_new};
pub use new_file::{NewFile, Whole, keep, write, write_all};
pub use record::RecordFile;
pub use wav::{WavFile, most_samples};

use crate::system::system_words;
use std::fs;
use std::io;
use std::path::Path;

/// Makes a folder, with those above it, if it is not there.
///
/// # Errors
/// It cannot be made.
pub fn folder(path: &Path) -> Result<(), WriteError> {
    fs::create_dir_all(path).map_err(|why| failed(path, "make the folder", &why))
}

/// What is said of a write that failed: file, step, reason, remedy.
pub fn failed(file: impl AsRef<Path>, step: &str, why: &io::Error) -> WriteError {
    use io::ErrorKind as Kind;
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
    WriteError::new(WriteProblem::System, file, step, what, remedy)
}
