//! A scenario's file: found, parsed, and refused in one line.

use super::reader::{Refusal, Section, Text, unknown};
use crate::error::ScenarioError;
use rarma_recordings::input;
use serde_json::Value;
use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;
use toml::de::DeTable;

/// No scenario is larger than this, bytes.
const MOST_BYTES: u64 = 1 << 20;

/// The text of a scenario: a shipped one's by name, or a file's.
///
/// # Errors
/// The file cannot be read, is no text, or too large; in one line that lists the names.
pub(super) fn text(
    name: &str,
    shipped: &[(&'static str, &'static str)],
) -> Result<Cow<'static, str>, ScenarioError> {
    if let Some((_, text)) = shipped.iter().find(|(n, _)| *n == name) {
        return Ok(Cow::Borrowed(text));
    }
    input::text(Path::new(name), MOST_BYTES)
        .map(Cow::Owned)
        .map_err(|mut why| {
            if why.problem == input::Problem::NotFound && !shipped.is_empty() {
                let names: Vec<&str> = shipped.iter().map(|(n, _)| *n).collect();
                why.remedy = format!("name a TOML file, or one of {}", names.join(", "));
            }
            why.into()
        })
}

/// Reads a text with one of this module's readers; `file` is what messages call it.
///
/// # Errors
/// One line: file, line, field, what is allowed. Unknown names first: a misspelt field is
/// not a missing one.
pub(super) fn parse<V>(
    file: &str,
    text: &str,
    schema: &Value,
    read: impl FnOnce(&mut Section<'_>) -> Result<V, Refusal>,
) -> Result<V, ScenarioError> {
    let lines = Text(text);
    let table = DeTable::parse(text).map_err(|why| {
        let at = why.span().map_or(0, |span| span.start.min(text.len()));
        let before = &text.as_bytes()[..at];
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let column = 1 + String::from_utf8_lossy(&before[start..]).chars().count();
        let what = why.message().lines().next().unwrap_or_default();
        ScenarioError::new(
            file,
            format_args!("line {}, column {column}", lines.line(&(at..at))),
            format_args!(
                "not TOML: {what} (write NAME = VALUE, text in quotes, [TABLE] on a line of its own)"
            ),
        )
    })?;
    let refused = |r: Refusal| {
        ScenarioError::new(
            file,
            format_args!("line {}", r.line),
            format_args!("{} {}", r.field, r.what),
        )
    };
    if let Some(refusal) = unknown(lines, table.get_ref(), schema) {
        return Err(refused(refusal));
    }
    read(&mut Section::root(lines, table.get_ref())).map_err(refused)
}

/// What the plants themselves would refuse, and no single field shows.
pub(super) fn whole(file: &str, why: impl Display) -> ScenarioError {
    ScenarioError::whole(file, why, "correct the fields it names")
}
