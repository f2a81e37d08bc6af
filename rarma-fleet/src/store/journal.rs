//! Records out of a gateway's journal, where no broker brings them.

use super::{Store, StoreError, Taken};
use crate::gateway::journal::{APPLICATION, VERSION, crc_of};
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::io::Read;
use std::path::Path;

/// Where SQLite keeps whose file it is, bytes from its beginning.
const APPLICATION_AT: usize = 68;
/// How every file of SQLite begins.
const SQLITE: &[u8] = b"SQLite format 3\0";
/// Lines that are taken together.
const TOGETHER: i64 = 4096;

/// Is that file the journal of a gateway?
#[must_use]
pub fn is_journal(path: &Path) -> bool {
    let mut head = [0; APPLICATION_AT + 4];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut head));
    let whose = head[APPLICATION_AT..].first_chunk();
    read.is_ok()
        && head.starts_with(SQLITE)
        && whose.is_some_and(|whose| i64::from(i32::from_be_bytes(*whose)) == APPLICATION)
}

impl Store {
    /// Takes all records that a gateway's journal still has, acknowledged or not, in their order. The journal is only
    /// read, and its gateway must not run. An entry that is damaged or no record is given to `refused` with its number, and
    /// passed over.
    ///
    /// # Errors
    /// The journal is in use, damaged or of a later version, or the database refuses; what was taken before is there.
    pub fn add_journal(
        &mut self,
        path: &Path,
        mut refused: impl FnMut(i64, &str),
    ) -> Result<Taken, StoreError> {
        let journal = opened(path).map_err(|why| told(&why))?;
        let version: i64 = journal
            .pragma_query_value(None, "user_version", |row| row.get(0))
            .map_err(|why| told(&why))?;
        if version > VERSION {
            return Err(StoreError::Version {
                found: version,
                known: VERSION,
            });
        }
        let mut taken = Taken::default();
        let mut after = 0;
        loop {
            let entries = entries(&journal, after).map_err(|why| told(&why))?;
            let Some(&(last, ..)) = entries.last() else {
                return Ok(taken);
            };
            after = last;
            let mut sound = Vec::new();
            for (number, crc, line) in entries {
                match line {
                    Some(line) if crc == i64::from(crc_of(&line)) => {
                        sound.push((number, line));
                    }
                    _ => refused(number, "damaged: its check does not fit"),
                }
            }
            let lines = sound.iter().map(|(_, line)| line.as_str());
            let more = self.add_lines(lines, |place, why| {
                refused(sound[place].0, &why.to_string());
            })?;
            taken.add(more);
        }
    }
}

/// For reading. A journal that was closed has no log beside it and gets none; the log of one that was killed is read.
fn opened(path: &Path) -> rusqlite::Result<Connection> {
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
    match path.to_str() {
        Some(text) if !Path::new(&log).exists() => {
            let mut escaped = text.replace('%', "%25");
            escaped = escaped.replace('?', "%3f").replace('#', "%23");
            Connection::open_with_flags(format!("file:{escaped}?immutable=1"), flags)
        }
        _ => Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY),
    }
}

/// Number, CRC and line of the next entries; no line where it is no text.
type Entries = Vec<(i64, i64, Option<String>)>;

fn entries(journal: &Connection, after: i64) -> rusqlite::Result<Entries> {
    let mut read = journal.prepare_cached(
        "SELECT seq, crc, CAST(line AS BLOB) FROM entry WHERE seq > ?1 ORDER BY seq LIMIT ?2",
    )?;
    let entry = |row: &rusqlite::Row<'_>| {
        let line: Vec<u8> = row.get(2)?;
        Ok((row.get(0)?, row.get(1)?, String::from_utf8(line).ok()))
    };
    read.query_map([after, TOGETHER], entry)?.collect()
}

fn told(why: &rusqlite::Error) -> StoreError {
    let remedy = match why.sqlite_error_code() {
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            " (its gateway has it: end that first)"
        }
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
            " (damaged: start its gateway, which saves what can be read)"
        }
        _ => "",
    };
    StoreError::Database(format!("journal: {why}{remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::journal::{Entry, Journal, Limits};
    use crate::plant::{Fate, Plant, PlantConfig};
    use crate::record::to_line;

    /// Lines of a plant, in a journal that its gateway's own code writes.
    fn lines() -> Vec<String> {
        let mut plant = Plant::new(PlantConfig {
            machines: 2,
            days: 60,
            start: "2025-01-01T00:00:00Z".parse().unwrap(),
            seed: 4,
            fate: Fate::Usual,
            tests_only: false,
        });
        let records = std::iter::from_fn(|| plant.next_day()).flatten();
        records.map(|r| to_line(&r).unwrap()).take(5000).collect()
    }

    fn journal(path: &Path, lines: &[String]) -> Journal {
        let mut journal = Journal::open(path, Limits::default()).unwrap();
        let entry = |line: &String| Entry {
            sender: "box".to_owned(),
            verdict: false,
            line: line.clone(),
        };
        let entries: Vec<Entry> = lines.iter().map(entry).collect();
        journal.append(&entries, &[]).unwrap();
        journal
    }

    fn contents(store: &mut Store) -> i64 {
        store.contents().unwrap().iter().map(|c| c.records).sum()
    }

    #[test]
    fn a_journal_is_taken_once_and_not_touched() {
        let folder = tempfile::tempdir().unwrap();
        // Letters that an address would take for something else.
        let path = folder.path().join("re?co%20rds#1.db");
        let lines = lines();
        let mut all = journal(&path, &lines);
        all.acknowledge(3000).unwrap();
        assert!(is_journal(&path));
        let mut store = Store::open(folder.path().join("a.db").to_str().unwrap()).unwrap();
        let said = store.add_journal(&path, |_, _| ()).unwrap_err().to_string();
        assert!(said.contains("its gateway has it"), "{said}");
        drop(all);
        let before = std::fs::read(&path).unwrap();
        let mut direct = Store::open(folder.path().join("b.db").to_str().unwrap()).unwrap();
        let expected = direct
            .add_lines(lines.iter().map(String::as_str), |_, _| ())
            .unwrap();
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let beside = files();
        for round in 0..2 {
            let taken = store
                .add_journal(&path, |number, why| panic!("{number}: {why}"))
                .unwrap();
            assert_eq!(taken.new, if round == 0 { expected.new } else { 0 });
        }
        assert_eq!(contents(&mut store), contents(&mut direct));
        assert_eq!((std::fs::read(&path).unwrap(), files()), (before, beside));
        assert!(!is_journal(&folder.path().join("a.db")), "a store is none");
    }

    #[test]
    fn a_journal_whose_gateway_was_killed_is_read_with_its_log_and_a_broken_line_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("records.db");
        let lines = lines();
        let running = journal(&path, &lines[..100]);
        // As a kill leaves it: the file and its log, in the middle of nothing.
        let killed = folder.path().join("killed.db");
        std::fs::copy(&path, &killed).unwrap();
        std::fs::copy(
            folder.path().join("records.db-wal"),
            folder.path().join("killed.db-wal"),
        )
        .unwrap();
        drop(running);
        let mut store = Store::open(folder.path().join("a.db").to_str().unwrap()).unwrap();
        let taken = store.add_journal(&killed, |n, why| panic!("{n}: {why}"));
        assert_eq!(taken.unwrap().new, 100);

        let raw = Connection::open(&path).unwrap();
        raw.execute(
            "UPDATE entry SET line = replace(line, 'M001', 'M009') WHERE seq = 7",
            [],
        )
        .unwrap();
        raw.execute(
            "UPDATE entry SET line = CAST(x'ff' AS TEXT) WHERE seq = 8",
            [],
        )
        .unwrap();
        drop(raw);
        let mut store = Store::open(folder.path().join("b.db").to_str().unwrap()).unwrap();
        let mut told = Vec::new();
        let taken = store.add_journal(&path, |n, why| told.push((n, why.to_owned())));
        assert_eq!(taken.unwrap().new, 98);
        assert_eq!(told.iter().map(|t| t.0).collect::<Vec<_>>(), [7, 8]);

        Connection::open(&path)
            .unwrap()
            .pragma_update(None, "user_version", 2)
            .unwrap();
        let said = store.add_journal(&path, |_, _| ()).unwrap_err().to_string();
        assert!(said.contains("version 2"), "{said}");
    }
}
