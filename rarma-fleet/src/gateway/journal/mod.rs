//! The gateway's own memory: records that are not at their store yet, in one SQLite file.
//!
//! * **When it is kept.** A record is kept when [`Journal::append`] comes back: the transaction has been
//!   brought to disk (`synchronous = FULL`). Killing the program or the power costs nothing of it.
//! * **How much.** Lines of records take at most [`Limits::bytes`]. Beyond that the oldest acknowledged
//!   records go first, then the oldest verdicts, then the oldest of all; what goes unsent is counted
//!   ([`Journal::dropped`]) and a record of its time says so (`invalid`, `journal-full`).
//! * **A full disk** is an error of `append` and changes nothing; it is tried again.
//! * **A damaged file.** Each line has a CRC-32. A line that does not fit its CRC is not sent but
//!   counted ([`Journal::damaged`]). A file that SQLite cannot read is put aside, never deleted, and what can
//!   be read of it is taken over.
//! * **Numbers** count up from 1 and are never used twice. The file has an identity, drawn when it was
//!   made, so that a host tells a new file from the old one.

mod loss;
mod opening;
mod room;

pub(crate) use opening::{APPLICATION, VERSION};
use room::{Changed, delete_oldest, make_room};
use rusqlite::{Connection, ErrorCode, OptionalExtension, Transaction, params};
use std::fmt::Display;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Part of the limit that is freed at a time.
const FREED: u64 = 16;

/// How much is kept.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Bytes of lines, those of acknowledged records included.
    pub bytes: u64,
    /// Bytes of lines of acknowledged records that stay, to be sent again if a store was lost.
    pub acknowledged_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            bytes: 1 << 30,
            acknowledged_bytes: 64 << 20,
        }
    }
}

/// Why the journal does not take or give something.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// No room. Nothing was changed; try again.
    #[error("{file}: write: the disk is full (make room; records wait in memory until then)")]
    Full {
        /// The file.
        file: String,
    },
    /// Another gateway has it.
    #[error("{file}: open: another program has this journal (one gateway has one journal)")]
    InUse {
        /// The file.
        file: String,
    },
    /// It is another program's.
    #[error("{file}: open: {what} (name another file for the journal)")]
    Foreign {
        /// The file.
        file: String,
        /// What it is.
        what: String,
    },
    /// Anything else.
    #[error("{file}: {why}")]
    Other {
        /// The file.
        file: String,
        /// What SQLite says.
        why: String,
    },
}

/// A line to be kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The box it is of.
    pub sender: String,
    /// A verdict: goes first where there is no room.
    pub verdict: bool,
    /// The record, one line.
    pub line: String,
}

/// A line that is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Its number.
    pub seq: u64,
    /// Number of the one before it that is still there or was sent; 0: none.
    pub previous: u64,
    /// The box it is of.
    pub sender: String,
    /// The record.
    pub line: String,
}

/// The file of records that are not at their store yet.
#[derive(Debug)]
pub struct Journal {
    base: Connection,
    path: PathBuf,
    limits: Limits,
    identity: u64,
    /// Bytes of all lines.
    bytes: u64,
    acknowledged: u64,
    /// Bytes of the acknowledged ones among them.
    acknowledged_bytes: u64,
    last: u64,
    dropped: u64,
    damaged: u64,
    /// What has to be told: a file that was put aside.
    pub notices: Vec<String>,
}

impl Journal {
    /// Keeps lines, and what is under way of boxes, in one step: all or nothing.
    ///
    /// # Errors
    /// [`JournalError::Full`] and others: nothing was kept.
    pub fn append(
        &mut self,
        entries: &[Entry],
        under_way: &[(String, String)],
    ) -> Result<(), JournalError> {
        let new: u64 = entries.iter().map(|e| e.line.len() as u64).sum();
        let work = (|| -> rusqlite::Result<Changed> {
            let transaction = self.base.transaction()?;
            let mut changed = Changed::default();
            if self.bytes + new > self.limits.bytes {
                let wanted = (self.bytes + new - self.limits.bytes).max(self.limits.bytes / FREED);
                changed = make_room(&transaction, wanted, self.acknowledged)?;
            }
            {
                let mut insert = transaction.prepare_cached(
                    "INSERT INTO entry (box, verdict, crc, line) VALUES (?1, ?2, ?3, ?4)",
                )?;
                for e in changed.told.iter().chain(entries) {
                    insert.execute(params![e.sender, e.verdict, crc_of(&e.line), e.line])?;
                }
                let mut set = transaction
                    .prepare_cached("INSERT OR REPLACE INTO under_way VALUES (?1, ?2)")?;
                for (sender, state) in under_way {
                    set.execute(params![sender, state])?;
                }
            }
            if changed.unsent > 0 {
                set_fact(&transaction, "dropped", self.dropped + changed.unsent)?;
            }
            transaction.commit()?;
            Ok(changed)
        })();
        let changed = work.map_err(|why| self.told(&why))?;
        let told: u64 = changed.told.iter().map(|e| e.line.len() as u64).sum();
        self.bytes = (self.bytes + new + told).saturating_sub(changed.bytes);
        self.acknowledged_bytes = self
            .acknowledged_bytes
            .saturating_sub(changed.acknowledged_bytes);
        self.dropped += changed.unsent;
        if !entries.is_empty() || !changed.told.is_empty() {
            // Of the entries alone: what is under way has row numbers of its own.
            self.last = self.newest().map_err(|why| self.told(&why))?;
        }
        Ok(())
    }

    fn newest(&self) -> rusqlite::Result<u64> {
        let sql = "SELECT seq FROM sqlite_sequence WHERE name = 'entry'";
        self.base.query_row(sql, [], |row| row.get(0)).map(number)
    }

    /// The next lines after a number, in order.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn after(&mut self, seq: u64, most: usize) -> Result<Vec<Kept>, JournalError> {
        let mut kept: Vec<Kept> = Vec::new();
        let mut damaged = Vec::new();
        let work = (|| -> rusqlite::Result<()> {
            let mut read = self.base.prepare_cached(
                "SELECT seq, box, crc, line FROM entry WHERE seq > ?1 ORDER BY seq LIMIT ?2",
            )?;
            let mut rows = read.query(params![integer(seq), integer(most as u64)])?;
            let mut previous = seq;
            while let Some(row) = rows.next()? {
                let found = number(row.get(0)?);
                // Flipped bits may have made the text no text.
                let line = row
                    .get_ref(3)?
                    .as_bytes()
                    .ok()
                    .and_then(|b| std::str::from_utf8(b).ok());
                let crc: i64 = row.get(2).unwrap_or(-1);
                match (line, row.get::<_, String>(1)) {
                    (Some(line), Ok(sender)) if crc == i64::from(crc_of(line)) => kept.push(Kept {
                        seq: found,
                        previous: std::mem::replace(&mut previous, found),
                        sender,
                        line: line.to_owned(),
                    }),
                    _ => damaged.push(found),
                }
            }
            Ok(())
        })();
        work.map_err(|why| self.told(&why))?;
        for seq in damaged {
            self.damaged += 1;
            let _ = self
                .base
                .execute("DELETE FROM entry WHERE seq = ?1", [integer(seq)]);
            self.notices.push(format!(
                "{}: record {seq} is damaged and left out",
                self.path.display()
            ));
        }
        Ok(kept)
    }

    /// Every record up to a number is at its store.
    ///
    /// # Errors
    /// The file cannot be written: it is asked again later, the store takes a record once only.
    pub fn acknowledge(&mut self, seq: u64) -> Result<(), JournalError> {
        let seq = seq.min(self.last);
        if seq <= self.acknowledged {
            return Ok(());
        }
        let limit = self.limits.acknowledged_bytes;
        let (mut bytes, before) = (self.acknowledged_bytes, self.acknowledged);
        let work = (|| -> rusqlite::Result<u64> {
            let transaction = self.base.transaction()?;
            let sum: i64 = transaction.query_row(
                "SELECT coalesce(sum(length(CAST(line AS BLOB))), 0) FROM entry WHERE seq > ?1 AND seq <= ?2",
                [integer(before), integer(seq)],
                |row| row.get(0),
            )?;
            bytes += number(sum);
            set_fact(&transaction, "acknowledged", seq)?;
            let mut freed = 0;
            if bytes > limit {
                let wanted = (bytes - limit).max(limit / FREED);
                freed = delete_oldest(&transaction, "seq <= ?2", seq, wanted)?.bytes;
            }
            transaction.commit()?;
            Ok(freed)
        })();
        let freed = work.map_err(|why| self.told(&why))?;
        self.acknowledged = seq;
        self.acknowledged_bytes = bytes.saturating_sub(freed);
        self.bytes = self.bytes.saturating_sub(freed);
        Ok(())
    }

    /// What was under way of each box when it was last kept.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn under_way(&self) -> Result<Vec<(String, String)>, JournalError> {
        let work = (|| {
            let mut read = self.base.prepare("SELECT box, state FROM under_way")?;
            let rows = read.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
            rows.collect::<rusqlite::Result<Vec<_>>>()
        })();
        work.map_err(|why| self.told(&why))
    }

    /// The number of this connection to a broker: one higher than the last one's, from 0 to 255.
    ///
    /// # Errors
    /// It cannot be kept.
    pub fn next_birth(&mut self) -> Result<u8, JournalError> {
        let work = (|| -> rusqlite::Result<u8> {
            let transaction = self.base.transaction()?;
            let sql = "SELECT value FROM fact WHERE name = 'birth'";
            let before: Option<u8> = transaction
                .query_row(sql, [], |row| row.get(0))
                .optional()?;
            let next = before.map_or(0, |b| b.wrapping_add(1));
            set_fact(&transaction, "birth", u64::from(next))?;
            transaction.commit()?;
            Ok(next)
        })();
        work.map_err(|why| self.told(&why))
    }

    /// Drawn when the file was made.
    #[must_use]
    pub fn identity(&self) -> u64 {
        self.identity
    }

    /// Highest number that is at its store.
    #[must_use]
    pub fn acknowledged(&self) -> u64 {
        self.acknowledged
    }

    /// Highest number there is.
    #[must_use]
    pub fn last(&self) -> u64 {
        self.last
    }

    /// Records that went unsent because there was no room.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Records that were damaged on disk, since it was opened.
    #[must_use]
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Bytes of all lines.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    fn told(&self, why: &rusqlite::Error) -> JournalError {
        told(&self.path, why)
    }
}

fn told(path: &Path, why: &rusqlite::Error) -> JournalError {
    let file = path.display().to_string();
    match why.sqlite_error_code() {
        // What SQLite says of a write that the system does not take for want of room.
        Some(ErrorCode::DiskFull) => JournalError::Full { file },
        Some(ErrorCode::SystemIoFailure) if no_room(path) => JournalError::Full { file },
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => JournalError::InUse { file },
        _ => other(path, &said(why)),
    }
}

/// What SQLite says, on one line: it quotes statements that stand in the file, damaged ones too.
fn said(what: &impl Display) -> String {
    let text = what.to_string();
    let words = text.split(|c: char| c.is_control() || c == ' ');
    let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

/// Whether a small file beside the journal cannot be written for want of room. A file of that name that is
/// there already is somebody's, and is not touched.
fn no_room(path: &Path) -> bool {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".room-{}", std::process::id()));
    let no_room = |why: &std::io::Error| why.kind() == std::io::ErrorKind::StorageFull;
    match File::create_new(&name) {
        Ok(mut probe) => {
            let full = probe.write_all(&[0; 4096]).is_err_and(|why| no_room(&why));
            let _ = std::fs::remove_file(&name);
            full
        }
        Err(why) => no_room(&why),
    }
}

fn other(path: &Path, why: &str) -> JournalError {
    JournalError::Other {
        file: path.display().to_string(),
        why: why.to_owned(),
    }
}

fn set_fact(transaction: &Transaction<'_>, name: &str, value: u64) -> rusqlite::Result<()> {
    transaction
        .prepare_cached("INSERT OR REPLACE INTO fact VALUES (?1, ?2)")?
        .execute(params![name, integer(value)])
        .map(drop)
}

/// What stands beside a line, so that a damaged one is known.
pub(crate) fn crc_of(line: &str) -> u32 {
    const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    CRC.checksum(line.as_bytes())
}

/// SQLite's numbers have a sign; these never need it.
fn integer(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

fn number(integer: i64) -> u64 {
    u64::try_from(integer).unwrap_or(0)
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
