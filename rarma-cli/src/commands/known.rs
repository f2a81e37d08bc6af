//! Cuts with one tool that are remembered from one hearing to the next.

use crate::advice::{Advisor, F_SD};
use crate::args::AdviseArgs;
use crate::failure::Failure;
use crate::record::{State, Summary};
use rarma_core::advice::KnownCut;
use rarma_recordings::input::{self, CUTS_HEADER, CutRow};
use rarma_recordings::output;
use std::io;

/// A cut without an alarm is a stable one from so many seconds of it on.
const STABLE_S: f64 = 1.0;

/// The known cuts, with depths over that of this one; none where no file is named, or it is still
/// to be made.
///
/// # Errors
/// Bad input; depths that nothing is told to compare with.
pub(super) fn read(args: &AdviseArgs) -> Result<Vec<KnownCut<f64>>, Failure> {
    let Some(path) = &args.known else {
        return Ok(Vec::new());
    };
    if args.remember && !path.exists() {
        return Ok(Vec::new());
    }
    let rows = input::read_cuts(path)?;
    if args.remember && !input::has_cuts_header(path)? {
        return Err(Failure::Usage(format!(
            "{}: --remember adds lines to a table that begins with `{CUTS_HEADER}`: write its columns so",
            path.display()
        )));
    }
    let known = |row: &CutRow| {
        let depth = match (row.depth_mm, args.depth_mm) {
            (Some(there), Some(here)) => there / here,
            (None, _) => 1.0,
            (Some(_), None) => {
                return Err(Failure::Usage(format!(
                    "{}: it has depths, and that of this cut is not told: add --depth-mm MM",
                    path.display()
                )));
            }
        };
        let spindle_hz = row.rpm / 60.0;
        let cut = if row.stable {
            KnownCut::stable(spindle_hz)
        } else {
            KnownCut::chattered(spindle_hz, row.f_hz.map(|f| (f, F_SD * f)))
        };
        Ok(cut.of_depth(depth))
    };
    rows.iter().map(known).collect()
}

/// Adds what was heard to the file of known cuts: each alarm whose speed is known, or that there
/// was none in a cut.
///
/// # Errors
/// The file cannot be written: nothing of it is lost.
pub(super) fn remember(
    args: &AdviseArgs,
    summary: &Summary,
    advisor: &Advisor,
) -> Result<(), Failure> {
    let Some(path) = &args.known else {
        return Ok(());
    };
    let row = |rpm, f_hz: Option<f64>| CutRow {
        rpm,
        stable: f_hz.is_none(),
        f_hz,
        depth_mm: args.depth_mm,
    };
    let alarms = summary.alarms.iter().zip(advisor.speeds_rpm());
    let mut rows: Vec<CutRow> = alarms
        .filter_map(|(alarm, rpm)| Some(row(rpm?, Some(alarm.f))))
        .collect();
    let seconds = |state| summary.state_seconds.get(&state).copied().unwrap_or(0.0);
    if summary.alarms.is_empty()
        && seconds(State::Stable) >= STABLE_S
        && let Some(rpm) = advisor.speed_rpm()
    {
        rows.push(row(rpm, None));
    }
    let mut text = match std::fs::read_to_string(path) {
        Ok(before) if before.is_empty() || before.ends_with('\n') => before,
        Ok(before) => before + "\n",
        Err(why) if why.kind() == io::ErrorKind::NotFound => format!("{CUTS_HEADER}\n"),
        Err(why) => return Err(output::failed(path, "read", &why).into()),
    };
    for row in rows {
        text += &row.line();
        text.push('\n');
    }
    // A new file takes the name of the old one once it is whole: no cut is lost where it cannot be written.
    Ok(output::write(path, text)?)
}
