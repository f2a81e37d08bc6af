//! What was stored against what was.

use super::boxes::{Run, SimulatedBox};
use super::gateway::Standing;
use super::store::Stored;
use rarma_core::decide::State as BoxState;
use rarma_fleet::record::{Body, Record, State, Utc};
use std::collections::BTreeSet;

/// What came out.
pub struct Figures {
    /// In words.
    pub said: String,
    /// Part of the time that was not heard.
    pub unheard: f64,
    /// Part of the alarms that were, which were called.
    pub called: f64,
}

/// Nothing is missing between journal and store, nothing there twice, everything in order; and what the
/// records of each box say is what was, second by second, but for what they say was not heard.
pub fn all(boxes: &[SimulatedBox], stored: &Stored, seconds: u64, last: Standing) -> Figures {
    let numbers: Vec<u64> = stored.iter().map(|(n, _)| *n).collect();
    assert_eq!(
        numbers,
        (1..=last.last).collect::<Vec<_>>(),
        "every number once, in order"
    );
    assert_eq!(last.dropped, 0);
    let mut ids = BTreeSet::new();
    for (_, record) in stored {
        assert!(ids.insert(record.id.clone()), "{:?} twice", record.id);
    }
    let start: Utc = "2026-01-05T00:00:00Z".parse().unwrap();
    let (mut calls, mut late, mut unheard_s, mut holes, mut were) = (0, 0, 0.0, 0, 0);
    for (k, one) in boxes.iter().enumerate() {
        let name = format!("box-{k}");
        let records: Vec<&Record> = stored
            .iter()
            .map(|(_, r)| r)
            .filter(|r| r.id.sender.as_str() == name)
            .collect();
        assert!(
            records
                .iter()
                .all(|r| r.id.session == u64::from(one.session))
        );
        assert!(
            records.windows(2).all(|w| w[0].id < w[1].id),
            "{name}: in order"
        );
        let truth = one.truth.lock().unwrap();
        let mut end: Option<f64> = None;
        let mut unheard: Vec<(f64, f64)> = Vec::new();
        for record in &records {
            let Body::Verdict(v) = &record.body else {
                continue;
            };
            let from = record.time.since_s(start);
            if let Some(end) = end {
                assert!(
                    (from - end).abs() < 1e-3,
                    "{name}: hole or overlap at {from} s, expected {end} s"
                );
            }
            end = Some(from + v.seconds);
            if v.reason.as_str() == "not-heard" {
                unheard.push((from, from + v.seconds));
                unheard_s += v.seconds;
                holes += 1;
                if std::env::var_os("RARMA_SHOW_HOLES").is_some() {
                    println!("{name}: {from:.0} s, {:.0} s", v.seconds);
                }
            } else {
                was(&truth.runs, v.state, from, from + v.seconds, &name);
            }
        }
        let end = end.unwrap_or(0.0);
        assert!(
            (end - seconds as f64).abs() < 1e-3,
            "{name}: records end at {end} s"
        );
        let called: Vec<f64> = records
            .iter()
            .filter(|r| matches!(r.body, Body::AlarmCalled(_)))
            .map(|r| r.time.since_s(start))
            .collect();
        for run in truth.runs.iter().filter(|r| r.state == BoxState::Chatter) {
            let (from, to) = (run.from_s as f64, run.to_s as f64);
            let told: Vec<&f64> = called
                .iter()
                .filter(|&&t| t >= from - 1e-3 && t < to)
                .collect();
            let covered = unheard.iter().any(|&(a, b)| a <= from && b >= from);
            assert!(
                told.len() == 1 || covered && told.is_empty(),
                "{name}: {} calls of the chatter at {from} s",
                told.len()
            );
            calls += told.len();
            late += usize::from(told.first().is_some_and(|&&t| t > from + 1e-3));
        }
        let in_truth = truth
            .runs
            .iter()
            .filter(|r| r.state == BoxState::Chatter)
            .count();
        were += in_truth;
        assert!(
            called.len() <= in_truth,
            "{name}: {} calls of {in_truth}",
            called.len()
        );
    }
    let frames: u64 = boxes.iter().map(|b| b.truth.lock().unwrap().frames).sum();
    let time_s = seconds * boxes.len() as u64;
    let said = format!(
        "{} boxes, {seconds} s each, {frames} frames: {} records, each once and in order; {calls} alarms of {were} ({late} told after a hole); not heard {holes} times, {unheard_s:.0} s of {time_s} s",
        boxes.len(),
        stored.len(),
    );
    Figures {
        said,
        unheard: unheard_s / time_s as f64,
        called: if were > 0 {
            calls as f64 / were as f64
        } else {
            1.0
        },
    }
}

fn was(runs: &[Run], state: State, from: f64, to: f64, name: &str) {
    for run in runs {
        let overlap = to.min(run.to_s as f64) - from.max(run.from_s as f64);
        if overlap > 1e-3 {
            assert_eq!(said(run.state), state, "{name}: from {from} s to {to} s");
        }
    }
}

fn said(state: BoxState) -> State {
    match state {
        BoxState::Starting => State::Starting,
        BoxState::Idle => State::Idle,
        BoxState::Stable => State::Stable,
        BoxState::Warning => State::Warning,
        BoxState::Chatter => State::Chatter,
        BoxState::Invalid => State::Invalid,
    }
}
