//! Records that went unsent for want of room, told as records of their time.

use super::Entry;
use crate::gateway::words;
use crate::record::{Body, Record, State, Utc, Verdict, from_line, to_line};
use std::collections::BTreeMap;

/// The reason of these records.
const REASON: &str = "journal-full";

/// How many lines are records of something, and not these.
pub fn count(lines: &[String]) -> u64 {
    lines.iter().filter(|line| !line.contains(REASON)).count() as u64
}

/// For each run of a box one record that spans those that went: `invalid`, `journal-full`. It has the
/// name of the first of them, whose place it takes.
pub fn told(lines: &[String]) -> Vec<Entry> {
    let mut spans: BTreeMap<_, (Record, Utc)> = BTreeMap::new();
    for record in lines.iter().filter_map(|line| from_line(line).ok()) {
        let seconds = match &record.body {
            Body::Verdict(v) => v.seconds,
            _ => 0.0,
        };
        let end = record.time.plus_s(seconds);
        let key = (record.id.sender.clone(), record.id.session);
        let span = spans.entry(key).or_insert_with(|| (record.clone(), end));
        if record.id.seq < span.0.id.seq {
            span.0.id.seq = record.id.seq;
        }
        span.0.time = span.0.time.min(record.time);
        span.1 = span.1.max(end);
    }
    let entry = |(mut record, end): (Record, Utc)| {
        record.body = Body::Verdict(Verdict {
            state: State::Invalid,
            reason: words::name(REASON),
            seconds: end.since_s(record.time).max(0.0),
            level: None,
            rpm: None,
            modes: Vec::new(),
        });
        Some(Entry {
            sender: record.id.sender.to_string(),
            // Where room is made again it goes, too, and its span into the next one of these.
            verdict: true,
            line: to_line(&record).ok()?,
        })
    };
    spans.into_values().filter_map(entry).collect()
}
