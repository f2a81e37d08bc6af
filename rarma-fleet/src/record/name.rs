//! Names of boxes, machines, tools and people.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A short text that can stand in a topic, a table and a page: 1 to 64 characters, no control
/// characters, no space at either end, and none of `/`, `+`, `#`, which part the topics of a broker.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Name(String);

/// Longest name, characters.
const MOST: usize = 64;

/// Why a text is no name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Nothing in it.
    #[error("a name is empty")]
    Empty,
    /// Too long.
    #[error("a name of {0} characters: at most 64 go")]
    Long(usize),
    /// A character that does not go.
    #[error("the name {name:?} has {character:?}, which does not go in a name")]
    Character {
        /// The text.
        name: String,
        /// The character.
        character: char,
    },
    /// A space at an end.
    #[error("the name {0:?} begins or ends with a space")]
    Space(String),
}

impl Name {
    /// A name of a text.
    ///
    /// # Errors
    /// [`NameError`].
    pub fn new(text: &str) -> Result<Self, NameError> {
        let count = text.chars().count();
        if count == 0 {
            return Err(NameError::Empty);
        }
        if count > MOST {
            return Err(NameError::Long(count));
        }
        if let Some(character) = text.chars().find(|&c| c.is_control() || "/+#".contains(c)) {
            return Err(NameError::Character {
                name: text.to_owned(),
                character,
            });
        }
        if text.trim() != text {
            return Err(NameError::Space(text.to_owned()));
        }
        Ok(Self(text.to_owned()))
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<String> for Name {
    type Error = NameError;

    fn try_from(text: String) -> Result<Self, NameError> {
        Self::new(&text)
    }
}

impl std::str::FromStr for Name {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        Self::new(text)
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}
