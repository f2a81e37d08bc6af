//! `rarma store ask`.

use super::{Opened, lines, table, values};
use crate::args::{Question, SplitBy, StoreAskArgs};
use crate::failure::Failure;
use rarma_fleet::store::{By, Span};
use serde_json::json;

pub(super) fn by(split: SplitBy) -> By {
    match split {
        SplitBy::Machine => By::Machine,
        SplitBy::Tool => By::Tool,
        SplitBy::Operator => By::Operator,
        SplitBy::Speed => By::Speed,
        SplitBy::Month => By::Month,
    }
}

pub(super) fn main(args: &StoreAskArgs) -> Result<u8, Failure> {
    let mut opened = Opened::that_is_there(&args.store)?;
    let span = Span {
        from_month: args.from,
        to_month: args.to,
    };
    let by = by(args.by);
    let (rows, head): (_, &[&str]) = match args.question {
        Question::Alarms => {
            let answer = opened.store.alarms(by, span);
            (
                values(&opened.asked(answer)?),
                &["key", "alarms", "seconds"],
            )
        }
        Question::Advice => {
            let answer = opened.store.advice(by, span);
            let head = &[
                "key",
                "advised",
                "followed",
                "helped",
                "not_helped",
                "ended_anyway",
                "stayed",
            ];
            (values(&opened.asked(answer)?), head)
        }
        Question::Readings => {
            let answer = opened.store.readings(None);
            let mut readings = opened.asked(answer)?;
            readings.retain(|reading| span.has(reading.time));
            let head = &[
                "machine", "quantity", "place", "at", "time", "tool", "operator", "value", "sd",
            ];
            (values(&readings), head)
        }
        Question::States => {
            let answer = opened.store.states(span);
            (
                values(&opened.asked(answer)?),
                &["machine", "month", "state", "seconds"],
            )
        }
    };
    table::write(&args.table, &rows, head)?;
    if args.json {
        say!("{}", json!({"answers": rows}));
    } else {
        for line in lines(&rows) {
            say!("{line}");
        }
    }
    Ok(0)
}
