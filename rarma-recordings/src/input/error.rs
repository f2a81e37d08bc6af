//! What can be wrong with an input file, in one line.

use crate::one_line::OneLine;
use crate::system::system_words;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// The kind of trouble, for code; the words are in [`InputError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// There is no such file.
    NotFound,
    /// The file may not be read by this user.
    Permission,
    /// Opening or reading failed in another way.
    Io,
    /// A directory where a file is wanted.
    Directory,
    /// The name does not end in a known extension.
    Extension,
    /// No bytes at all.
    Empty,
    /// The content is not what the extension promises.
    NotThisFormat,
    /// The file ends inside its header, or before a needed part.
    Truncated,
    /// The header contradicts itself.
    Header,
    /// A known container around an encoding that is not read here.
    Unsupported,
    /// The asked-for channel does not exist, or none does.
    Channel,
    /// A record holds several streams, or not the one that was asked for.
    Stream,
    /// The sampling rate is missing, zero, or contradicted.
    Rate,
    /// Header and structure are fine, samples are missing.
    NoSamples,
    /// Text where a number is wanted.
    NotANumber,
    /// A field or a line is missing in the middle of the data.
    Hole,
    /// Time does not advance in equal steps.
    Time,
    /// A number that cannot be what it is said to be.
    Range,
    /// Samples that are NaN or infinite.
    NonFinite,
    /// Every sample is the same.
    Silence,
    /// The signal ran into the end of the converter's range.
    Clipped,
    /// Frequencies that do not rise, or differ between functions that belong together.
    Grid,
    /// Units that are unknown, or contradict each other.
    Units,
    /// The file is larger than any of its kind.
    Size,
}

/// One line: `<file>: <place>: <what> (<what to do>)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// Kind of trouble.
    pub problem: Problem,
    /// File it is in.
    pub file: PathBuf,
    /// Where in the file: a line, a byte, a sample, or the step that failed.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub remedy: String,
}

impl InputError {
    /// An error whose file is not named yet.
    pub fn new(
        problem: Problem,
        place: impl Into<String>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            problem,
            file: PathBuf::new(),
            place: place.into(),
            what: what.into(),
            remedy: remedy.into(),
        }
    }

    /// Names the file.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        self.file = path.to_path_buf();
        self
    }

    /// Words for a failed system call.
    pub fn from_io(error: &io::Error) -> Self {
        use io::ErrorKind as Kind;
        let (problem, place, what, remedy) = match error.kind() {
            Kind::NotFound => (
                Problem::NotFound,
                "open",
                "no such file",
                "check the spelling and the directory",
            ),
            Kind::PermissionDenied => (
                Problem::Permission,
                "open",
                "permission denied",
                "make the file readable for this user",
            ),
            Kind::NotADirectory => (
                Problem::NotFound,
                "open",
                "a file stands where the name needs a directory",
                "check the spelling and the directory",
            ),
            Kind::IsADirectory => (
                Problem::Directory,
                "open",
                "is a directory",
                "name one file inside it",
            ),
            Kind::OutOfMemory => (
                Problem::Size,
                "read",
                "larger than the memory of this machine",
                "check that it is the right file, or cut it",
            ),
            _ => {
                let words = system_words(error);
                return Self::new(
                    Problem::Io,
                    "read",
                    words,
                    "copy the file to a local disk and try again",
                );
            }
        };
        Self::new(problem, place, what, remedy)
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = format!(
            "{}: {}: {} ({})",
            self.file.display(),
            self.place,
            self.what,
            self.remedy
        );
        write!(f, "{}", OneLine(&line))
    }
}

impl std::error::Error for InputError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_with_four_parts() {
        let e = InputError::new(Problem::Hole, "line 3", "no value", "fill it in")
            .in_file(Path::new("a\nb.csv"));
        assert_eq!(e.to_string(), "a\\nb.csv: line 3: no value (fill it in)");
    }

    /// Root may read everything, so the refusal itself is tested here and the
    /// real thing in `tests/input.rs` only for other users.
    #[test]
    fn system_errors_have_words() {
        let of = |kind| InputError::from_io(&io::Error::from(kind));
        let denied = of(io::ErrorKind::PermissionDenied);
        assert_eq!(denied.problem, Problem::Permission);
        assert!(denied.to_string().contains("permission denied"));
        assert_eq!(of(io::ErrorKind::NotFound).problem, Problem::NotFound);
        assert_eq!(of(io::ErrorKind::TimedOut).problem, Problem::Io);
        let memory = of(io::ErrorKind::OutOfMemory);
        assert_eq!(memory.problem, Problem::Size);
        assert!(!memory.to_string().contains("out of memory"), "{memory}");
        // The system's own words, without its numbers.
        let broken = InputError::from_io(&io::Error::from_raw_os_error(5));
        assert!(!broken.to_string().contains("os error"), "{broken}");
    }
}
