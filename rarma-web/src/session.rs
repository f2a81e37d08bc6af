//! One listening, from its settings to its report.

use crate::ear::{Ear, Said};
use crate::pictures::Pictures;
use crate::settings::Settings;
use crate::view::{Heard, InWords, Scale};
use rarma_cli::Failure;
use rarma_cli::advice::{missing_words, sentences};
use rarma_cli::collect::News;
use rarma_cli::record::{Alarm, Line, State, Summary};
use rarma_cli::report::{self, Provenance, ReportInput};
use rarma_cli::sound_card::rate_warning;
use rarma_core::monitor::MonitorConfig;
use std::time::{Duration, SystemTime};

/// Alarms that the page lists; the report has all.
const LISTED: usize = 12;

/// Listens, and keeps what the page shows.
#[derive(Clone)]
pub struct Session {
    settings: Settings,
    ear: Ear,
    pictures: Option<Pictures>,
    last: Option<Line>,
    alarms: Vec<Alarm>,
    alarms_so_far: u64,
    live: bool,
}

impl Session {
    /// Nothing heard yet. `live`: see [`Ear::new`]; `pictures`: with what the page draws and
    /// the report.
    ///
    /// # Errors
    /// A setting that does not fit, in one line.
    pub fn new(
        settings: Settings,
        live: bool,
        pictures: bool,
        samples: Option<u64>,
    ) -> Result<Self, Failure> {
        Ok(Self {
            ear: Ear::new(&settings, live, samples)?,
            pictures: pictures.then(|| Pictures::new(&settings)),
            last: None,
            alarms: Vec::new(),
            alarms_so_far: 0,
            live,
            settings,
        })
    }

    /// Takes the samples that come next; whether there is something that the page should show
    /// at once: another state, or an alarm called or released.
    pub fn push(&mut self, samples: &[f32]) -> bool {
        let before = self.told();
        self.with_ear(|ear, hear| ear.push(samples, hear));
        self.told() != before
    }

    /// See [`Ear::missing`].
    pub fn missing(&mut self, n: u64) {
        self.with_ear(|ear, hear| ear.missing(n, hear));
    }

    /// See [`Clock::note`](crate::Clock::note).
    pub fn note_clock(&mut self, frames: u64, clock_s: f64) -> u64 {
        self.ear.note_clock(frames, clock_s)
    }

    /// See [`Ear::tell_speed`]. The report names the last speed.
    ///
    /// # Errors
    /// Out of range; nothing has changed then.
    pub fn tell_speed(&mut self, rpm: f64) -> Result<(), Failure> {
        self.ear.tell_speed(rpm).map_err(|_| {
            Failure::Usage(format!(
                "speed: {rpm} 1/min is no speed of a spindle (write 0.06 to 300000)"
            ))
        })?;
        self.settings.rpm = Some(rpm);
        Ok(())
    }

    /// What the page shows. Points are handed on once.
    pub fn heard(&mut self) -> Heard {
        let pictures = self.pictures.as_mut();
        let level = pictures.as_ref().and_then(|p| p.level).map(Into::into);
        Heard {
            t: self.ear.samples() as f64 / self.settings.fs,
            begun: self.ear.has_begun(),
            missing: self.ear.gaps(),
            alarms: self.alarms.clone(),
            alarms_so_far: self.alarms_so_far,
            level,
            points: pictures.map(Pictures::points).unwrap_or_default(),
            ..Heard::of(self.last.as_ref())
        }
    }

    /// Columns of the moving picture since the last time, one after the other; none without
    /// pictures.
    pub fn columns(&mut self) -> Vec<u8> {
        let pictures = self.pictures.as_mut();
        pictures.map(|p| p.spectrum.take()).unwrap_or_default()
    }

    /// The scale of the moving picture; none without pictures.
    pub fn scale(&self) -> Option<Scale> {
        let spectrum = &self.pictures.as_ref()?.spectrum;
        Some(Scale {
            rows: spectrum.rows(),
            top_hz: spectrum.top_hz(),
            step_s: spectrum.step_s(),
            band_hz: self.settings.band_hz(),
            threshold: self.threshold(),
            warning: rate_warning(self.settings.fs).filter(|_| self.live),
        })
    }

    fn threshold(&self) -> f64 {
        MonitorConfig::new(self.settings.fs).threshold
    }

    /// The closing record, as if the sound ended now; it may go on.
    ///
    /// # Errors
    /// None but a defect of this program.
    pub fn summary(&self) -> Result<Summary, Failure> {
        self.ear.summary()
    }

    /// The closing record in words, as the report says it.
    ///
    /// # Errors
    /// As [`summary`](Self::summary).
    pub fn headline(&self) -> Result<InWords, Failure> {
        let (tone, text) = report::headline(&self.summary()?);
        Ok(InWords {
            tone: tone.class(),
            text,
        })
    }

    /// What to do about the last alarm, a sentence each; nothing without an alarm.
    ///
    /// # Errors
    /// As [`summary`](Self::summary).
    pub fn advice(&self) -> Result<Vec<String>, Failure> {
        let summary = self.summary()?;
        let Some(alarm) = summary.alarms.last() else {
            return Ok(Vec::new());
        };
        // A speed that was told later serves as well as one from the beginning.
        if let Some(text) = missing_words(&self.ear.missing_for_advice()) {
            return Ok(vec![text]);
        }
        Ok(alarm.advice.as_deref().map(sentences).unwrap_or_default())
    }

    /// The report of `rarma monitor --report` on what was heard so far; `made_s`: now, seconds
    /// since 1970.
    ///
    /// # Errors
    /// This session has no pictures, or as [`summary`](Self::summary).
    pub fn report(&self, made_s: f64) -> Result<String, Failure> {
        let Some(pictures) = &self.pictures else {
            return Err(Failure::System(
                "report: this session keeps no pictures: a defect of the page".to_owned(),
            ));
        };
        let now = Duration::try_from_secs_f64(made_s).ok();
        let provenance = Provenance {
            made: now.and_then(|now| SystemTime::UNIX_EPOCH.checked_add(now)),
            notes: self.notes(),
            ..Provenance::default()
        };
        Ok(report::page(&ReportInput {
            title: &self.settings.name,
            source_name: &self.settings.name,
            sound: &pictures.sound,
            fs: self.settings.fs,
            course: &pictures.course,
            summary: &self.summary()?,
            threshold: self.threshold(),
            band_hz: self.settings.band_hz(),
            rpm: self.settings.rpm,
            teeth: self.settings.teeth,
            truth_onset_s: None,
            truth_note: None,
            missing: Some(&self.ear.missing_for_advice()),
            window_s: None,
            provenance: &provenance,
            version: env!("CARGO_PKG_VERSION"),
        }))
    }

    /// What the report should say of the sound beside the records.
    fn notes(&self) -> Vec<(String, String)> {
        let missing = self.ear.gaps();
        if missing.samples == 0 {
            return Vec::new();
        }
        let seconds = missing.samples as f64 / self.settings.fs;
        let text = format!("{seconds:.3} s in {} gaps", missing.gaps);
        vec![("missing".to_owned(), text)]
    }

    /// What must be shown at once when it changes.
    fn told(&self) -> (Option<State>, u64, bool) {
        let stands = self.alarms.last().is_some_and(|a| a.off.is_none());
        (
            self.last.as_ref().map(|l| l.state),
            self.alarms_so_far,
            stands,
        )
    }

    fn with_ear(&mut self, work: impl FnOnce(&mut Ear, &mut dyn FnMut(Said<'_>))) {
        let Self {
            ear,
            pictures,
            last,
            alarms,
            alarms_so_far,
            ..
        } = self;
        work(ear, &mut |said| match said {
            Said::Sample(x) => {
                if let Some(pictures) = pictures {
                    pictures.sample(x);
                }
            }
            Said::Missing(n) => {
                if let Some(pictures) = pictures {
                    pictures.missing(n);
                }
            }
            Said::News(news) => {
                if let Some(pictures) = pictures {
                    pictures.take(news);
                }
                match news {
                    News::Line(line) => *last = Some(line.clone()),
                    News::On(alarm) => {
                        *alarms_so_far += 1;
                        if alarms.len() == LISTED {
                            alarms.remove(0);
                        }
                        alarms.push(alarm.clone());
                    }
                    News::Off(alarm) => {
                        if let Some(last) = alarms.last_mut() {
                            *last = alarm.clone();
                        }
                    }
                    News::None | News::Histogram(_) | News::Notice(_) => {}
                }
            }
        });
    }
}
