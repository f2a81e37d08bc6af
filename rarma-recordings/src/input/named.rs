//! A small table whose columns are known by their names.
//!
//! ```text
//! # comment lines anywhere
//! rpm,state,f             the header names the columns, in any order
//! 12000,chatter,1128
//! ```
//!
//! Semicolons (then with decimal commas if there are any) and tabs separate as well. Columns of other
//! names are passed over.

use super::table::{Dialect, hole, not_a_number};
use super::{InputError, Problem};

/// A table that was read.
pub(super) struct Named {
    /// Its lines.
    pub lines: Vec<NamedLine>,
}

/// One line: a field for each name that was asked for.
pub(super) struct NamedLine {
    number: usize,
    dialect: Dialect,
    /// The field and its column, counted from 1.
    fields: Vec<Option<(String, usize)>>,
}

impl Named {
    /// Reads a table that has the columns `needed`, and maybe those of `optional`.
    ///
    /// # Errors
    /// It is empty, or lacks a column.
    pub fn read(text: &str, needed: &[&str], optional: &[&str]) -> Result<Self, InputError> {
        let columns_are = || {
            let all: Vec<&str> = needed.iter().chain(optional).copied().collect();
            all.join(",")
        };
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(i, line)| (i + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let Some((number, header)) = lines.next() else {
            return Err(InputError::new(
                Problem::Empty,
                "file",
                "it holds nothing",
                format!("give the columns {}", columns_are()),
            ));
        };
        let dialect = Dialect::of(header);
        let names = dialect.fields(header);
        let place = |name: &&str| names.iter().position(|n| n == name);
        let mut columns = Vec::new();
        for name in needed {
            columns.push(Some(place(name).ok_or_else(|| {
                InputError::new(
                    Problem::Hole,
                    format!("line {number}"),
                    format!("there is no column {name}"),
                    format!("name the columns {}", columns_are()),
                )
            })?));
        }
        columns.extend(optional.iter().map(place));
        let line = |(number, line)| {
            let fields = dialect.fields(line);
            let of = |column: &Option<usize>| {
                let column = (*column)?;
                let field = fields.get(column).copied().unwrap_or_default();
                Some((field.to_owned(), column + 1))
            };
            NamedLine {
                number,
                dialect,
                fields: columns.iter().map(of).collect(),
            }
        };
        Ok(Self {
            lines: lines.map(line).collect(),
        })
    }
}

impl NamedLine {
    /// Where it stands.
    pub fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// What stands in the column of the name of this place among those asked for; empty where
    /// nothing does.
    pub fn text(&self, name: usize) -> &str {
        let field = self.fields.get(name).and_then(Option::as_ref);
        field.map_or("", |(text, _)| text)
    }

    /// The number there; none where the field is empty.
    ///
    /// # Errors
    /// It is no number.
    pub fn maybe(&self, name: usize) -> Result<Option<f64>, InputError> {
        let Some(Some((text, column))) = self.fields.get(name) else {
            return Ok(None);
        };
        if text.is_empty() {
            return Ok(None);
        }
        let number = self.dialect.number(text);
        let wrong = || not_a_number(self.number, *column, text);
        number.map(Some).ok_or_else(wrong)
    }

    /// The number there.
    ///
    /// # Errors
    /// There is none, or it is no number.
    pub fn number(&self, name: usize) -> Result<f64, InputError> {
        let column = match self.fields.get(name) {
            Some(Some((_, column))) => *column,
            _ => 1,
        };
        self.maybe(name)?.ok_or_else(|| hole(self.number, column))
    }
}
