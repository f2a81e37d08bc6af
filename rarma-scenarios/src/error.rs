//! What can be wrong with a scenario, in one line.

use rarma_recordings::input::InputError;
use rarma_recordings::one_line::OneLine;
use std::fmt;

/// One line: `<file>: <place>: <what is wrong, and what is allowed or to be done>`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScenarioError {
    /// File, or the scenario's name.
    pub file: String,
    /// Where in it: a line, or `whole file`.
    pub place: String,
    /// The field, what is wrong with it, and in brackets what is allowed or to be done.
    pub what: String,
}

impl ScenarioError {
    pub(crate) fn new(
        file: impl fmt::Display,
        place: impl fmt::Display,
        what: impl fmt::Display,
    ) -> Self {
        Self {
            file: file.to_string(),
            place: place.to_string(),
            what: what.to_string(),
        }
    }

    /// What no single place of a file shows. A `what` that ends with a remedy of its own keeps it.
    pub fn whole(file: impl fmt::Display, what: impl fmt::Display, remedy: &str) -> Self {
        let mut what = what.to_string();
        if !what.ends_with(')') {
            what = format!("{what} ({remedy})");
        }
        Self::new(file, "whole file", what)
    }

    /// The same, saying first where its file was named: one that names another.
    #[must_use]
    pub(crate) fn within(mut self, place: impl fmt::Display) -> Self {
        self.file = format!("{place}: {}", self.file);
        self
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = format!("{}: {}: {}", self.file, self.place, self.what);
        write!(f, "{}", OneLine(&line))
    }
}

impl std::error::Error for ScenarioError {}

impl From<InputError> for ScenarioError {
    fn from(error: InputError) -> Self {
        let what = format!("{} ({})", error.what, error.remedy);
        Self::new(error.file.display(), error.place, what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_that_keeps_its_own_remedy() {
        let why = ScenarioError::whole("a\nb", "too deep", "cut less");
        assert_eq!(why.to_string(), "a\\nb: whole file: too deep (cut less)");
        let why = ScenarioError::whole("b", "too deep (allowed: 3)", "cut less").within("a: hears");
        assert_eq!(
            why.to_string(),
            "a: hears: b: whole file: too deep (allowed: 3)"
        );
    }
}
