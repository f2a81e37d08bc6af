//! Recordings in universal files: datasets 58 and 58b over time, each a channel.

use super::blocks::{Begin, Blocks, End};
use super::bytes::Bytes;
use super::receptance::uff_numbers::{
    Cursor, columns, cut_short, each_dataset, field, number, whole,
};
use super::whole::MOST_TABLE;
use super::{InputError, Problem, no_channel};

/// Function types that are taken, if they lie over time: general, time response.
const TAKEN: [i64; 2] = [0, 1];
/// Type of an abscissa of time.
const TIME: i64 = 17;
/// Samples handed on at once.
const BLOCK: usize = 1 << 13;
/// The step has six digits: a rate within so much of a whole one is that.
const WHOLE: f64 = 1e-5;

/// One record.
struct Record {
    step: f64,
    unit: Option<String>,
    samples: Vec<f64>,
}

/// Reads all of it: where a channel lies is known at the end only.
pub(super) fn begin(mut bytes: Bytes, fs: Option<f64>) -> Result<Begin, InputError> {
    while bytes.more()? {
        if bytes.waiting().len() as u64 > MOST_TABLE {
            return Err(InputError::new(
                Problem::Size,
                format!("byte {MOST_TABLE}"),
                format!("a universal file of more than {MOST_TABLE} bytes is not read"),
                "cut it, or export WAV",
            ));
        }
    }
    let (records, others) = read(bytes.waiting())?;
    let Some(first) = records.first() else {
        return Err(InputError::new(
            Problem::NoSamples,
            "whole file",
            format!("no record over time (dataset 58, function type 1); {others} of other types"),
            "export time histories, or give it to `rarma els limit` if it holds receptances",
        ));
    };
    for (k, record) in records.iter().enumerate() {
        let same = (record.step / first.step - 1.0).abs() < WHOLE;
        if !same || record.samples.len() != first.samples.len() {
            return Err(InputError::new(
                Problem::Unsupported,
                format!("record {}", k + 1),
                "its step or length is not that of the first",
                "export the channels over one time axis",
            ));
        }
    }
    let told = 1.0 / first.step;
    let told = if (told / told.round() - 1.0).abs() < WHOLE {
        told.round()
    } else {
        told
    };
    let mut notices = Vec::new();
    if let Some(fs) = fs.filter(|fs| *fs != told) {
        notices.push(format!("header says {told} Hz: --fs {fs} Hz used instead"));
    }
    if others > 0 {
        notices.push(format!(
            "{others} datasets that are no records over time were left out"
        ));
    }
    let fs = fs.unwrap_or(told);
    let units: Vec<&str> = records
        .iter()
        .map(|r| r.unit.as_deref().unwrap_or("an unknown unit"))
        .collect();
    Ok(Begin {
        format: format!("universal file, in {}", units.join(", ")),
        fs: Some(fs),
        step: None,
        channels: records.len(),
        blocks: Box::new(Held {
            records,
            wanted: Vec::new(),
            at: 0,
            end: End { fs, notices },
        }),
    })
}

/// The records over time, and how many datasets 58 are something else.
fn read(bytes: &[u8]) -> Result<(Vec<Record>, usize), InputError> {
    let (mut records, mut others) = (Vec::new(), 0);
    each_dataset(bytes, |cursor, _, kind| {
        if matches!(kind.split_whitespace().next(), Some("58" | "58b")) {
            match record(cursor, kind)? {
                Some(record) => records.push(record),
                None => others += 1,
            }
        }
        Ok(())
    })?;
    Ok((records, others))
}

/// A dataset behind its number; none if it is no record over time.
fn record(cursor: &mut Cursor<'_>, kind: &str) -> Result<Option<Record>, InputError> {
    let mut head: Vec<(usize, String)> = Vec::with_capacity(11);
    for _ in 0..11 {
        let (line, text) = cursor.line().ok_or_else(|| cut_short(cursor.line))?;
        if text.trim() == "-1" {
            return Err(cut_short(line));
        }
        head.push((line, text));
    }
    let (line7, r7) = &head[6];
    let data_type = whole(*line7, r7, (0, 10), 0)?;
    let count = usize::try_from(whole(*line7, r7, (10, 10), 1)?).unwrap_or(0);
    let even = whole(*line7, r7, (20, 10), 2)? == 1;
    let step = number(*line7, r7.split_whitespace().nth(4).unwrap_or(""))?;
    let (complex, double) = (data_type >= 5, matches!(data_type, 4 | 6));
    let size = if double { 8 } else { 4 };
    let words: Vec<&str> = kind.split_whitespace().collect();
    let binary = words.first() == Some(&"58b");
    let raw = if binary {
        let each = size * if complex { 2 } else { 1 } + if even { 0 } else { 4 };
        let all = cursor.raw(count.saturating_mul(each));
        Some(all.ok_or_else(|| cut_short(cursor.line))?)
    } else {
        None
    };
    let function = whole(head[5].0, &head[5].1, (0, 5), 0)?;
    let abscissa = whole(head[7].0, &head[7].1, (0, 10), 0)?;
    if !TAKEN.contains(&function) || abscissa != TIME && function != 1 {
        return Ok(None);
    }
    let refused = |what: String, remedy: &str| {
        InputError::new(Problem::Unsupported, format!("line {line7}"), what, remedy)
    };
    if complex || !even {
        return Err(refused(
            "a record over time must be real, in even steps".to_owned(),
            "export it so",
        ));
    }
    if !(step > 0.0 && step.is_finite()) || count == 0 {
        return Err(refused(
            format!("{count} samples in steps of {step} s"),
            "export it again",
        ));
    }
    let samples = match raw {
        Some(raw) => numbers(raw, words.get(1) == Some(&"2"), double),
        None => text(cursor, if double { 20 } else { 13 }, count)?,
    };
    let unit = field(&head[8].1, 47, 20);
    Ok(Some(Record {
        step,
        unit: Some(unit).filter(|unit| !(unit.is_empty() || unit.eq_ignore_ascii_case("none"))),
        samples,
    }))
}

fn numbers(raw: &[u8], big: bool, double: bool) -> Vec<f64> {
    let of = |b: &[u8]| -> f64 {
        let mut eight = [0; 8];
        eight[..b.len()].copy_from_slice(b);
        if big {
            eight[..b.len()].reverse();
        }
        if double {
            f64::from_le_bytes(eight)
        } else {
            f64::from(f32::from_le_bytes([eight[0], eight[1], eight[2], eight[3]]))
        }
    };
    raw.chunks_exact(if double { 8 } else { 4 })
        .map(of)
        .collect()
}

fn text(cursor: &mut Cursor<'_>, width: usize, count: usize) -> Result<Vec<f64>, InputError> {
    let mut out = Vec::new();
    while out.len() < count {
        let (line, text) = cursor.line().ok_or_else(|| cut_short(cursor.line))?;
        if text.trim() == "-1" {
            return Err(InputError::new(
                Problem::Truncated,
                format!("line {line}"),
                format!("{} of {count} samples", out.len()),
                "export it again",
            ));
        }
        match columns(&text, &[width]) {
            Some(found) => out.extend(found),
            None => {
                for word in text.split_whitespace() {
                    out.push(number(line, word)?);
                }
            }
        }
    }
    out.truncate(count);
    Ok(out)
}

struct Held {
    records: Vec<Record>,
    wanted: Vec<usize>,
    at: usize,
    end: End,
}

impl Blocks for Held {
    fn want(&mut self, channels: &[usize]) {
        self.wanted = channels.to_vec();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        let all = self.records.first().map_or(0, |r| r.samples.len());
        let to = (self.at + BLOCK).min(all);
        for (row, channel) in rows.iter_mut().zip(&self.wanted) {
            row.extend_from_slice(&self.records[*channel].samples[self.at..to]);
        }
        let more = to > self.at;
        self.at = to;
        Ok(more)
    }

    fn end(&mut self) -> Result<End, InputError> {
        Ok(self.end.clone())
    }

    fn unit(&self, channel: usize) -> Option<String> {
        self.records.get(channel)?.unit.clone()
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        no_channel("records over time", asked, channels)
    }
}
