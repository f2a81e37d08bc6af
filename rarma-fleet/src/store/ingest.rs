//! Taking records in: each once, in any order.

use super::Store;
use super::backend::{Rows, StoreError, Value};
use super::tables::table;
use crate::record::{Body, Id, Name, Record, RecordError, from_line, to_line};
use rarma_core::named::Named;
use std::collections::HashMap;

/// Records in one transaction.
const BATCH: usize = 4096;

/// What became of records.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Taken {
    /// Were not there, and are now.
    pub new: u64,
    /// Were there already.
    pub same: u64,
    /// Verdicts older than what was thinned: their days are closed.
    pub thinned: u64,
    /// Another record of the same name was there first, and stays: the first 100 names.
    pub different: Vec<Id>,
    /// How many of those there were.
    pub different_count: u64,
}

impl Taken {
    /// Both together.
    pub fn add(&mut self, more: Self) {
        self.new += more.new;
        self.same += more.same;
        self.thinned += more.thinned;
        self.different_count += more.different_count;
        self.different.extend(more.different);
        self.different.truncate(100);
    }
}

/// A record, the line it came as, and its hash.
struct Came<'a> {
    record: &'a Record,
    line: String,
    hash: i64,
}

impl Store {
    /// Takes records. What is there already is counted and left as it is: the same records may come
    /// again, from a broker, a journal or a file, in any order.
    ///
    /// # Errors
    /// The database refuses; what was counted before is there.
    pub fn add(&mut self, records: &[Record]) -> Result<Taken, StoreError> {
        let lines = records.iter().map(|record| Ok((record, to_line(record)?)));
        let lines: Result<Vec<_>, RecordError> = lines.collect();
        self.add_pairs(lines.map_err(|e| StoreError::Answer(e.to_string()))?)
    }

    /// The same of lines, which are kept as they came: with fields that this program does not know.
    /// A line that is no record is given to `refused` with its place, from 0, and passed over.
    ///
    /// # Errors
    /// The database refuses.
    pub fn add_lines<'a>(
        &mut self,
        lines: impl IntoIterator<Item = &'a str>,
        mut refused: impl FnMut(usize, RecordError),
    ) -> Result<Taken, StoreError> {
        let mut read = Vec::new();
        for (place, line) in lines.into_iter().enumerate() {
            match from_line(line.trim_end()) {
                Ok(record) => read.push((record, line.trim_end())),
                Err(error) => refused(place, error),
            }
        }
        let pairs = read
            .iter()
            .map(|(record, line)| (record, (*line).to_owned()));
        self.add_pairs(pairs.collect())
    }

    pub(super) fn add_pairs(&mut self, pairs: Vec<(&Record, String)>) -> Result<Taken, StoreError> {
        let closed = self.meta("thinned_before_us")?.unwrap_or(i64::MIN);
        let mut taken = Taken::default();
        let mut pairs = pairs.into_iter().peekable();
        while pairs.peek().is_some() {
            let mut batch = Vec::with_capacity(BATCH);
            for (record, line) in pairs.by_ref().take(BATCH) {
                if matches!(record.body, Body::Verdict(_)) && record.time.micros() < closed {
                    taken.thinned += 1;
                    continue;
                }
                // Of what the record says and not of how the line is spelled.
                let said = to_line(record).map_err(|e| StoreError::Answer(e.to_string()))?;
                batch.push(Came {
                    record,
                    line,
                    hash: hash(&said),
                });
            }
            taken.add(self.add_batch(batch)?);
        }
        Ok(taken)
    }

    fn add_batch(&mut self, batch: Vec<Came<'_>>) -> Result<Taken, StoreError> {
        let mut known = self.known(&batch)?;
        let mut taken = Taken::default();
        let (mut records, mut readings) = (Rows::new(), Rows::new());
        for came in batch {
            let id = &came.record.id;
            match known.get(id) {
                Some(hash) if *hash == came.hash => taken.same += 1,
                Some(_) => {
                    taken.different_count += 1;
                    taken.different.push(id.clone());
                }
                None => {
                    known.insert(id.clone(), came.hash);
                    taken.new += 1;
                    readings.extend(reading_rows(came.record));
                    records.push(record_row(came));
                }
            }
        }
        // The record last: where a database has no transactions, its row says that all of it is there.
        self.backend
            .insert(&[(table("readings"), readings), (table("records"), records)])?;
        Ok(taken)
    }

    /// Hashes of the records of these names that are there.
    fn known(&mut self, batch: &[Came<'_>]) -> Result<HashMap<Id, i64>, StoreError> {
        let mut sessions: HashMap<(&Name, u64), (u64, u64)> = HashMap::new();
        for Came {
            record: Record { id, .. },
            ..
        } in batch
        {
            let range = sessions
                .entry((&id.sender, id.session))
                .or_insert((id.seq, id.seq));
            *range = (range.0.min(id.seq), range.1.max(id.seq));
        }
        let sessions: Vec<_> = sessions.into_iter().collect();
        let mut known = HashMap::new();
        for some in sessions.chunks(self.backend.dialect().ranges_together()) {
            let one = "(sender = ? AND session = ? AND seq >= ? AND seq <= ?)";
            let sql = format!(
                "SELECT sender, session, seq, hash FROM @records WHERE {}",
                vec![one; some.len()].join(" OR ")
            );
            let parameters: Vec<Value> = some
                .iter()
                .flat_map(|((sender, session), (from, to))| {
                    [
                        Value::from(sender.as_str()),
                        number(*session),
                        number(*from),
                        number(*to),
                    ]
                })
                .collect();
            for row in self.backend.query(&sql, &parameters)? {
                let sender = Name::new(&row[0].text()?)
                    .map_err(|why| StoreError::Answer(why.to_string()))?;
                #[allow(clippy::cast_sign_loss, reason = "numbers of ours")]
                let id = Id {
                    sender,
                    session: row[1].int()? as u64,
                    seq: row[2].int()? as u64,
                };
                known.insert(id, row[3].int()?);
            }
        }
        Ok(known)
    }
}

/// 52 bits of the SHA-256 of a line.
fn hash(line: &str) -> i64 {
    #[allow(clippy::cast_possible_wrap, reason = "52 bits")]
    let bits = crate::record::session_of_bytes(line.as_bytes()) as i64;
    bits
}

fn number(n: u64) -> Value {
    // At most 2^53 - 1, checked with every record.
    Value::Int(i64::try_from(n).unwrap_or(i64::MAX))
}

fn name(name: Option<&Name>) -> Value {
    Value::from(name.map(Name::as_str))
}

/// What questions ask for, of the kinds that have it.
#[derive(Default)]
struct Asked {
    state: Option<&'static str>,
    of_seq: Option<u64>,
    f_hz: Option<f64>,
    zeta: Option<f64>,
    rpm: Option<f64>,
    seconds: Option<f64>,
    speeds: Option<i64>,
    followed: Option<bool>,
    helped: Option<bool>,
}

fn asked(body: &Body) -> Asked {
    match body {
        Body::Verdict(v) => Asked {
            state: Some(v.state.name()),
            rpm: v.rpm,
            seconds: Some(v.seconds),
            ..Asked::default()
        },
        Body::AlarmCalled(a) => Asked {
            f_hz: Some(a.f_hz),
            zeta: Some(a.zeta),
            rpm: a.rpm,
            ..Asked::default()
        },
        Body::AlarmReleased(a) => Asked {
            of_seq: Some(a.called),
            f_hz: Some(a.f_hz),
            zeta: Some(a.zeta_lowest),
            rpm: a.rpm,
            seconds: Some(a.seconds),
            ..Asked::default()
        },
        Body::Advice(a) => Asked {
            of_seq: a.called,
            f_hz: Some(a.f_hz),
            rpm: Some(a.rpm),
            speeds: i64::try_from(a.speeds.len()).ok(),
            ..Asked::default()
        },
        Body::Outcome(o) => Asked {
            of_seq: Some(o.advice),
            rpm: o.rpm,
            followed: Some(o.followed),
            helped: o.helped,
            ..Asked::default()
        },
        Body::OdrStatistics(o) => Asked {
            f_hz: Some(o.f_hz),
            zeta: Some(o.zeta_mean),
            rpm: Some(o.rpm),
            seconds: Some(o.seconds),
            ..Asked::default()
        },
        Body::Modes(m) => Asked {
            rpm: Some(m.rpm),
            ..Asked::default()
        },
        Body::Stiffness(_) | Body::Limits(_) => Asked::default(),
    }
}

/// Speeds in steps of 500 1/min: of 4999, 4500.
#[allow(clippy::cast_possible_truncation, reason = "saturates")]
fn rpm_step(rpm: f64) -> i64 {
    (rpm / 500.0).floor() as i64 * 500
}

/// A row of `records`, in the order of its columns.
fn record_row(came: Came<'_>) -> Vec<Value> {
    let r = came.record;
    let asked = asked(&r.body);
    let yes = |b: Option<bool>| Value::from(b.map(i64::from));
    vec![
        Value::from(r.id.sender.as_str()),
        number(r.id.session),
        number(r.id.seq),
        Value::from(r.machine.as_str()),
        Value::from(r.body.kind().name()),
        Value::Int(r.time.micros()),
        Value::Int(r.time.month()),
        Value::Int(r.time.day()),
        name(r.tool.as_ref()),
        name(r.operator.as_ref()),
        name(r.settings.as_ref()),
        name(r.firmware.as_ref()),
        Value::from(asked.state),
        asked.of_seq.map_or(Value::Null, number),
        Value::from(asked.f_hz),
        Value::from(asked.zeta),
        Value::from(asked.rpm),
        Value::from(asked.rpm.map(rpm_step)),
        Value::from(asked.seconds),
        Value::from(asked.speeds),
        yes(asked.followed),
        yes(asked.helped),
        Value::Int(came.hash),
        Value::Text(came.line),
    ]
}

/// Rows of `readings`, in the order of their columns.
fn reading_rows(r: &Record) -> Rows {
    let row = |(n, reading): (i64, crate::record::Reading)| {
        vec![
            Value::from(r.id.sender.as_str()),
            number(r.id.session),
            number(r.id.seq),
            Value::Int(n),
            Value::from(r.machine.as_str()),
            Value::from(reading.quantity.name()),
            Value::from(reading.place.as_str()),
            Value::Real(reading.at),
            Value::Int(r.time.micros()),
            name(r.tool.as_ref()),
            name(r.operator.as_ref()),
            Value::Real(reading.value),
            Value::Real(reading.sd),
        ]
    };
    (0..).zip(r.body.readings()).map(row).collect()
}
