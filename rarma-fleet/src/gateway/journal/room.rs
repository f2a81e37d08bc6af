//! Room in a journal that is full: what goes first, and who tells of it.

use super::loss;
use super::{Entry, integer};
use rusqlite::Transaction;

/// What was taken away.
#[derive(Default)]
pub(super) struct Changed {
    pub bytes: u64,
    pub acknowledged_bytes: u64,
    /// Records that had not been sent.
    pub unsent: u64,
    /// Records that tell of them.
    pub told: Vec<Entry>,
}

/// Frees bytes: acknowledged records, then verdicts, then all, the oldest first.
pub(super) fn make_room(
    transaction: &Transaction<'_>,
    wanted: u64,
    acknowledged: u64,
) -> rusqlite::Result<Changed> {
    let sent = delete_oldest(transaction, "seq <= ?2", acknowledged, wanted)?;
    let mut changed = Changed {
        bytes: sent.bytes,
        acknowledged_bytes: sent.bytes,
        ..Changed::default()
    };
    for of in ["seq > ?2 AND verdict", "seq > ?2"] {
        if changed.bytes >= wanted {
            break;
        }
        let deleted = delete_oldest(transaction, of, acknowledged, wanted - changed.bytes)?;
        changed.bytes += deleted.bytes;
        changed.unsent += loss::count(&deleted.lines);
        changed.told.extend(loss::told(&deleted.lines));
    }
    Ok(changed)
}

pub(super) struct Deleted {
    pub bytes: u64,
    lines: Vec<String>,
}

pub(super) fn delete_oldest(
    transaction: &Transaction<'_>,
    of: &str,
    seq: u64,
    wanted: u64,
) -> rusqlite::Result<Deleted> {
    let mut deleted = Deleted {
        bytes: 0,
        lines: Vec::new(),
    };
    let mut gone = Vec::new();
    {
        let sql = format!("SELECT seq, line FROM entry WHERE seq > ?1 AND {of} ORDER BY seq");
        let mut read = transaction.prepare_cached(&sql)?;
        let mut rows = read.query([0, integer(seq)])?;
        while deleted.bytes < wanted
            && let Some(row) = rows.next()?
        {
            let line: String = row.get(1)?;
            deleted.bytes += line.len() as u64;
            gone.push(row.get::<_, i64>(0)?);
            deleted.lines.push(line);
        }
    }
    let mut delete = transaction.prepare_cached("DELETE FROM entry WHERE seq = ?1")?;
    for seq in gone {
        delete.execute([seq])?;
    }
    Ok(deleted)
}
