//! The one error type of the commands: what failed, why, and what to do about it.

use std::fmt;

/// Result of everything here that can fail.
pub type Result<T> = std::result::Result<T, Failure>;

/// A failed step, told to the person at the terminal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    what: String,
    why: Option<String>,
    advice: Option<String>,
    exit_code: u8,
}

impl Failure {
    /// Names the step that failed and where; exit code 1.
    pub fn new(what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            why: None,
            advice: None,
            exit_code: 1,
        }
    }

    /// Names a mistake in the arguments; exit code 2.
    pub fn usage(what: impl Into<String>) -> Self {
        Self {
            exit_code: 2,
            ..Self::new(what)
        }
    }

    /// Adds the cause.
    #[must_use]
    pub fn because(self, why: impl fmt::Display) -> Self {
        Self {
            why: Some(why.to_string()),
            ..self
        }
    }

    /// Adds what the reader can do about it.
    #[must_use]
    pub fn advise(self, advice: impl Into<String>) -> Self {
        Self {
            advice: Some(advice.into()),
            ..self
        }
    }

    /// Exit code of a process that ends with this failure.
    pub fn exit_code(&self) -> u8 {
        self.exit_code
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.what)?;
        if let Some(why) = &self.why {
            write!(out, ": {why}")?;
        }
        if let Some(advice) = &self.advice {
            write!(out, "\n  what to do: {advice}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Failure {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_why_and_what_to_do() {
        let failure = Failure::new("cannot read deny.toml")
            .because("not found")
            .advise("restore it");
        assert_eq!(
            failure.to_string(),
            "cannot read deny.toml: not found\n  what to do: restore it"
        );
        assert_eq!(failure.exit_code(), 1);
        assert_eq!(Failure::usage("no such board").exit_code(), 2);
    }
}
