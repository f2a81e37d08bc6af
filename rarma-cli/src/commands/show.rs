//! What `monitor`, `target` and `demo` show: lines, alarms, verdict, page.

use super::pair;
use super::process::Added;
use super::source::About;
use crate::advice::{Advisor, Reach};
use crate::args::{MonitorArgs, notes_by_key};
use crate::collect::News;
use crate::controller::{ActRecord, words};
use crate::failure::Failure;
use crate::output::stdout;
use crate::progress::ProgressBar;
pub use crate::progress::{progress, waiting};
use crate::record::{State, Summary};
use crate::report::{self, Course, Provenance, ReportInput, Sound, damping_words};
use crate::screen::Screen;
use crate::wording;
use rarma_box::wire::MonitorJob;
use rarma_core::decide::Structure;
use rarma_core::named::Named;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// An alarm as it happens, for people.
pub fn alarm(news: &News, bar: &ProgressBar) {
    let (t, text) = match news {
        News::On(a) => (a.on, wording::called(a)),
        News::Off(a) => (a.off.unwrap_or(f64::NAN), wording::released(a)),
        News::None | News::Line(_) | News::Histogram(_) | News::Notice(_) => return,
    };
    bar.suspend(|| say!("{t:8.3} s  {text}"));
}

/// JSON as it comes, one object a line.
struct JsonLines {
    out: io::BufWriter<stdout::Stdout>,
}

impl JsonLines {
    fn new() -> Self {
        Self {
            out: io::BufWriter::new(stdout::Stdout),
        }
    }

    fn put(&mut self, value: &impl Serialize) {
        // Standard output keeps its first failure itself; flush tells it.
        let _ = serde_json::to_writer(&mut self.out, value)
            .map_err(io::Error::from)
            .and_then(|()| self.out.write_all(b"\n"));
    }

    /// What has been said so far reaches the reader.
    ///
    /// # Errors
    /// It could not be written.
    fn flush(&mut self) -> Result<(), Failure> {
        let _ = self.out.flush();
        stdout::check()
    }
}

/// The last line. As a type of its own it is written as it goes: a tree of ten thousand
/// alarms would take as much memory again as everything else.
#[derive(Serialize)]
struct Last<'a> {
    summary: &'a Summary,
}

/// Those who hear what a monitor says as it says it: a reader of JSON or a person, and
/// the page.
pub struct Audience<'a> {
    args: &'a MonitorArgs,
    bar: ProgressBar,
    json: Option<JsonLines>,
    quiet: bool,
    advisor: Advisor,
    added: Option<Added>,
    page: Option<Page>,
    samples: u64,
    screen: Option<Screen>,
    /// Whoever reads is told at once what to turn.
    advises: bool,
}

/// How a run ended.
pub struct Finished {
    /// The closing record, with advice.
    pub summary: Summary,
    /// Who gave it.
    pub advisor: Advisor,
    /// Exit code.
    pub code: u8,
}

/// What a page is made of.
struct Page {
    name: String,
    fs: f64,
    band_hz: (f64, f64),
    sound: Sound,
    course: Course,
}

impl<'a> Audience<'a> {
    /// Nothing has been said yet.
    pub fn new(
        args: &'a MonitorArgs,
        about: &About,
        job: &MonitorJob,
        structure: Option<Structure<f64>>,
        reach: Reach,
        bar: ProgressBar,
    ) -> Self {
        let band = job.monitor.band();
        let band_hz = (band.low_hz, band.high_hz);
        let page = || Page {
            name: about.path.display().to_string(),
            fs: about.fs,
            band_hz,
            sound: match args.window {
                Some(window) => Sound::new(about.fs, band_hz).within(window),
                None => Sound::new(about.fs, band_hz),
            },
            course: match args.window {
                Some(window) => Course::default().within(window),
                None => Course::default(),
            },
        };
        Self {
            args,
            bar,
            json: args.json.then(JsonLines::new),
            quiet: false,
            advisor: Advisor::new(args, reach, structure),
            added: structure.map(Added::new),
            page: args.report.as_ref().map(|_| page()),
            samples: 0,
            screen: None,
            advises: about.samples.is_none(),
        }
    }

    /// Shown on a screen as it goes.
    pub fn on(self, screen: Screen) -> Self {
        Self {
            screen: Some(screen),
            ..self
        }
    }

    /// Says nothing on standard output.
    pub fn quiet(self) -> Self {
        Self {
            quiet: true,
            ..self
        }
    }

    /// A controller tells the speed.
    pub fn told_live(self) -> Self {
        Self {
            advisor: self.advisor.told_live(),
            // The controller's orders say it.
            advises: false,
            ..self
        }
    }

    /// What happened between listening and controller.
    pub fn beside(&mut self, record: &ActRecord) {
        match &mut self.json {
            Some(json) => json.put(record),
            None if !self.quiet => self.bar.suspend(|| say!("{}", words(record))),
            None => {}
        }
    }

    /// The samples that come next, for the pictures.
    pub fn hear(&mut self, samples: &[f64]) {
        if let Some(page) = &mut self.page {
            samples.iter().for_each(|x| page.sound.push(*x));
        }
        if let Some(screen) = &self.screen {
            screen.samples(samples);
        }
        self.samples += samples.len() as u64;
        self.bar.set_position(self.samples);
    }

    /// What was said.
    pub fn take(&mut self, mut news: News) {
        if let (News::Line(line), Some(added)) = (&mut news, &mut self.added) {
            added.take(line);
        }
        self.advisor.take(&mut news);
        if let Some(page) = &mut self.page {
            page.course.take(&news);
        }
        if let Some(screen) = &self.screen {
            screen.news(&news);
            if let News::On(_) = &news {
                screen.advice(self.advisor.words());
            }
        }
        match (&news, &mut self.json) {
            (News::Line(line), Some(json)) => json.put(line),
            (_, None) if !self.quiet && self.screen.is_none() => {
                alarm(&news, &self.bar);
                if self.advises && matches!(news, News::On(_)) && self.advisor.missing().is_empty()
                {
                    let first = self.advisor.words().into_iter().take(1);
                    first.for_each(|text| self.bar.suspend(|| say!("{:12}{text}", "")));
                }
            }
            _ => {}
        }
    }

    /// Passes on what has been said; false where nobody is left to hear more: what is said
    /// cannot be written any more, and no page is wanted.
    pub fn listens(&mut self) -> bool {
        let read = match &mut self.json {
            Some(json) => json.flush(),
            None => stdout::check(),
        };
        read.is_ok() || self.page.is_some()
    }

    /// Summary, page and exit code of a finished run.
    ///
    /// # Errors
    /// Output cannot be written.
    pub fn finish(mut self, mut summary: Summary) -> Result<Finished, Failure> {
        self.bar.finish_and_clear();
        // What follows is said where it stays to be read.
        let shown = self.screen.take().map_or(Ok(()), Screen::close);
        self.advisor.add_to(&mut summary);
        summary.notes = notes_by_key(&self.args.notes).map_err(Failure::Usage)?;
        if let Some(mut json) = self.json {
            for notice in &summary.notices {
                eprintln!("{}", wording::notice(notice));
            }
            json.put(&Last { summary: &summary });
            // What could not be written is told when the command ends, its page in place.
            let _ = json.flush();
        } else if self.quiet {
            for notice in &summary.notices {
                eprintln!("{}", wording::notice(notice));
            }
        } else {
            verdict(&summary);
            pair::words(summary.channels.as_deref().unwrap_or_default());
            if let Some(added) = self.added {
                added.words();
            }
        }
        if let (Some(dir), Some(page)) = (&self.args.report, &self.page) {
            write(dir, self.args, page, (&summary, &self.advisor))?;
        }
        shown?;
        Ok(Finished {
            code: u8::from(!summary.alarms.is_empty()),
            summary,
            advisor: self.advisor,
        })
    }
}

/// The verdict in a few lines.
pub fn verdict(summary: &Summary) {
    for notice in &summary.notices {
        say!("{}", wording::notice(notice));
    }
    if summary.notices_left_out > 0 {
        say!("And {} more warnings like these.", summary.notices_left_out);
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
            "Chatter at {:.1} Hz from {:.3} s {until}, damping {}.",
            alarm.f,
            alarm.on,
            damping_words(alarm)
        );
    }
    if summary.alarms_left_out > 0 {
        say!("And {} times more.", summary.alarms_left_out);
    }
    let mut states: Vec<(&State, &f64)> = summary.state_seconds.iter().collect();
    states.sort_by(|a, b| b.1.total_cmp(a.1));
    let words: Vec<String> = states
        .iter()
        .map(|(state, s)| format!("{} {s:.2} s", state.name()))
        .collect();
    say!("Time spent: {}.", words.join(", "));
}

/// Writes the page of a recording.
fn write(
    dir: &Path,
    args: &MonitorArgs,
    page: &Page,
    (summary, advisor): (&Summary, &Advisor),
) -> Result<(), Failure> {
    // A pipe has no date that means anything.
    let file = std::fs::metadata(&args.input.input)
        .ok()
        .filter(std::fs::Metadata::is_file);
    let provenance = Provenance {
        recorded: file.and_then(|file| file.modified().ok()),
        notes: args.notes.clone(),
        ..Provenance::of_this_run()
    };
    let path = report::write(
        dir,
        &ReportInput {
            title: &page.name,
            source_name: &page.name,
            sound: &page.sound,
            fs: page.fs,
            course: &page.course,
            summary,
            threshold: args.threshold,
            band_hz: page.band_hz,
            rpm: args.rpm,
            teeth: args.teeth,
            truth_onset_s: None,
            truth_note: None,
            missing: Some(&advisor.missing()),
            window_s: args.window,
            provenance: &provenance,
            version: env!("CARGO_PKG_VERSION"),
        },
    )?;
    eprintln!("report: {}", path.display());
    Ok(())
}
