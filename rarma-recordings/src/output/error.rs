//! What can be wrong with a file that is written, in one line.

use crate::one_line::OneLine;
use std::fmt;
use std::path::{Path, PathBuf};

/// The kind of trouble, for code; the words are in [`WriteError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WriteProblem {
    /// It would be written onto what is read, or onto what is written as well.
    Clash,
    /// Its name has none of the endings that tell a format.
    Ending,
    /// It is to be appended to, and is no record of a box.
    NoRecord,
    /// The system or the format refuses: no such folder, a full disk, more than a file holds.
    System,
}

/// One line: `<file>: <step>: <what> (<what to do>)`, the name of the option before it where there
/// is one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WriteError {
    /// Kind of trouble.
    pub problem: WriteProblem,
    /// Option that named the file, where that is known.
    pub option: Option<&'static str>,
    /// File it is about.
    pub file: PathBuf,
    /// Step that failed: `open`, `write`, `rename`; empty before any.
    pub step: String,
    /// What is wrong.
    pub what: String,
    /// What to do about it; empty where nothing is known.
    pub remedy: String,
}

impl WriteError {
    pub(crate) fn new(
        problem: WriteProblem,
        file: impl AsRef<Path>,
        step: impl Into<String>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            problem,
            option: None,
            file: file.as_ref().to_path_buf(),
            step: step.into(),
            what: what.into(),
            remedy: remedy.into(),
        }
    }
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let option = self.option.map_or(String::new(), |name| format!("{name} "));
        let mut line = format!("{option}{}: ", self.file.display());
        if !self.step.is_empty() {
            line += &format!("{}: ", self.step);
        }
        line += &self.what;
        if !self.remedy.is_empty() {
            line += &format!(" ({})", self.remedy);
        }
        write!(f, "{}", OneLine(&line))
    }
}

impl std::error::Error for WriteError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_with_the_parts_there_are() {
        let why = WriteError::new(WriteProblem::System, "a\nb", "open", "no disk", "buy one");
        assert_eq!(why.to_string(), "a\\nb: open: no disk (buy one)");
        let why = WriteError {
            option: Some("--out"),
            ..WriteError::new(WriteProblem::Clash, "c", "", "it is what is read", "")
        };
        assert_eq!(why.to_string(), "--out c: it is what is read");
    }
}
