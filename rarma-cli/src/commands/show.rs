//! What `monitor`, `target` and `demo` show: lines, alarms, verdict, page.

use super::{pair, process};
use crate::args::MonitorArgs;
use crate::collect::News;
use crate::failure::Failure;
use crate::input::Recording;
use crate::output::stdout;
use crate::record::{NoticeKind, NoticeRecord, Run, State, Summary, TachoFault};
use crate::report::{self, ReportInput};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rarma_core::decide::Structure;
use serde_json::json;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::Duration;

/// A bar on standard error, on a terminal only.
pub fn progress(length: u64, what: &str) -> ProgressBar {
    let target = if io::stderr().is_terminal() {
        ProgressDrawTarget::stderr_with_hz(10)
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// A sign of life and the time it has taken, for work whose end cannot be foretold; on
/// standard error, on a terminal only.
pub fn waiting(what: String) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{msg} {spinner} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// An alarm as it happens, for people.
pub fn alarm(news: &News<'_>, bar: &ProgressBar) {
    let text = match news {
        News::On(a) => format!(
            "{:8.3} s  CHATTER called: {:.1} Hz, damping {:.2} %",
            a.on,
            a.f,
            100.0 * a.zeta
        ),
        News::Off(a) => format!(
            "{:8.3} s  released; it was at {:.1} Hz, damping down to {:.2} %",
            a.off.unwrap_or(f64::NAN),
            a.f,
            100.0 * a.zeta
        ),
        News::None | News::Line(_) => return,
    };
    bar.suspend(|| say!("{text}"));
}

/// Lines and summary as JSON, one object a line.
fn json_lines(run: &Run) {
    // What could not be written is told when the command ends.
    let _ = write_json(run, io::BufWriter::new(stdout::Stdout));
}

fn write_json(run: &Run, mut out: impl Write) -> io::Result<()> {
    for line in &run.lines {
        serde_json::to_writer(&mut out, line)?;
        out.write_all(b"\n")?;
    }
    serde_json::to_writer(&mut out, &json!({ "summary": run.summary }))?;
    out.write_all(b"\n")?;
    out.flush()
}

/// The verdict in a few lines.
pub fn verdict(summary: &Summary) {
    for notice in &summary.notices {
        say!("{}", notice_words(notice));
    }
    let seconds = summary.samples as f64 / summary.fs;
    if summary.alarms.is_empty() {
        say!("No chatter in {seconds:.2} s.");
    }
    for alarm in &summary.alarms {
        let until = match alarm.off {
            Some(off) => format!("to {off:.3} s"),
            None => "to the end".to_owned(),
        };
        say!(
            "Chatter at {:.1} Hz from {:.3} s {until}, damping down to {:.2} %.",
            alarm.f,
            alarm.on,
            100.0 * alarm.zeta
        );
    }
    let mut states: Vec<(&State, &f64)> = summary.state_seconds.iter().collect();
    states.sort_by(|a, b| b.1.total_cmp(a.1));
    let words: Vec<String> = states
        .iter()
        .map(|(state, s)| format!("{} {s:.2} s", state_word(**state)))
        .collect();
    say!("Time spent: {}.", words.join(", "));
}

/// A notice, and what to do about it.
fn notice_words(notice: &NoticeRecord) -> String {
    let t = notice.t;
    match notice.what {
        NoticeKind::Contradiction {
            told_rpm,
            found_rpm,
        } => format!(
            "Warning: at {t:.2} s the sound is that of a spindle at {found_rpm:.0} 1/min, not at the {told_rpm:.0} 1/min that were told: check the speed and give the true one with --rpm; until then a line on a multiple of {found_rpm:.0} 1/min is of unknown origin."
        ),
        NoticeKind::Tacho { fault } => {
            let what = match fault {
                TachoFault::Silent => {
                    "gives no pulses: check that it is connected and which channel it is"
                }
                TachoFault::Missing => "misses pulses: check its distance and its level",
                TachoFault::Doubled => {
                    "gives too many pulses: check --pulses and that it does not bounce"
                }
                TachoFault::Noisy => {
                    "gives pulses without a rhythm: check the channel and its cable"
                }
            };
            format!("Warning: at {t:.2} s the tacho {what}.")
        }
    }
}

/// A state in one word.
pub fn state_word(state: State) -> &'static str {
    match state {
        State::Starting => "starting",
        State::Idle => "idle",
        State::Stable => "stable",
        State::Warning => "warning",
        State::Chatter => "chatter",
        State::Invalid => "invalid",
    }
}

/// Writes the page of a recording.
///
/// # Errors
/// The folder cannot be written.
pub fn page(
    dir: &Path,
    args: &MonitorArgs,
    recording: &Recording,
    run: &Run,
    band_hz: (f64, f64),
) -> Result<(), Failure> {
    let name = recording.path.display().to_string();
    let path = report::write(
        dir,
        &ReportInput {
            title: &name,
            source_name: &name,
            samples: &recording.samples,
            fs: recording.fs,
            run,
            threshold: args.threshold,
            band_hz,
            rpm: args.rpm,
            teeth: args.teeth,
            truth_onset_s: None,
            truth_note: None,
            version: env!("CARGO_PKG_VERSION"),
        },
    )?;
    eprintln!("report: {}", path.display());
    Ok(())
}

/// Lines (JSON or words), page and exit code of a finished run.
///
/// # Errors
/// Output cannot be written.
pub fn finish(
    args: &MonitorArgs,
    recording: &Recording,
    run: &mut Run,
    band_hz: (f64, f64),
    structure: Option<&Structure<f64>>,
) -> Result<u8, Failure> {
    if let Some(structure) = structure {
        process::annotate(run, structure);
    }
    if args.json {
        for notice in &run.summary.notices {
            eprintln!("{}", notice_words(notice));
        }
        json_lines(run);
    } else {
        verdict(&run.summary);
        pair::words(run.summary.channels.as_deref().unwrap_or_default());
        if let Some(structure) = structure {
            process::words(run, structure);
        }
    }
    if let Some(dir) = &args.report {
        page(dir, args, recording, run, band_hz)?;
    }
    Ok(u8::from(!run.summary.alarms.is_empty()))
}
