//! What can be wrong with an input file, in one line.

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
    pub(super) fn new(
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
    pub(crate) fn in_file(mut self, path: &Path) -> Self {
        self.file = path.to_path_buf();
        self
    }

    /// Words for a failed system call.
    pub(super) fn from_io(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => Self::new(
                Problem::NotFound,
                "open",
                "no such file",
                "check the spelling and the directory",
            ),
            io::ErrorKind::PermissionDenied => Self::new(
                Problem::Permission,
                "open",
                "permission denied",
                "make the file readable for this user",
            ),
            _ => Self::new(
                Problem::Io,
                "read",
                error.to_string(),
                "copy the file to a local disk and try again",
            ),
        }
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
        // Names and fields come from outside: a line break in one of them must
        // not turn the line into two, nor an escape code reach the terminal.
        for c in line.chars() {
            if c.is_control() {
                write!(f, "{}", c.escape_default())?;
            } else {
                write!(f, "{c}")?;
            }
        }
        Ok(())
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
    }
}
