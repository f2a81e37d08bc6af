//! Values and rows of a database, and why it does not answer.

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
