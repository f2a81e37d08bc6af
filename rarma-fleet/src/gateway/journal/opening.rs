//! A journal is opened, made, or saved from a damaged file.

use super::{Entry, Journal, JournalError, Limits, crc_of, number, other, said, told};
use rusqlite::{Connection, ErrorCode, OptionalExtension};
use std::path::{Path, PathBuf};

/// Version of the file.
pub(crate) const VERSION: i64 = 1;
/// Marks the file as one of these ("rarj"; a store says "rarm").
pub(crate) const APPLICATION: i64 = 0x7261_726a;
const TABLES: &str = "
CREATE TABLE entry (
  seq INTEGER PRIMARY KEY AUTOINCREMENT, box TEXT NOT NULL, verdict INTEGER NOT NULL, crc INTEGER NOT NULL, line TEXT NOT NULL
);
CREATE TABLE under_way (box TEXT PRIMARY KEY, state TEXT NOT NULL);
CREATE TABLE fact (name TEXT PRIMARY KEY, value INTEGER NOT NULL);
";

impl Journal {
    /// Opens a journal, or makes it.
    ///
    /// # Errors
    /// It is somebody else's, in use, or cannot be written.
    pub fn open(path: &Path, limits: Limits) -> Result<Self, JournalError> {
        match Self::attempt(path, limits) {
            Err(Attempt::Broken(why)) => {
                let aside = put_aside(path).map_err(|e| other(path, &e.to_string()))?;
                let mut journal = Self::attempt(path, limits).map_err(|a| a.told(path))?;
                let saved = journal.take_over(&aside);
                journal.notices.push(format!(
                    "{}: damaged ({why}); it lies in {} now, {saved} records of it were taken over",
                    path.display(),
                    aside.display()
                ));
                Ok(journal)
            }
            attempt => attempt.map_err(|a| a.told(path)),
        }
    }

    fn attempt(path: &Path, limits: Limits) -> Result<Self, Attempt> {
        let new = std::fs::metadata(path).is_ok_and(|m| m.len() == 0) || !path.exists();
        let base = Connection::open(path)?;
        base.busy_timeout(std::time::Duration::ZERO)?;
        if new {
            base.pragma_update(None, "application_id", APPLICATION)?;
            base.pragma_update(None, "user_version", VERSION)?;
        }
        let application: i64 = base.pragma_query_value(None, "application_id", |row| row.get(0))?;
        let version: i64 = base.pragma_query_value(None, "user_version", |row| row.get(0))?;
        let foreign = |what: String| Attempt::Foreign(what);
        if application != APPLICATION {
            return Err(foreign("no journal of a gateway".to_owned()));
        }
        if version > VERSION {
            return Err(foreign(format!(
                "a journal of version {version}, made by a later rarma; this one knows {VERSION}"
            )));
        }
        base.pragma_update(None, "locking_mode", "EXCLUSIVE")?;
        let _: String = base.query_row("PRAGMA journal_mode = WAL", [], |row| row.get(0))?;
        base.pragma_update(None, "synchronous", "FULL")?;
        base.pragma_update(None, "journal_size_limit", 4 << 20)?;
        let tables: i64 =
            base.query_row("SELECT count(*) FROM sqlite_master", [], |row| row.get(0))?;
        if tables == 0 {
            base.execute_batch(&format!("BEGIN IMMEDIATE; {TABLES} COMMIT;"))?;
        } else {
            let check: String = base.query_row("PRAGMA quick_check(1)", [], |row| row.get(0))?;
            if check != "ok" {
                return Err(Attempt::Broken(said(&check)));
            }
        }
        let mut journal = Self {
            base,
            path: path.to_owned(),
            limits,
            identity: 0,
            bytes: 0,
            acknowledged: 0,
            acknowledged_bytes: 0,
            last: 0,
            dropped: 0,
            damaged: 0,
            notices: Vec::new(),
        };
        journal.read_facts()?;
        Ok(journal)
    }

    fn read_facts(&mut self) -> rusqlite::Result<()> {
        let base = &self.base;
        let fact = |name: &str| -> rusqlite::Result<Option<i64>> {
            base.query_row("SELECT value FROM fact WHERE name = ?1", [name], |row| {
                row.get(0)
            })
            .optional()
        };
        let identity = match fact("identity")? {
            Some(identity) => identity,
            None => {
                // 53 bits, drawn by SQLite from the system.
                let drawn: i64 =
                    base.query_row("SELECT abs(random() >> 11) + 1", [], |row| row.get(0))?;
                base.execute("INSERT INTO fact VALUES ('identity', ?1)", [drawn])?;
                drawn
            }
        };
        let acknowledged = fact("acknowledged")?.unwrap_or(0);
        let dropped = fact("dropped")?.unwrap_or(0);
        let sums = |from: &str, seq: i64| -> rusqlite::Result<i64> {
            let sql = format!(
                "SELECT coalesce(sum(length(CAST(line AS BLOB))), 0) FROM entry WHERE {from} ?1"
            );
            base.query_row(&sql, [seq], |row| row.get(0))
        };
        let (bytes, acknowledged_bytes) = (sums("seq >", 0)?, sums("seq <=", acknowledged)?);
        let last: i64 = base
            .query_row(
                "SELECT seq FROM sqlite_sequence WHERE name = 'entry'",
                [],
                |row| row.get(0),
            )
            .optional()?
            .unwrap_or(0);
        self.identity = number(identity);
        self.bytes = number(bytes);
        self.acknowledged = number(acknowledged);
        self.acknowledged_bytes = number(acknowledged_bytes);
        self.last = number(last);
        self.dropped = number(dropped);
        Ok(())
    }

    /// Takes over what can be read of a damaged journal: lines whose CRC fits.
    fn take_over(&mut self, aside: &Path) -> usize {
        let Ok(old) = Connection::open(aside) else {
            return 0;
        };
        let fact = |name: &str| -> Option<i64> {
            old.query_row("SELECT value FROM fact WHERE name = ?1", [name], |row| {
                row.get(0)
            })
            .ok()
        };
        let acknowledged = fact("acknowledged").unwrap_or(0);
        let Ok(mut read) =
            old.prepare("SELECT box, verdict, crc, line FROM entry WHERE seq > ?1 ORDER BY seq")
        else {
            return 0;
        };
        let Ok(mut rows) = read.query([acknowledged]) else {
            return 0;
        };
        let mut entries = Vec::new();
        // Reading ends at the first page that cannot be read.
        while let Ok(Some(row)) = rows.next() {
            let entry = (|| -> rusqlite::Result<_> {
                Ok((
                    row.get::<_, String>(0)?,
                    row.get::<_, bool>(1)?,
                    row.get::<_, i64>(2)?,
                    row.get::<_, String>(3)?,
                ))
            })();
            if let Ok((sender, verdict, crc, line)) = entry
                && crc == i64::from(crc_of(&line))
            {
                entries.push(Entry {
                    sender,
                    verdict,
                    line,
                });
            }
        }
        match self.append(&entries, &[]) {
            Ok(()) => entries.len(),
            Err(_) => 0,
        }
    }
}

/// Why a journal was not opened.
enum Attempt {
    Foreign(String),
    Broken(String),
    Sqlite(rusqlite::Error),
}

impl From<rusqlite::Error> for Attempt {
    fn from(why: rusqlite::Error) -> Self {
        match why.sqlite_error_code() {
            Some(ErrorCode::DatabaseCorrupt) => Self::Broken(said(&why)),
            Some(ErrorCode::NotADatabase) => Self::Foreign("no SQLite file".to_owned()),
            _ => Self::Sqlite(why),
        }
    }
}

impl Attempt {
    fn told(self, path: &Path) -> JournalError {
        match self {
            Self::Foreign(what) => JournalError::Foreign {
                file: path.display().to_string(),
                what,
            },
            Self::Broken(why) => other(path, &why),
            Self::Sqlite(why) => told(path, &why),
        }
    }
}

/// Renames a damaged file and what belongs to it; the new name.
fn put_aside(path: &Path) -> std::io::Result<PathBuf> {
    let named = |k: u32, end: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged-{k}{end}"));
        PathBuf::from(name)
    };
    let k = (1..).find(|&k| !named(k, "").exists()).unwrap_or(0);
    for end in ["-wal", "-shm", ""] {
        let mut from = path.as_os_str().to_owned();
        from.push(end);
        match std::fs::rename(&from, named(k, end)) {
            Err(why) if why.kind() != std::io::ErrorKind::NotFound => return Err(why),
            _ => {}
        }
    }
    Ok(named(k, ""))
}
