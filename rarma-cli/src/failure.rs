//! How a command ends when it does not succeed.

use rarma_population::Defect;
use rarma_recordings::input::InputError;
use rarma_recordings::one_line::OneLine;
use rarma_recordings::output::{WriteError, WriteProblem};
use rarma_scenarios::ScenarioError;
use std::fmt;

/// A failure with its exit code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// Wrong usage: exit code 2.
    Usage(String),
    /// Bad input: exit code 3, one line naming file, place and reason.
    Input(String),
    /// Something outside the input went wrong (a tool is missing, a disk full):
    /// exit code 4.
    System(String),
    /// An input that gives no sound, muted or dead: exit code 5.
    NoSound(String),
    /// A sound card that went away while it was listened to: exit code 6.
    Gone(String),
    /// Whoever read standard output has gone away (`| head`): the command ends as one that
    /// the system ends for it, exit code 141 (128 + SIGPIPE), without a word.
    Closed,
}

impl Failure {
    /// Bad input that no single place of a file shows: `FILE: whole file: WHAT (REMEDY)`. A
    /// `what` that ends with a remedy of its own keeps it.
    pub fn whole(file: impl fmt::Display, what: impl fmt::Display, remedy: &str) -> Self {
        ScenarioError::whole(file, what, remedy).into()
    }

    /// The process' exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Input(_) => 3,
            Self::System(_) => 4,
            Self::NoSound(_) => 5,
            Self::Gone(_) => 6,
            Self::Closed => 141,
        }
    }

    /// The same, saying first where its file was named: one that names another.
    #[must_use]
    pub fn within(mut self, place: impl fmt::Display) -> Self {
        if let Some(text) = self.text_mut() {
            *text = format!("{place}: {text}");
        }
        self
    }

    /// The same, saying in the same line what was kept all the same.
    #[must_use]
    pub fn kept(mut self, what: impl fmt::Display) -> Self {
        if let Some(text) = self.text_mut() {
            *text = format!("{text}; {what}");
        }
        self
    }

    fn text_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Usage(text)
            | Self::Input(text)
            | Self::System(text)
            | Self::NoSound(text)
            | Self::Gone(text) => Some(text),
            Self::Closed => None,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            Self::Usage(what)
            | Self::Input(what)
            | Self::System(what)
            | Self::NoSound(what)
            | Self::Gone(what) => what.as_str(),
            Self::Closed => "the reader of standard output has gone away",
        };
        write!(f, "{}", OneLine(what))
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<Defect> for Failure {
    fn from(defect: Defect) -> Self {
        Self::System(defect.to_string())
    }
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let words = error.to_string();
        match error.problem {
            WriteProblem::Clash | WriteProblem::Ending => Self::Usage(words),
            WriteProblem::NoRecord => Self::Input(words),
            WriteProblem::System => Self::System(words),
        }
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::System(error.to_string())
    }
}
