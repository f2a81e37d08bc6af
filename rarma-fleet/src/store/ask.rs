//! Questions to a store, and their answers. Every answer is sorted by its key, so that two stores can be
//! compared line by line.

use super::Store;
use super::backend::{Rows, StoreError, Value};
use super::tables::NOT_VERDICTS;
use crate::record::{Id, Kind, Name, Quantity, Utc};
use serde::Serialize;

/// By what an answer is split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Machine.
    Machine,
    /// Tool; empty where none was told.
    Tool,
    /// Operator; empty where none was told.
    Operator,
    /// Spindle speed in steps of 500 1/min; empty where none was told.
    Speed,
    /// Month.
    Month,
}

impl By {
    fn sql(self) -> &'static str {
        match self {
            Self::Machine => "machine",
            Self::Tool => "coalesce(tool, '')",
            Self::Operator => "coalesce(operator, '')",
            Self::Speed => "rpm_step",
            Self::Month => "month",
        }
    }
}

/// Months, from the first to the last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Span {
    /// First month, such as 202603; none: from the beginning.
    pub from_month: Option<i64>,
    /// Last month, included; none: to the end.
    pub to_month: Option<i64>,
}

impl Span {
    /// A time is in it.
    #[must_use]
    pub fn has(self, time: Utc) -> bool {
        let month = time.month();
        self.from_month.is_none_or(|from| from <= month)
            && self.to_month.is_none_or(|to| month <= to)
    }

    fn values(self) -> [Value; 2] {
        [
            self.from_month.unwrap_or(0).into(),
            self.to_month.unwrap_or(999_999).into(),
        ]
    }
}

/// What is there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Contents {
    /// Kind of record.
    pub kind: String,
    /// How many.
    pub records: i64,
    /// Of how many machines.
    pub machines: i64,
    /// The first.
    pub first: Utc,
    /// The last.
    pub last: Utc,
}

/// A machine that is in the store.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Its name.
    pub machine: String,
    /// Records.
    pub records: i64,
    /// The first.
    pub first: Utc,
    /// The last; long ago: the box is silent.
    pub last: Utc,
}

/// Alarms of one key.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlarmCount {
    /// Machine, tool, operator, speed or month.
    pub key: String,
    /// How many were called.
    pub alarms: i64,
    /// How long they stood, of those that were released, s.
    pub seconds: f64,
}

/// What advice did, of one key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AdviceCount {
    /// Machine, tool, operator, speed or month.
    pub key: String,
    /// Advice with a speed.
    pub advised: i64,
    /// Of it, a speed was turned.
    pub followed: i64,
    /// Of those, the chatter ended.
    pub helped: i64,
    /// Of those, it did not.
    pub not_helped: i64,
    /// Not followed, and the chatter ended all the same: what advice has to be compared with.
    pub ended_anyway: i64,
    /// Not followed, and it did not end.
    pub stayed: i64,
}

/// How long a machine was in a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateTime {
    /// Machine.
    pub machine: String,
    /// Month, such as 202603.
    pub month: i64,
    /// State.
    pub state: String,
    /// How long, s.
    pub seconds: f64,
}

/// One number of a capability, of a machine at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineReading {
    /// Machine.
    pub machine: String,
    /// What.
    pub quantity: Quantity,
    /// Where.
    pub place: String,
    /// Where along the place.
    pub at: f64,
    /// When.
    pub time: Utc,
    /// Which record.
    #[serde(skip)]
    pub id: (String, i64, i64),
    /// Tool.
    pub tool: Option<String>,
    /// Operator.
    pub operator: Option<String>,
    /// The number.
    pub value: f64,
    /// Its standard deviation.
    pub sd: f64,
}

fn time(value: &Value) -> Result<Utc, StoreError> {
    Utc::from_micros(value.int()?).map_err(|e| StoreError::Answer(e.to_string()))
}

/// A key as text: whole numbers without a point.
fn key(value: &Value) -> Result<String, StoreError> {
    Ok(match value {
        Value::Null => String::new(),
        Value::Text(t) => t.clone(),
        number => number.int()?.to_string(),
    })
}

impl Store {
    fn rows(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError> {
        self.backend.query(sql, parameters)
    }

    /// What is there, by kind.
    ///
    /// # Errors
    /// The database refuses.
    pub fn contents(&mut self) -> Result<Vec<Contents>, StoreError> {
        let sql = "SELECT kind, CAST(sum(records) AS BIGINT), count(DISTINCT machine), min(first_us), \
                   max(last_us) FROM @sums GROUP BY kind ORDER BY kind";
        self.rows(sql, &[])?
            .iter()
            .map(|row| {
                Ok(Contents {
                    kind: row[0].text()?,
                    records: row[1].int()?,
                    machines: row[2].int()?,
                    first: time(&row[3])?,
                    last: time(&row[4])?,
                })
            })
            .collect()
    }

    /// The machines.
    ///
    /// # Errors
    /// The database refuses.
    pub fn machines(&mut self) -> Result<Vec<Machine>, StoreError> {
        let sql = "SELECT machine, CAST(sum(records) AS BIGINT), min(first_us), max(last_us) FROM @sums \
                   GROUP BY machine ORDER BY machine";
        let rows = self.rows(sql, &[])?;
        let machine = |row: &Vec<Value>| {
            Ok(Machine {
                machine: row[0].text()?,
                records: row[1].int()?,
                first: time(&row[2])?,
                last: time(&row[3])?,
            })
        };
        let mut all: Vec<Machine> = rows
            .iter()
            .map(machine)
            .collect::<Result<_, StoreError>>()?;
        // Databases sort letters beyond ASCII each in their own way.
        all.sort_by(|a, b| a.machine.cmp(&b.machine));
        Ok(all)
    }

    /// Alarms, and how long they stood.
    ///
    /// # Errors
    /// The database refuses.
    pub fn alarms(&mut self, by: By, span: Span) -> Result<Vec<AlarmCount>, StoreError> {
        let sql = format!(
            "SELECT {key} AS k, sum(CASE WHEN kind = 'alarm-called' THEN 1 ELSE 0 END), \
             sum(CASE WHEN kind = 'alarm-released' THEN seconds ELSE 0.0 END) FROM @records \
             WHERE {NOT_VERDICTS} AND kind IN ('alarm-called', 'alarm-released') AND month >= ? AND month <= ? GROUP BY k",
            key = by.sql()
        );
        let rows = self.rows(&sql, &span.values())?;
        let count = |row: &Vec<Value>| {
            Ok(AlarmCount {
                key: key(&row[0])?,
                alarms: row[1].int()?,
                seconds: row[2].real()?,
            })
        };
        let mut all: Vec<_> = rows.iter().map(count).collect::<Result<_, StoreError>>()?;
        all.sort_by(|a, b| in_order(by, &a.key, &b.key));
        Ok(all)
    }

    /// How often advice was followed, and helped.
    ///
    /// # Errors
    /// The database refuses.
    pub fn advice(&mut self, by: By, span: Span) -> Result<Vec<AdviceCount>, StoreError> {
        let sql = format!(
            "SELECT {key} AS k, sum(CASE WHEN speeds > 0 THEN 1 ELSE 0 END), \
             sum(CASE WHEN followed = 1 THEN 1 ELSE 0 END), \
             sum(CASE WHEN followed = 1 AND helped = 1 THEN 1 ELSE 0 END), \
             sum(CASE WHEN followed = 1 AND helped = 0 THEN 1 ELSE 0 END), \
             sum(CASE WHEN followed = 0 AND helped = 1 THEN 1 ELSE 0 END), \
             sum(CASE WHEN followed = 0 AND helped = 0 THEN 1 ELSE 0 END) FROM @records \
             WHERE {NOT_VERDICTS} AND kind IN ('advice', 'outcome') AND month >= ? AND month <= ? GROUP BY k",
            key = by.sql()
        );
        let rows = self.rows(&sql, &span.values())?;
        let count = |row: &Vec<Value>| {
            Ok(AdviceCount {
                key: key(&row[0])?,
                advised: row[1].int()?,
                followed: row[2].int()?,
                helped: row[3].int()?,
                not_helped: row[4].int()?,
                ended_anyway: row[5].int()?,
                stayed: row[6].int()?,
            })
        };
        let mut all: Vec<_> = rows.iter().map(count).collect::<Result<_, StoreError>>()?;
        all.sort_by(|a, b| in_order(by, &a.key, &b.key));
        Ok(all)
    }

    /// How long each machine was in each state, by month; thinned verdicts included.
    ///
    /// # Errors
    /// The database refuses.
    pub fn states(&mut self, span: Span) -> Result<Vec<StateTime>, StoreError> {
        let closed = self.meta("thinned_before_us")?.unwrap_or(0);
        let [from, to] = span.values();
        let sql = "SELECT machine, month, state, sum(s) FROM ( \
                   SELECT machine, month, state, seconds AS s FROM @sums \
                   WHERE kind = 'verdict' AND month >= ? AND month <= ? \
                   UNION ALL SELECT machine, month, state, seconds AS s FROM @days \
                   WHERE month >= ? AND month <= ? AND thinned_us <= ? \
                   ) AS parts GROUP BY machine, month, state";
        let parameters = [from.clone(), to.clone(), from, to, closed.into()];
        let rows = self.rows(sql, &parameters)?;
        let state = |row: &Vec<Value>| {
            Ok(StateTime {
                machine: row[0].text()?,
                month: row[1].int()?,
                state: row[2].text()?,
                seconds: row[3].real()?,
            })
        };
        let mut all: Vec<_> = rows.iter().map(state).collect::<Result<_, StoreError>>()?;
        all.sort_by(|a, b| (&a.machine, a.month, &a.state).cmp(&(&b.machine, b.month, &b.state)));
        Ok(all)
    }

    /// Every reading, of one machine or of all, sorted by machine, quantity, place, time and name.
    ///
    /// # Errors
    /// The database refuses.
    pub fn readings(&mut self, machine: Option<&Name>) -> Result<Vec<MachineReading>, StoreError> {
        const COLUMNS: &str = "SELECT machine, quantity, place, at, time_us, sender, session, seq, tool, \
                               operator, value, sd FROM @readings";
        let rows = match machine {
            Some(m) => self.rows(
                &format!("{COLUMNS} WHERE machine = ?"),
                &[m.as_str().into()],
            )?,
            None => self.rows(COLUMNS, &[])?,
        };
        let mut all = Vec::with_capacity(rows.len());
        for row in &rows {
            // A quantity of a later version: not for this program.
            let Some(quantity) = Quantity::of_name(&row[1].text()?) else {
                continue;
            };
            all.push(MachineReading {
                machine: row[0].text()?,
                quantity,
                place: row[2].text()?,
                at: row[3].real()?,
                time: time(&row[4])?,
                id: (row[5].text()?, row[6].int()?, row[7].int()?),
                tool: row[8].text_or_null()?,
                operator: row[9].text_or_null()?,
                value: row[10].real()?,
                sd: row[11].real()?,
            });
        }
        all.sort_by(|a, b| {
            let head = |r: &MachineReading| (r.quantity, r.time);
            (a.machine.cmp(&b.machine))
                .then_with(|| a.place.cmp(&b.place))
                .then_with(|| head(a).cmp(&head(b)))
                .then_with(|| a.id.cmp(&b.id))
                .then(a.at.total_cmp(&b.at))
        });
        Ok(all)
    }

    /// Lines of records as they came, by time; of one machine or kind, at most `most`.
    ///
    /// # Errors
    /// The database refuses.
    pub fn lines(
        &mut self,
        machine: Option<&Name>,
        kind: Option<Kind>,
        after: Option<&(Utc, Id)>,
        most: usize,
    ) -> Result<Vec<String>, StoreError> {
        let mut sql = "SELECT line FROM @records WHERE time_us >= ?".to_owned();
        let mut parameters = vec![Value::Int(after.map_or(0, |(t, _)| t.micros()))];
        if let Some((t, id)) = after {
            // The rest of the same microsecond, then what is later.
            sql.push_str(" AND (time_us > ? OR sender > ? OR (sender = ? AND (session > ? OR (session = ? AND seq > ?))))");
            #[allow(clippy::cast_possible_wrap, reason = "at most 2^53")]
            let (session, seq) = (id.session as i64, id.seq as i64);
            let sender = || Value::from(id.sender.as_str());
            parameters.extend([
                t.micros().into(),
                sender(),
                sender(),
                session.into(),
                session.into(),
                seq.into(),
            ]);
        }
        if let Some(machine) = machine {
            sql.push_str(" AND machine = ?");
            parameters.push(machine.as_str().into());
        }
        if let Some(kind) = kind {
            sql.push_str(" AND kind = ?");
            parameters.push(kind.name().into());
        }
        sql.push_str(" ORDER BY time_us, sender, session, seq LIMIT ?");
        parameters.push(Value::Int(i64::try_from(most).unwrap_or(i64::MAX)));
        self.rows(&sql, &parameters)?
            .iter()
            .map(|row| row[0].text())
            .collect()
    }
}

/// Numbers by size, names by letter.
fn in_order(by: By, a: &str, b: &str) -> std::cmp::Ordering {
    match by {
        By::Speed => {
            let n = |t: &str| t.parse::<i64>().unwrap_or(-1);
            n(a).cmp(&n(b))
        }
        By::Machine | By::Tool | By::Operator | By::Month => a.cmp(b),
    }
}

#[cfg(test)]
#[path = "ask_tests.rs"]
mod tests;
