//! What a database must do for a store.

use super::tables::{Dialect, Table};
pub use super::value::{Rows, StoreError, Value};

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
