//! What a database must do for a store.

use super::tables::{Dialect, Table};

/// A value of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Nothing.
    Null,
    /// A whole number.
    Int(i64),
    /// A float.
    Real(f64),
    /// Text.
    Text(String),
}

/// Why a store does not answer.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file or database of another program.
    #[error("{0}")]
    Foreign(String),
    /// Tables of a later version.
    #[error(
        "its tables have version {found}, this program knows up to {known} (update it; nothing was changed)"
    )]
    Version {
        /// Their version.
        found: i64,
        /// The highest that is known.
        known: i64,
    },
    /// The way to the database is not safe, or is said in a way that cannot be gone.
    #[error("{0}")]
    Way(String),
    /// The database does not answer, or refuses.
    #[error("{0}")]
    Database(String),
    /// An answer that does not have the form that was asked for.
    #[error("an answer of another form: {0}")]
    Answer(String),
}

impl Value {
    /// A whole number.
    ///
    /// # Errors
    /// It is none.
    pub fn int(&self) -> Result<i64, StoreError> {
        match self {
            Self::Int(n) => Ok(*n),
            // PostgreSQL and ClickHouse give sums of whole numbers in types of their own.
            #[allow(clippy::cast_possible_truncation, reason = "checked to be whole")]
            Self::Real(x) if x.fract() == 0.0 && x.abs() < 9e15 => Ok(*x as i64),
            other => Err(StoreError::Answer(format!("{other:?} for a whole number"))),
        }
    }

    /// A float.
    ///
    /// # Errors
    /// It is none.
    #[allow(
        clippy::cast_precision_loss,
        reason = "a float that came without its point"
    )]
    pub fn real(&self) -> Result<f64, StoreError> {
        match self {
            Self::Real(x) => Ok(*x),
            Self::Int(n) => Ok(*n as f64),
            other => Err(StoreError::Answer(format!("{other:?} for a number"))),
        }
    }

    /// A text, or none.
    ///
    /// # Errors
    /// It is a number.
    pub fn text_or_null(&self) -> Result<Option<String>, StoreError> {
        match self {
            Self::Null => Ok(None),
            Self::Text(t) => Ok(Some(t.clone())),
            other => Err(StoreError::Answer(format!("{other:?} for a text"))),
        }
    }

    /// A text.
    ///
    /// # Errors
    /// It is none.
    pub fn text(&self) -> Result<String, StoreError> {
        self.text_or_null()?
            .ok_or_else(|| StoreError::Answer("nothing for a text".to_owned()))
    }
}

impl From<i64> for Value {
    fn from(n: i64) -> Self {
        Self::Int(n)
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        Self::Real(x)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, Into::into)
    }
}

/// Rows for a table.
pub type Rows = Vec<Vec<Value>>;

/// A database. SQL is written once: `?` is the next parameter, `@name` a table to be read.
pub trait Backend: Send {
    /// How it spells things.
    fn dialect(&self) -> Dialect;

    /// Runs a statement without parameters and answer.
    ///
    /// # Errors
    /// The database refuses.
    fn execute(&mut self, sql: &str) -> Result<(), StoreError>;

    /// Runs statements, all or none; one after the other where the database knows no transactions.
    ///
    /// # Errors
    /// The database refuses.
    fn execute_all(&mut self, statements: &[String]) -> Result<(), StoreError>;

    /// Rows that answer.
    ///
    /// # Errors
    /// The database refuses.
    fn query(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError>;

    /// Puts rows into tables, in this order, all or none; where the database knows no transactions
    /// (ClickHouse), a part may be there after a failure, which the same rows mend when they come again.
    /// A row whose key is there already is left out. What is new in a table that is summed is added to `sums`.
    ///
    /// # Errors
    /// The database refuses.
    fn insert(&mut self, rows: &[(&'static Table, Rows)]) -> Result<(), StoreError>;

    /// Remembers a number.
    ///
    /// # Errors
    /// The database refuses.
    fn put_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError>;
}

/// SQL with parameters and tables as a dialect spells them.
pub(super) fn spelled(dialect: Dialect, sql: &str, parameters: &[Value]) -> String {
    let mut out = String::with_capacity(sql.len() + 64);
    let mut next = 0;
    let mut rest = sql;
    while let Some(at) = rest.find(['?', '@']) {
        out.push_str(&rest[..at]);
        let parameter = rest.as_bytes()[at] == b'?';
        rest = &rest[at + 1..];
        if parameter {
            next += 1;
            match dialect {
                Dialect::Sqlite => out.push_str(&format!("?{next}")),
                Dialect::Postgres => out.push_str(&format!("${next}")),
                Dialect::ClickHouse => {
                    let kind = match parameters[next - 1] {
                        Value::Int(_) => "Int64",
                        Value::Real(_) => "Float64",
                        Value::Null | Value::Text(_) => "String",
                    };
                    out.push_str(&format!("{{p{next}:{kind}}}"));
                }
            }
        } else {
            let end = rest
                .find(|c: char| !c.is_ascii_lowercase())
                .unwrap_or(rest.len());
            match (&rest[..end], dialect.has_transactions()) {
                (name, true) => out.push_str(name),
                ("sums", false) => out.push_str(&super::sums::asked()),
                (name, false) => {
                    out.push_str(name);
                    out.push_str(" FINAL");
                }
            }
            rest = &rest[end..];
        }
    }
    out.push_str(rest);
    out
}
