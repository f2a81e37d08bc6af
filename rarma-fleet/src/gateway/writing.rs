//! From the boxes' threads into the journal, many records in one transaction.

use super::boxes::Batch;
use super::journal::{Entry, Journal, JournalError};
use super::notices::Notices;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

/// Batches that come within this time go into one transaction.
const TOGETHER: Duration = Duration::from_millis(20);
/// At most so many records.
const MOST: usize = 2000;
/// A disk that is full is tried again after so long.
const AGAIN: Duration = Duration::from_millis(500);

pub(super) fn lock(journal: &Mutex<Journal>) -> MutexGuard<'_, Journal> {
    journal.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Until no box is left. Records are written at once, what is under way with them or every `keep`. What
/// cannot be written is kept and tried again; while it is, boxes wait.
pub(super) fn run(
    batches: &Receiver<Batch>,
    journal: &Mutex<Journal>,
    keep: Duration,
    wake: &Arc<Notify>,
    notices: &Notices,
) {
    let mut full = false;
    // Only the newest of what is under way counts.
    let mut under_way = BTreeMap::new();
    let mut kept = Instant::now();
    let mut left = true;
    while left {
        let mut entries: Vec<Entry> = Vec::new();
        let mut until = kept + keep;
        while entries.len() < MOST {
            match batches.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(batch) => {
                    if entries.is_empty() && !batch.entries.is_empty() {
                        until = until.min(Instant::now() + TOGETHER);
                    }
                    entries.extend(batch.entries);
                    under_way.extend(batch.under_way);
                }
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => {
                    left = false;
                    break;
                }
            }
        }
        kept = Instant::now();
        let states: Vec<(String, String)> = std::mem::take(&mut under_way).into_iter().collect();
        if entries.is_empty() && states.is_empty() {
            continue;
        }
        while let Err(why) = write(journal, &entries, &states, notices) {
            full |= matches!(why, JournalError::Full { .. });
            notices.say(why.to_string());
            std::thread::sleep(AGAIN);
        }
        if std::mem::take(&mut full) {
            notices.note("the journal has room again".to_owned());
        }
        wake.notify_one();
    }
}

fn write(
    journal: &Mutex<Journal>,
    entries: &[Entry],
    under_way: &[(String, String)],
    notices: &Notices,
) -> Result<(), JournalError> {
    let mut journal = lock(journal);
    let before = journal.dropped();
    journal.append(entries, under_way)?;
    if journal.dropped() > before {
        notices.say(format!(
            "the journal is full: {} records went unsent so far, the oldest verdicts first (a store, or a larger `journal_bytes`)",
            journal.dropped()
        ));
    }
    Ok(())
}
