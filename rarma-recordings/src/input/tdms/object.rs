//! What the parts of a file are called, and what they say of themselves.

use super::kind::Kind;
use crate::one_line::OneLine;

/// Properties of an object that are kept, at most: ten times as many as scales have.
const MOST: usize = 1024;

/// What a property says; only those that matter are kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Property {
    Number(f64),
    Text(String),
    /// A time.
    Other,
}

/// Values in a row, each chunk as long as the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    /// Where the first value lies, bytes into the file.
    pub(super) at: u64,
    /// Values of a chunk, bytes from one to the next, and from one chunk to the next.
    pub(super) each: u64,
    pub(super) stride: u64,
    pub(super) chunk: u64,
    /// Values in all.
    pub(super) count: u64,
    pub(super) big: bool,
}

/// A group, a channel, or the file itself.
#[derive(Debug, Clone, Default)]
pub(super) struct Object {
    /// Names from the file down: none, a group's, a channel's.
    pub(super) names: Vec<String>,
    pub(super) properties: Vec<(String, Property)>,
    pub(super) kind: Option<Kind>,
    pub(super) pieces: Vec<Piece>,
    pub(super) count: u64,
}

impl Object {
    /// By its path, such as `/'Vibration'/'it''s x'`.
    pub(super) fn of(path: &str) -> Self {
        let mut names = Vec::new();
        let mut rest = path.chars().peekable();
        while rest.next().is_some_and(|c| c == '/') {
            if rest.next_if_eq(&'\'').is_none() {
                break;
            }
            let mut name = String::new();
            while let Some(c) = rest.next() {
                if c == '\'' && rest.next_if_eq(&'\'').is_none() {
                    break;
                }
                name.push(c);
            }
            names.push(name);
        }
        Self {
            names,
            ..Self::default()
        }
    }

    /// For people: `Vibration/x`, in one line whatever the file holds.
    pub(super) fn name(&self) -> String {
        OneLine(&self.names.join("/")).to_string()
    }

    /// It may hold samples.
    pub(super) fn is_channel(&self) -> bool {
        self.names.len() == 2
    }

    /// A property; what comes last in the file counts.
    pub(super) fn property(&self, name: &str) -> Option<&Property> {
        let found = self.properties.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value)
    }

    /// A property that is a number.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.property(name)? {
            Property::Number(x) => Some(*x),
            _ => None,
        }
    }

    /// A property that is text, without blanks around it; none of nothing but those.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        match self.property(name)? {
            Property::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }

    /// Sets a property, if it is one of those that matter.
    pub(super) fn set(&mut self, name: &str, value: Property) {
        let matters = ["wf_", "NI_Scal", "NI_Number_Of_Scales", "unit_string"];
        if !matters.iter().any(|start| name.starts_with(start)) {
            return;
        }
        if let Some((_, old)) = self.properties.iter_mut().find(|(key, _)| key == name) {
            *old = value;
        } else if self.properties.len() < MOST {
            self.properties.push((name.to_owned(), value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_hold_quoted_names() {
        let names = |path: &str| Object::of(path).names;
        assert!(names("/").is_empty());
        assert_eq!(names("/'a'"), ["a"]);
        assert_eq!(names("/'a b'/'it''s /x'"), ["a b", "it's /x"]);
        assert_eq!(names("/'a'/'b"), ["a", "b"]);
        assert!(names("a").is_empty() && names("").is_empty());
        assert_eq!(Object::of("/'Vibration'/'x'").name(), "Vibration/x");
    }
}
