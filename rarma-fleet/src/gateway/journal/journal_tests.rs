//! What stays of a journal that is killed, cut, flipped, full and too large.

use super::opening::APPLICATION;
use super::*;
use crate::record::{
    AlarmCalled, Body, Id, Name, Record, SCHEMA, State, Utc, Verdict, from_line, to_line,
};
use proptest::prelude::*;
use std::fs;

fn record(seq: u64, verdict: bool) -> Entry {
    let body = if verdict {
        Body::Verdict(Verdict {
            state: State::Stable,
            reason: Name::new("none").unwrap(),
            seconds: 60.0,
            level: None,
            rpm: None,
            modes: Vec::new(),
        })
    } else {
        Body::AlarmCalled(AlarmCalled {
            f_hz: 900.0,
            zeta: -0.01,
            rpm: None,
            teeth: None,
        })
    };
    let record = Record {
        schema: SCHEMA,
        id: Id {
            sender: Name::new("box-1").unwrap(),
            session: 9,
            seq,
        },
        machine: Name::new("M1").unwrap(),
        time: Utc::from_micros(1_800_000_000_000_000)
            .unwrap()
            .plus_s(60.0 * seq as f64),
        clock: None,
        tool: None,
        operator: None,
        settings: None,
        firmware: None,
        body,
    };
    Entry {
        sender: "box-1".into(),
        verdict,
        line: to_line(&record).unwrap(),
    }
}

fn seq_of(kept: &Kept) -> u64 {
    from_line(&kept.line).unwrap().id.seq
}

fn fill(path: &Path, count: u64) -> Journal {
    let mut journal = Journal::open(path, Limits::default()).unwrap();
    for seq in 1..=count {
        journal
            .append(
                &[record(seq, seq % 5 != 0)],
                &[("box-1".into(), seq.to_string())],
            )
            .unwrap();
    }
    journal
}

#[test]
fn what_was_appended_is_there_after_a_restart() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    let mut journal = fill(&path, 20);
    journal.acknowledge(7).unwrap();
    assert_eq!(
        (journal.next_birth().unwrap(), journal.next_birth().unwrap()),
        (0, 1)
    );
    let identity = journal.identity();
    // As a kill leaves it: nothing is closed.
    std::mem::forget(journal);
    let copy = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(dir.path()).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), copy.path().join(entry.file_name())).unwrap();
    }
    let mut journal = Journal::open(&copy.path().join("journal"), Limits::default()).unwrap();
    assert_eq!(
        (journal.identity(), journal.acknowledged(), journal.last()),
        (identity, 7, 20)
    );
    assert_eq!(journal.next_birth().unwrap(), 2);
    assert_eq!(
        journal.under_way().unwrap(),
        [("box-1".to_owned(), "20".to_owned())]
    );
    let kept = journal.after(7, 100).unwrap();
    assert_eq!(
        kept.iter().map(seq_of).collect::<Vec<_>>(),
        (8..=20).collect::<Vec<_>>()
    );
    assert_eq!((kept[0].previous, kept[12].previous), (7, 19));
}

#[test]
fn two_gateways_do_not_share_a_journal_and_other_files_are_let_be() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    let _first = fill(&path, 1);
    let second = Journal::open(&path, Limits::default());
    assert!(
        matches!(second, Err(JournalError::InUse { .. })),
        "{second:?}"
    );
    let text = dir.path().join("notes.txt");
    fs::write(
        &text,
        "not a journal at all, but somebody's notes, which are long enough to be looked at",
    )
    .unwrap();
    let before = fs::read(&text).unwrap();
    assert!(matches!(
        Journal::open(&text, Limits::default()),
        Err(JournalError::Foreign { .. })
    ));
    assert_eq!(fs::read(&text).unwrap(), before);
    let base = dir.path().join("other.db");
    Connection::open(&base)
        .unwrap()
        .execute_batch("CREATE TABLE mine (x)")
        .unwrap();
    let before = fs::read(&base).unwrap();
    let refused = Journal::open(&base, Limits::default())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("no journal"), "{refused}");
    assert_eq!(fs::read(&base).unwrap(), before);
    Connection::open(&base)
        .unwrap()
        .pragma_update(None, "application_id", APPLICATION)
        .unwrap();
    Connection::open(&base)
        .unwrap()
        .pragma_update(None, "user_version", 7)
        .unwrap();
    let refused = Journal::open(&base, Limits::default())
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("version 7") && refused.contains("later"),
        "{refused}"
    );
}

#[test]
fn a_journal_that_grows_too_large_drops_verdicts_before_alarms_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let line = record(1, true).line.len() as u64;
    let limits = Limits {
        bytes: 100 * line,
        acknowledged_bytes: 10 * line,
    };
    let mut journal = Journal::open(&dir.path().join("journal"), limits).unwrap();
    for seq in 1..=400 {
        journal.append(&[record(seq, seq % 10 != 0)], &[]).unwrap();
        assert!(
            journal.bytes() <= limits.bytes + 4 * line,
            "{} of {}",
            journal.bytes(),
            limits.bytes
        );
    }
    let kept = journal.after(0, 1000).unwrap();
    let records: Vec<Record> = kept.iter().map(|k| from_line(&k.line).unwrap()).collect();
    let alarms = records
        .iter()
        .filter(|r| matches!(r.body, Body::AlarmCalled(_)))
        .count();
    assert_eq!(alarms, 40, "no alarm has gone");
    let told: Vec<&Verdict> = records
        .iter()
        .filter_map(|r| match &r.body {
            Body::Verdict(v) if v.reason.as_str() == "journal-full" => Some(v),
            _ => None,
        })
        .collect();
    assert!(!told.is_empty());
    assert!(
        told.iter()
            .all(|v| v.state == State::Invalid && v.seconds >= 60.0)
    );
    assert!(journal.dropped() > 200, "{}", journal.dropped());
    // What has been acknowledged goes first, and uncounted.
    let dropped = journal.dropped();
    journal.acknowledge(journal.last()).unwrap();
    for seq in 401..=480 {
        journal.append(&[record(seq, true)], &[]).unwrap();
    }
    assert_eq!(journal.dropped(), dropped);
}

#[test]
fn a_file_system_without_room_changes_nothing_and_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let mut journal = fill(&dir.path().join("journal"), 10);
    // What SQLite does when the disk has no page left.
    let pages: i64 = journal
        .base
        .pragma_query_value(None, "page_count", |row| row.get(0))
        .unwrap();
    journal
        .base
        .pragma_update(None, "max_page_count", pages)
        .unwrap();
    let many: Vec<Entry> = (11..400).map(|seq| record(seq, true)).collect();
    let refused = journal.append(&many, &[]).unwrap_err();
    assert!(matches!(refused, JournalError::Full { .. }), "{refused}");
    assert_eq!(
        (journal.last(), journal.after(0, 1000).unwrap().len()),
        (10, 10)
    );
    journal
        .base
        .pragma_update(None, "max_page_count", 1 << 30)
        .unwrap();
    journal.append(&many, &[]).unwrap();
    assert_eq!(journal.after(0, 1000).unwrap().len(), 399);
}

/// The journal's file and its log as a kill leaves them, as bytes.
fn bytes_of(count: u64) -> (Vec<u8>, Vec<u8>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    let journal = fill(&path, count);
    std::mem::forget(journal);
    (
        fs::read(&path).unwrap(),
        fs::read(dir.path().join("journal-wal")).unwrap(),
    )
}

fn reopened(file: &[u8], log: &[u8]) -> (Vec<u64>, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    fs::write(&path, file).unwrap();
    fs::write(dir.path().join("journal-wal"), log).unwrap();
    match Journal::open(&path, Limits::default()) {
        Ok(mut journal) => {
            let kept = journal.after(0, 10_000).unwrap_or_default();
            // Numbers go on: whatever was lost, the next record can be kept.
            let _ = journal.append(&[record(5000, true)], &[]);
            (kept.iter().map(seq_of).collect(), journal.notices.clone())
        }
        Err(why) => (Vec::new(), vec![why.to_string()]),
    }
}

/// Cut anywhere, the log loses its end and never its beginning: what is left is the first records, in
/// order, and as many as were whole.
#[test]
fn a_log_that_is_cut_at_any_place_keeps_what_was_whole() {
    let (file, log) = bytes_of(12);
    let mut most = 0;
    // Every byte of three frames, and every place where a page ends.
    let frame = 4096 + 24;
    let near = 32 + 7 * frame..32 + 7 * frame + 200;
    let places = (0..log.len())
        .filter(|&k| k < 300 || near.contains(&k) || k % 509 == 0 || (k - 32.min(k)) % frame < 2);
    for cut in places.chain([log.len()]) {
        let (seqs, _) = reopened(&file, &log[..cut]);
        assert_eq!(
            seqs,
            (1..=seqs.len() as u64).collect::<Vec<_>>(),
            "cut at {cut}"
        );
        assert!(
            seqs.len() >= most,
            "cut at {cut}: a longer log gave fewer records"
        );
        most = most.max(seqs.len());
    }
    assert_eq!(most, 12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    /// Bits that flip in the file or its log: no crash, and no record that was never written.
    #[test]
    fn flipped_bits_make_no_record(flips in proptest::collection::vec((any::<bool>(), 0.0..1.0_f64, 0..8_u32), 1..6)) {
        flipped(&flips);
    }
}

fn flipped(flips: &[(bool, f64, u32)]) {
    thread_local!(static BYTES: (Vec<u8>, Vec<u8>) = checkpointed(30));
    let (mut file, mut log) = BYTES.with(Clone::clone);
    for &(in_log, part, bit) in flips {
        let bytes = if in_log && !log.is_empty() {
            &mut log
        } else {
            &mut file
        };
        let place = ((bytes.len() - 1) as f64 * part) as usize;
        bytes[place] ^= 1 << bit;
    }
    let (seqs, notices) = reopened(&file, &log);
    let mut sorted = seqs.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(&sorted, &seqs, "in order, and none twice");
    assert!(seqs.iter().all(|&s| (1..=30).contains(&s)), "{seqs:?}");
    assert!(seqs.len() <= 30);
    for notice in &notices {
        assert!(!notice.contains(char::is_control), "{notice:?}");
    }
}

/// A bit in the statement that made a table: SQLite quotes it with its line breaks.
#[test]
fn a_damaged_statement_is_told_on_one_line() {
    for bit in 0..8 {
        for place in 0..40 {
            flipped(&[(true, 0.0, 0), (false, 0.14 + 1e-4 * f64::from(place), bit)]);
        }
    }
}

/// Half of the records in the file itself, half in its log.
fn checkpointed(count: u64) -> (Vec<u8>, Vec<u8>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    let mut journal = fill(&path, count / 2);
    let _ = journal
        .base
        .query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()));
    for seq in count / 2 + 1..=count {
        journal.append(&[record(seq, true)], &[]).unwrap();
    }
    std::mem::forget(journal);
    (
        fs::read(&path).unwrap(),
        fs::read(dir.path().join("journal-wal")).unwrap(),
    )
}

#[test]
fn the_file_of_a_store_is_no_journal_and_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let base = folder.path().join("plant.db");
    drop(crate::store::Store::open(base.to_str().unwrap()).unwrap());
    let before = fs::read(&base).unwrap();
    let refused = Journal::open(&base, Limits::default()).unwrap_err();
    assert!(refused.to_string().contains("no journal"), "{refused}");
    assert_eq!(fs::read(&base).unwrap(), before);
}

#[test]
fn to_look_for_room_touches_nobodys_file() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("gateway.db");
    let name = format!("gateway.db.room-{}", std::process::id());
    for name in ["gateway.probe", &name] {
        fs::write(folder.path().join(name), "mine").unwrap();
        assert!(!no_room(&journal));
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), b"mine");
    }
}
