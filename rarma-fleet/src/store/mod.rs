//! Records kept for years, and asked.
//!
//! One schema (`tables`), one set of questions (`ask`), three places: SQLite in one file,
//! PostgreSQL, ClickHouse. A [`Backend`] runs SQL and inserts rows; everything else, ingest and
//! questions, is written once in [`Store`], so that the same records give the same answers.

mod ask;
mod backend;
mod clickhouse;
mod ingest;
mod journal;
mod postgres;
mod sink;
mod sqlite;
mod sums;
mod tables;
mod thin;
mod value;
mod way;

pub use ask::{AdviceCount, AlarmCount, By, Contents, Machine, MachineReading, Span, StateTime};
pub use backend::{Backend, StoreError, Value};
pub use ingest::Taken;
pub use journal::is_journal;
pub use sink::Receiving;
pub use tables::{Dialect, TABLES, statements};
pub use thin::Thinned;

/// Version of the tables.
pub const TABLES_VERSION: i64 = 2;

/// A store of records.
pub struct Store {
    backend: Box<dyn Backend>,
}

impl Store {
    /// Opens what `place` names, and makes its tables where there are none:
    /// `postgres://USER:PASSWORD@HOST/DATABASE`, `clickhouse://USER:PASSWORD@HOST:8123/DATABASE`, else a
    /// file of SQLite. To a database behind `?sslrootcert=FILE` the certificates (PEM) that are trusted: TLS is spoken
    /// then, and the server's name is checked. Without it only a database on this computer is spoken to, or any
    /// with `?sslmode=disable`. A password that is left out is taken from `PGPASSWORD` or `CLICKHOUSE_PASSWORD`.
    ///
    /// # Errors
    /// [`StoreError`]: what is there is not ours, is of a later version, does not answer, or is not reached safely.
    pub fn open(place: &str) -> Result<Self, StoreError> {
        let backend: Box<dyn Backend> =
            if place.starts_with("postgres://") || place.starts_with("postgresql://") {
                Box::new(postgres::Postgres::open(place)?)
            } else if let Some(rest) = place.strip_prefix("clickhouse://") {
                Box::new(clickhouse::ClickHouse::open(rest)?)
            } else {
                Box::new(sqlite::Sqlite::open(std::path::Path::new(place))?)
            };
        let mut store = Self { backend };
        store.prepare()?;
        Ok(store)
    }

    /// Makes the tables, or refuses those of a later version.
    fn prepare(&mut self) -> Result<(), StoreError> {
        let (meta, others): (Vec<String>, _) = statements(self.backend.dialect())
            .into_iter()
            .partition(|sql| sql.contains(" meta "));
        for statement in meta {
            self.backend.execute(&statement)?;
        }
        let version = self.meta("tables")?;
        if let Some(found) = version.filter(|&found| found > TABLES_VERSION) {
            return Err(StoreError::Version {
                found,
                known: TABLES_VERSION,
            });
        }
        for statement in others {
            self.backend.execute(&statement)?;
        }
        match version {
            None => self.set_meta("tables", TABLES_VERSION),
            Some(1) => self.take_over_version_1(),
            Some(_) => Ok(()),
        }
    }

    /// Version 1 had no sums, and other indices. Tables of before that are there already, empty.
    fn take_over_version_1(&mut self) -> Result<(), StoreError> {
        if !self.backend.dialect().has_transactions() {
            return self.set_meta("tables", TABLES_VERSION);
        }
        let mut statements: Vec<String> = ["records_0", "records_1", "records_2", "readings_0"]
            .map(|index| format!("DROP INDEX IF EXISTS {index}"))
            .into();
        let closed = self.meta("thinned_before_us")?.unwrap_or(0);
        statements.extend(thin::leavings(closed));
        statements.extend(sums::anew("kind <> ''"));
        statements.push(put("tables", TABLES_VERSION));
        self.backend.execute_all(&statements)
    }

    /// A number that the store remembers of itself.
    fn meta(&mut self, name: &str) -> Result<Option<i64>, StoreError> {
        let rows = self.backend.query(
            "SELECT value FROM @meta WHERE name = ?",
            &[Value::from(name)],
        )?;
        rows.first().map(|row| row[0].int()).transpose()
    }

    fn set_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError> {
        self.backend.put_meta(name, value)
    }
}

/// A statement that remembers a number, for databases with transactions.
fn put(name: &str, value: i64) -> String {
    format!(
        "INSERT INTO meta VALUES ('{name}', {value}) ON CONFLICT (name) DO UPDATE SET value = excluded.value"
    )
}
