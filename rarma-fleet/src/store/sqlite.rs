//! A store in one file, with nothing to install.

use super::backend::{Backend, Rows, StoreError, Value, spelled};
use super::sums;
use super::tables::{Dialect, Table};
use rusqlite::types::{ToSql, ToSqlOutput, ValueRef};
use rusqlite::{Connection, OpenFlags};
use std::path::Path;
use std::time::Duration;

/// What SQLite keeps in a file's head to tell whose it is: "rarm".
const APPLICATION: i64 = 0x7261_726d;

/// Pages of 4 KiB that the log beside the file takes before they go into the file: 64 MiB. Boxes write into places of their
/// own, so that each page is changed by many portions; the more of them meet in the log, the fewer go into the file. A
/// year of fifty machines, in s, at SQLite's own 1000 pages, at 4000, 16 000 and 64 000: 49, 43, 32, 27. Beyond it the log
/// is a good part of a small store.
const LOG_PAGES: u32 = 16_384;

/// A file.
pub struct Sqlite {
    connection: Connection,
}

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        use rusqlite::ErrorCode::{
            DatabaseBusy, DatabaseCorrupt, DiskFull, NotADatabase, ReadOnly,
        };
        let remedy = match error.sqlite_error_code() {
            Some(DiskFull) => " (make room: what was stored before is whole)",
            Some(DatabaseBusy) => " (another program writes to it: try again)",
            Some(NotADatabase) => " (name another file: this one is no store)",
            Some(DatabaseCorrupt) => " (restore it from a copy, or build it anew from journals)",
            Some(ReadOnly) => " (check the rights of the file and its folder)",
            _ => "",
        };
        let said = format!("{error}{remedy}");
        match error.sqlite_error_code() {
            Some(NotADatabase) => Self::Foreign(said),
            _ => Self::Database(said),
        }
    }
}

impl Sqlite {
    /// Opens or makes a file.
    ///
    /// # Errors
    /// It cannot be opened, is no database, or is that of another program: it is not touched.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        if path.is_dir() {
            return Err(StoreError::Foreign(
                "it is a folder (name a file)".to_owned(),
            ));
        }
        let new = !path.exists() || std::fs::metadata(path).is_ok_and(|m| m.len() == 0);
        if !new {
            // Read only: a file that is not ours gets no journal beside it.
            let look = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
            let found: i64 = look.query_row("PRAGMA application_id", [], |row| row.get(0))?;
            let tables: i64 =
                look.query_row("SELECT count(*) FROM sqlite_master", [], |row| row.get(0))?;
            if found != APPLICATION && tables > 0 {
                return Err(StoreError::Foreign(
                    "a database of another program (name another file: it was not touched)"
                        .to_owned(),
                ));
            }
        }
        let connection = Connection::open(path)?;
        connection.busy_timeout(Duration::from_secs(10))?;
        connection.set_prepared_statement_cache_capacity(64);
        // A log beside the file: a reader does not wait for a writer, and a program that is killed
        // leaves what was committed. FULL: what was acknowledged survives a power cut, too.
        connection.execute_batch(&format!(
            "PRAGMA application_id = {APPLICATION}; PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; \
             PRAGMA wal_autocheckpoint = {LOG_PAGES}; PRAGMA cache_size = -65536; PRAGMA temp_store = MEMORY;"
        ))?;
        Ok(Self { connection })
    }
}

impl ToSql for Value {
    fn to_sql(&self) -> rusqlite::Result<ToSqlOutput<'_>> {
        Ok(ToSqlOutput::Borrowed(match self {
            Self::Null => ValueRef::Null,
            Self::Int(n) => ValueRef::Integer(*n),
            Self::Real(x) => ValueRef::Real(*x),
            Self::Text(t) => ValueRef::Text(t.as_bytes()),
        }))
    }
}

impl Backend for Sqlite {
    fn dialect(&self) -> Dialect {
        Dialect::Sqlite
    }

    fn execute(&mut self, sql: &str) -> Result<(), StoreError> {
        Ok(self.connection.execute_batch(sql)?)
    }

    fn execute_all(&mut self, statements: &[String]) -> Result<(), StoreError> {
        let transaction = self.connection.transaction()?;
        for statement in statements {
            transaction.execute_batch(statement)?;
        }
        Ok(transaction.commit()?)
    }

    fn query(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError> {
        let sql = spelled(Dialect::Sqlite, sql, parameters);
        let mut statement = self.connection.prepare_cached(&sql)?;
        let width = statement.column_count();
        let mut found = statement.query(rusqlite::params_from_iter(parameters))?;
        let mut rows = Vec::new();
        while let Some(row) = found.next()? {
            let mut values = Vec::with_capacity(width);
            for place in 0..width {
                values.push(match row.get_ref(place)? {
                    ValueRef::Null => Value::Null,
                    ValueRef::Integer(n) => Value::Int(n),
                    ValueRef::Real(x) => Value::Real(x),
                    ValueRef::Text(t) | ValueRef::Blob(t) => {
                        Value::Text(String::from_utf8_lossy(t).into_owned())
                    }
                });
            }
            rows.push(values);
        }
        Ok(rows)
    }

    fn insert(&mut self, rows: &[(&'static Table, Rows)]) -> Result<(), StoreError> {
        let transaction = self.connection.transaction()?;
        for (table, rows) in rows {
            let marks = vec!["?"; table.columns.len()].join(", ");
            let sql = format!(
                "INSERT INTO {} VALUES ({marks}) ON CONFLICT DO NOTHING",
                table.name
            );
            let mut statement = transaction.prepare_cached(&sql)?;
            let mut new = Vec::new();
            for row in rows {
                if statement.execute(rusqlite::params_from_iter(row))? == 1 && table.summed {
                    new.push(row);
                }
            }
            if !new.is_empty() {
                let sql = format!(
                    "INSERT INTO sums VALUES (?, ?, ?, ?, ?, ?, ?, ?) {}",
                    sums::ADD
                );
                let mut add = transaction.prepare_cached(&sql)?;
                for row in sums::of_rows(new.into_iter()) {
                    add.execute(rusqlite::params_from_iter(row))?;
                }
            }
        }
        Ok(transaction.commit()?)
    }

    fn put_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError> {
        self.connection.execute(
            "INSERT INTO meta VALUES (?1, ?2) ON CONFLICT (name) DO UPDATE SET value = excluded.value",
            rusqlite::params![name, value],
        )?;
        Ok(())
    }
}
