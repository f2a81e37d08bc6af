//! The log of `rarma act`: what was proposed, whether it was turned, and what came of it.

use super::{ConvertError, list, number, text};
use crate::record::{Advice, Body, Name, Outcome, Speed, Utc};
use serde_json::Value;

/// Most speeds of an advice in a record.
const MOST_SPEEDS: usize = 8;

/// A run of the log: what names it, and what it says.
pub(super) struct Run {
    /// Its first line: a log that has grown names the runs before as it did.
    pub name: String,
    /// When, and what.
    pub said: Vec<(Utc, Body)>,
}

/// An advice whose outcome is not known yet.
struct Open {
    advice: u64,
    rpm: f64,
    /// The speed that is ordered, 1/min, and whether the controller has it.
    ordered: Option<f64>,
    arrived: bool,
}

impl Open {
    /// What came of it: a speed that was ordered and has arrived was turned.
    fn outcome(&self, helped: Option<bool>, why: Option<Name>) -> Body {
        let turned = self.ordered.filter(|_| self.arrived);
        Body::Outcome(Outcome {
            advice: self.advice,
            followed: turned.is_some(),
            rpm: Some(turned.unwrap_or(self.rpm)),
            helped,
            why,
        })
    }
}

/// Is that a line of such a log?
pub(super) fn is_log(value: &Value) -> bool {
    value.get("utc").is_some_and(Value::is_number) && value.get("act").is_some_and(Value::is_string)
}

/// The runs of a log.
pub(super) fn runs(values: &[Value]) -> Result<Vec<Run>, ConvertError> {
    let begins = |value: &Value| value["act"] == "begins";
    let mut runs = Vec::new();
    let mut rest = values;
    while let Some(first) = rest.first() {
        let next = rest[1..].iter().position(begins);
        let (run, later) = rest.split_at(next.map_or(rest.len(), |n| n + 1));
        runs.push(Run {
            name: first.to_string(),
            said: of_run(run)?,
        });
        rest = later;
    }
    Ok(runs)
}

/// Advice, and its outcome as soon as it is known. Of an advice with which a log ends nothing is known yet.
fn of_run(lines: &[Value]) -> Result<Vec<(Utc, Body)>, ConvertError> {
    let mut all: Vec<(Utc, Body)> = Vec::new();
    let mut open: Option<Open> = None;
    let begin = begin(&lines[0])?;
    for line in lines {
        let time = begin.plus_s(number(line, "t")?);
        let act = text(line, "act")?;
        // What closes an advice: how it ended, and why.
        let closed: Option<(Option<bool>, Option<&str>)> = match act {
            "quiet" => Some((Some(true), None)),
            // The speed before chatters still.
            "proposed" => Some((Some(false), None)),
            "ends" => {
                let why = text(line, "why")?;
                Some(((why == "not-stable").then_some(false), Some(why)))
            }
            "would-order" | "no-speed" | "not-believed" | "out-of-limits" | "gone" => {
                Some((None, Some(act)))
            }
            _ => None,
        };
        if let Some((helped, why)) = closed
            && let Some(was) = open.take()
        {
            // Of a speed that was not turned nothing is known.
            let helped = helped.filter(|_| was.arrived);
            all.push((time, was.outcome(helped, why.map(Name::new).transpose()?)));
        }
        match (act, &mut open) {
            ("proposed", _) => {
                open = Some(Open {
                    advice: all.len() as u64,
                    rpm: number(line, "rpm")?,
                    ordered: None,
                    arrived: false,
                });
                all.push((time, Body::Advice(advice(line)?)));
            }
            ("ordered", Some(open)) => {
                let of = |name: &str| number(&line[name], "spindle");
                open.ordered = Some(open.rpm * of("to")? / of("from")?);
            }
            ("arrived", Some(open)) => open.arrived = true,
            _ => {}
        }
    }
    Ok(all)
}

fn advice(line: &Value) -> Result<Advice, ConvertError> {
    let speeds = list(line, "speeds")?.iter().take(MOST_SPEEDS);
    let speed = |rpm: &Value| {
        let rpm = rpm.as_f64();
        Ok(Speed::of_rpm(
            rpm.ok_or_else(|| ConvertError::Field("speeds".to_owned()))?,
        ))
    };
    Ok(Advice {
        called: None,
        rpm: number(line, "rpm")?,
        f_hz: number(line, "f")?,
        speeds: speeds.map(speed).collect::<Result<_, ConvertError>>()?,
        helps: Vec::new(),
    })
}

/// When a run began: the log's own clock, seconds since 1970, less the time since then.
fn begin(line: &Value) -> Result<Utc, ConvertError> {
    let utc = number(line, "utc")?;
    // Beyond any clock, and within 64 bits.
    if !(0.0..1e11).contains(&utc) {
        return Err(ConvertError::Field("utc".to_owned()));
    }
    #[allow(clippy::cast_possible_truncation, reason = "checked")]
    let begin = Utc::from_micros((utc * 1e6).round() as i64)
        .map_err(|why| ConvertError::Field(format!("utc: {why}")))?;
    Ok(begin.plus_s(-number(line, "t")?))
}
