//! A box: it numbers what it says, has a clock of its own, and is sometimes not there.

use super::says::Said;
use crate::record::{Body, Clock, Record};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Times a year that a box drops out, and most days for which it does.
const DROPS: f64 = 2.0;
const MOST_DAYS: f64 = 25.0;
/// Days between two starts of a box.
const START_DAYS: u32 = 30;
/// One record in so many comes twice.
const TWICE_ONE_IN: f64 = 1000.0;

/// A sensor box.
pub(super) struct SensorBox {
    /// Days for which it does not deliver; it keeps its records and delivers them afterwards.
    pub dropped: Vec<(f64, f64)>,
    /// How much faster than UTC its clock runs, millionths.
    pub drift_ppm: f64,
    session: u64,
    started_day: f64,
    seq: u64,
    kept: Vec<Record>,
}

impl SensorBox {
    pub fn draw(days: u32, rng: &mut ChaCha8Rng) -> Self {
        let mut dropped = Vec::new();
        let mut day = 0.0;
        while day < f64::from(days) {
            day += 1.0;
            if rng.random::<f64>() < DROPS / 365.0 {
                let until = day + rng.random_range(0.2..MOST_DAYS);
                dropped.push((day, until));
                day = until + 20.0;
            }
        }
        Self {
            dropped,
            drift_ppm: rng.random_range(-40.0..40.0),
            session: 0,
            started_day: 0.0,
            seq: 0,
            kept: Vec::new(),
        }
    }

    /// What arrives of a day.
    pub fn day(&mut self, day: u32, mut said: Vec<Said>, rng: &mut ChaCha8Rng) -> Vec<Record> {
        if day.is_multiple_of(START_DAYS) {
            self.session = u64::from(rng.random::<u32>()).max(1);
            self.started_day = f64::from(day);
            self.seq = 0;
        }
        // The list's places are what records of the same day call each other by: the order stays.
        let first = self.seq;
        for Said { day: at, record } in &mut said {
            record.id.session = self.session;
            record.id.seq = self.seq;
            self.seq += 1;
            match &mut record.body {
                Body::AlarmReleased(a) => a.called += first,
                Body::Advice(a) => a.called = a.called.map(|n| n + first),
                Body::Outcome(o) => o.advice += first,
                _ => {}
            }
            let true_s = (*at - self.started_day) * 86_400.0;
            record.clock = Some(Clock {
                box_s: true_s * (1.0 + self.drift_ppm * 1e-6),
                drift_ppm: Some(self.drift_ppm + rng.random_range(-0.5..0.5)),
                drift_sd_ppm: Some(0.3),
                time_sd_s: Some(0.02),
            });
        }
        let records = said.into_iter().map(|s| s.record);
        let away = self
            .dropped
            .iter()
            .any(|&(from, to)| from <= f64::from(day) && f64::from(day) < to);
        if away {
            self.kept.extend(records);
            return Vec::new();
        }
        // What was kept comes after what is new: out of order.
        let mut out: Vec<Record> = records.collect();
        out.append(&mut self.kept);
        let twice: Vec<Record> = out
            .iter()
            .filter(|_| rng.random::<f64>() < 1.0 / TWICE_ONE_IN)
            .cloned()
            .collect();
        out.extend(twice);
        out
    }

    /// What it still keeps.
    pub fn rest(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.kept)
    }
}
