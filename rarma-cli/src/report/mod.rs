//! A run as one page: `index.html`, with nothing to load from elsewhere.
//!
//! The page says first, in words, what a machinist wants to know; then come the
//! alarms, four pictures and a strip of states over one common time axis, one of an
//! amplitude, the reasons, and
//! what is needed to doubt it: settings, uncertainty, how to read it. Pictures
//! are SVG (the waterfall a bitmap inside one), coloured by the page's style
//! sheet, so that dark mode and print work. Points are thinned to the pixels
//! they would hide behind, and as they come ([`Sound`], [`Course`]): a minute of signal
//! stays well below 2 MB, and a day takes no more memory than it.

mod advice;
mod amplitude;
mod band;
pub mod comparison;
mod course;
mod date;
mod density;
mod modes;
mod moment;
mod multiples;
mod provenance;
mod scene;
mod signal;
pub(crate) mod sound;
mod tables;
#[cfg(test)]
mod tests;
mod timeline;
mod waterfall;
pub(crate) mod words;

pub use course::Course;
pub use provenance::Provenance;
pub use sound::Sound;
pub use tables::{damping_words, reason_words};
pub use words::{Tone, headline};

use crate::advice::Missing;
use crate::failure::Failure;
use crate::output;
use crate::record::Summary;
use rarma_pictures::text::escape;
use rarma_pictures::{STYLE, put};
use scene::Scene;
use std::path::{Path, PathBuf};

/// Everything a report is made of.
#[derive(Debug, Clone)]
pub struct ReportInput<'a> {
    /// Title of the page, such as the name of the job.
    pub title: &'a str,
    /// Where the samples came from, for the settings table.
    pub source_name: &'a str,
    /// The analysed channel, input units.
    pub sound: &'a Sound,
    /// Its sampling rate, Hz.
    pub fs: f64,
    /// What the monitor said as it went.
    pub course: &'a Course,
    /// What it said at the end.
    pub summary: &'a Summary,
    /// Damping ratio below which a mode counts as undamped, 1.
    pub threshold: f64,
    /// Lower and upper edge of the analysed band, Hz.
    pub band_hz: (f64, f64),
    /// Spindle speed, 1/min, if known.
    pub rpm: Option<f64>,
    /// Teeth of the cutter, if known.
    pub teeth: Option<u32>,
    /// When the cut truly lost stability, s, if a simulation told.
    pub truth_onset_s: Option<f64>,
    /// Where that truth comes from, in a few words.
    pub truth_note: Option<String>,
    /// What is missing to say which speed to turn instead; `None`: nobody asks.
    pub missing: Option<&'a [Missing]>,
    /// Stretch that the pictures show, s; `None`: all.
    pub window_s: Option<(f64, f64)>,
    /// When, by which command, and what the user noted.
    pub provenance: &'a Provenance,
    /// Version of the program that made the run.
    pub version: &'a str,
}

/// Writes `index.html` into `dir`, which is created if it is not there, and
/// returns its path.
///
/// # Errors
/// The directory or the file cannot be written.
pub fn write(dir: &Path, job: &ReportInput<'_>) -> Result<PathBuf, Failure> {
    sheet_into(dir, page(job))
}

/// Writes a page as `index.html` into `dir`, which is created if it is not there, and returns
/// its path. A page that is there already stays until the new one is whole.
///
/// # Errors
/// The directory or the file cannot be written.
pub fn sheet_into(dir: &Path, page: String) -> Result<PathBuf, Failure> {
    output::folder(dir)?;
    let path = dir.join("index.html");
    output::write(&path, page)?;
    Ok(path)
}

/// [`sheet_into`], and a line that says where, unless `quiet`.
///
/// # Errors
/// As there.
pub fn sheet_told(dir: &Path, page: String, quiet: bool) -> Result<(), Failure> {
    let page = sheet_into(dir, page)?;
    if !quiet {
        say!("Report: {}", page.display());
    }
    Ok(())
}

/// The page as a string.
pub fn page(job: &ReportInput<'_>) -> String {
    let scene = Scene::new(job);
    let verdict = words::verdict(&scene);
    let mut html = String::new();
    put!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}: {headline}</title>\n<style>\n{style}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"job\">{title}</p>\n\
         <h1 class=\"{tone}\"><span class=\"sign\" aria-hidden=\"true\">{sign}</span>{headline}</h1>\n",
        title = escape(job.title),
        headline = escape(&verdict.headline),
        style = STYLE,
        tone = verdict.tone.class(),
        sign = verdict.tone.sign(),
    );
    for sentence in &verdict.details {
        put!(html, "<p>{}</p>\n", escape(sentence));
    }
    html.push_str(&job.provenance.line());
    html.push_str("</header>\n<main>\n");
    html.push_str(&advice::section(job));
    html.push_str(&tables::alarms(&scene));
    html.push_str(
        "<section aria-label=\"Pictures over time\">\n<h2>What was seen, over time</h2>\n",
    );
    html.push_str(&words::on_the_window(&scene));
    html.push_str(&signal::figure(&scene));
    html.push_str(&waterfall::figure(&scene));
    html.push_str(&modes::damping(&scene));
    html.push_str(&modes::frequency(&scene));
    html.push_str(&timeline::figure(&scene));
    html.push_str(&amplitude::figure(&scene));
    html.push_str("</section>\n");
    html.push_str(&tables::reasons(&scene));
    html.push_str(&words::how_to_read(&scene));
    html.push_str(&tables::settings(&scene));
    put!(
        html,
        "</main>\n<footer><p>rarma {}</p></footer>\n</body>\n</html>\n",
        escape(job.version)
    );
    html
}
