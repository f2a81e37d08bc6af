//! `rarma advise`: listens as `monitor` does, then says what to turn instead.

use super::known;
use super::monitor::{self, Manner};
use super::show::Finished;
use crate::advice::{Advisor, Missing, Reach, machine, missing_words, sentences};
use crate::args::{AdviseArgs, MonitorArgs};
use crate::failure::Failure;
use crate::output::stdout;
use crate::record::{Alarm, Summary};
use serde::Serialize;
use std::sync::Arc;

/// The one object of `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    alarms: &'a [Alarm],
    /// What would have to be told.
    missing: Vec<Missing>,
}

pub(super) fn main(args: &AdviseArgs) -> Result<u8, Failure> {
    if !args.monitor.more.is_empty() {
        return Err(Failure::Usage(
            "several recordings: advice is for one at a time; `rarma monitor … --report DIR` has that of each on its page"
                .to_owned(),
        ));
    }
    let json = args.monitor.json;
    // Lines are not wanted: one object at the end is.
    let listening = MonitorArgs {
        json: false,
        ..args.monitor.clone()
    };
    let reach = Reach {
        known: known::read(args)?,
        machine: machine::told(&args.machine, args.monitor.teeth)?.map(Arc::new),
        ..Reach::from(args)
    };
    let manner = Manner {
        reach,
        quiet: json,
        ..Manner::default()
    };
    let finished = monitor::heard(&listening, manner)?;
    let Finished {
        summary,
        advisor,
        code,
    } = finished;
    if json {
        let answer = Answer {
            alarms: &summary.alarms,
            missing: advisor.missing(),
        };
        let text = serde_json::to_string(&answer).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        words(&summary, &advisor);
    }
    stdout::check()?;
    if args.remember {
        known::remember(args, &summary, &advisor)?;
    }
    Ok(code)
}

/// What to do, alarm by alarm; alarms with the same answer are one.
fn words(summary: &Summary, advisor: &Advisor) {
    if summary.alarms.is_empty() {
        return;
    }
    say!("What to do:");
    if let Some(text) = missing_words(&advisor.missing()) {
        say!("  {text}");
        return;
    }
    for alarm in &summary.alarms {
        let Some(advice) = &alarm.advice else {
            continue;
        };
        say!("  at {:.3} s, {:.1} Hz:", alarm.on, alarm.f);
        for sentence in sentences(advice) {
            say!("    {sentence}");
        }
    }
}
