//! Telemetry of a box to the records of a run, message by message.
//!
//! Nothing here grows with the length of a run: lines are handed on, and of alarms and
//! notices so many are kept that a day of them is still to be read.

use crate::record::{
    Alarm, HistogramRecord, Line, NoticeRecord, Run, SpeedSource, SpindleRecord, SpindleSummary,
    State, Summary,
};
use crate::standing::StandingAlarm;
use crate::translate::{alarm, decimal, line, notice};
use rarma_box::wire::{Finished, Refusal, Telemetry};
use rarma_core::condition::HealthCounts;
use rarma_core::decide::Histogram;
use rarma_core::named::Named;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Alarms that a summary lists, the first ones; the others are counted.
pub const MOST_ALARMS: usize = 10_000;
/// Notices that a summary lists, likewise.
pub const MOST_NOTICES: usize = 1_000;

/// Puts messages together as they come.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Collector {
    fs: f64,
    order: [usize; 2],
    alarms: Vec<Alarm>,
    /// The last alarm called, if it has not been released.
    standing: Option<StandingAlarm>,
    alarms_left_out: u64,
    notices: Vec<NoticeRecord>,
    notices_left_out: u64,
    rpm_first: Option<f64>,
    rpm_last: Option<f64>,
    notch_hz: Option<f64>,
    finished: Option<Finished>,
    refused: Option<Refusal>,
}

/// What a message was, for those who show and keep things as they happen.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// Nothing to show.
    None,
    /// A telemetry line.
    Line(Line),
    /// An alarm was called.
    On(Alarm),
    /// An alarm was released.
    Off(Alarm),
    /// How the followed mode's amplitude was distributed.
    Histogram(HistogramRecord),
    /// Something is wrong with what is known of the spindle.
    Notice(NoticeRecord),
}

impl Collector {
    /// For a box that is listening already, at this rate, Hz: what began before was not heard.
    pub fn of_rate(fs_hz: f64) -> Self {
        Self {
            fs: fs_hz,
            ..Self::default()
        }
    }

    /// Takes one message.
    pub fn take(&mut self, message: &Telemetry) -> News {
        match message {
            Telemetry::Started { fs_hz, p, q } => {
                self.fs = *fs_hz;
                self.order = [usize::from(*p), usize::from(*q)];
            }
            Telemetry::Verdict(verdict) => {
                let line = line(verdict, self.fs);
                self.spindle(&line.spindle);
                if let Some(standing) = &mut self.standing {
                    standing.read(&line);
                }
                return News::Line(line);
            }
            Telemetry::Alarm(message) => {
                let now = alarm(message, self.fs);
                if message.on {
                    self.keep_standing();
                    self.standing = Some(StandingAlarm::new(now.clone()));
                    return News::On(now);
                } else if let Some(standing) = self.standing.take() {
                    let alarm = Alarm {
                        off: Some(now.on),
                        f: now.f,
                        zeta: now.zeta,
                        ..standing.told()
                    };
                    self.keep(alarm.clone());
                    return News::Off(alarm);
                }
            }
            Telemetry::Finished(finished) => {
                self.finished = Some(*finished);
                if let (Some((f, zeta)), Some(standing)) = (finished.standing, &mut self.standing) {
                    standing.alarm.f = decimal(f);
                    standing.alarm.zeta = decimal(zeta);
                }
            }
            Telemetry::Refused(refusal) => self.refused = Some(*refusal),
            Telemetry::Amplitude(message) => {
                return News::Histogram(HistogramRecord {
                    t: message.sample as f64 / self.fs,
                    f: decimal(message.frequency),
                    counts: Histogram {
                        counts: message.counts,
                        beyond: message.beyond,
                        bin_width: f64::from(message.bin_width),
                    },
                });
            }
            Telemetry::Notice(message) => {
                let record = NoticeRecord {
                    t: message.sample as f64 / self.fs,
                    what: notice(&message.notice),
                };
                if self.notices.len() < MOST_NOTICES {
                    self.notices.push(record.clone());
                } else {
                    self.notices_left_out += 1;
                }
                return News::Notice(record);
            }
            // What the whole box says beside its verdicts is nothing of a run's.
            Telemetry::Reply(_)
            | Telemetry::Fault(_)
            | Telemetry::Status(_)
            | Telemetry::Health(_)
            | Telemetry::Raw(_)
            | Telemetry::Circle(_)
            | Telemetry::Excitation(_)
            | Telemetry::Control(_)
            | Telemetry::Hello(_) => {}
        }
        News::None
    }

    fn keep_standing(&mut self) {
        if let Some(standing) = self.standing.take() {
            self.keep(standing.told());
        }
    }

    fn keep(&mut self, alarm: Alarm) {
        if self.alarms.len() < MOST_ALARMS {
            self.alarms.push(alarm);
        } else {
            self.alarms_left_out += 1;
        }
    }

    /// The spindle over the whole run, as far as lines tell.
    fn spindle(&mut self, spindle: &SpindleRecord) {
        if matches!(spindle.source, SpeedSource::Sound | SpeedSource::Tacho)
            && let Some(rpm) = spindle.rpm
        {
            self.rpm_first.get_or_insert(rpm);
            self.rpm_last = Some(rpm);
        }
        if spindle.locked {
            let widest = self.notch_hz.unwrap_or(spindle.notch_hz);
            self.notch_hz = Some(widest.max(spindle.notch_hz));
        }
    }

    /// It may have come from another one over the same run so far: nothing in it is more than is kept.
    pub(crate) fn continues(&self, other: &Self) -> bool {
        let standing = self.standing.as_ref();
        self.fs.to_bits() == other.fs.to_bits()
            && self.order == other.order
            && self.alarms.len() <= MOST_ALARMS
            && self.notices.len() <= MOST_NOTICES
            && standing.is_none_or(StandingAlarm::is_sound)
            && self.finished.is_none()
            && self.refused.is_none()
    }

    /// Why the box would not go on, if it said so.
    pub fn refused(&self) -> Option<Refusal> {
        self.refused
    }

    /// Totals of the run, once it has finished.
    pub fn finished(&self) -> Option<&Finished> {
        self.finished.as_ref()
    }

    /// Bad samples the run met, once it has finished.
    pub fn health(&self) -> Option<HealthCounts> {
        self.finished.map(|f| f.health)
    }

    /// The closing record, none if the last message has not come.
    pub fn summary(mut self) -> Option<Summary> {
        let finished = self.finished?;
        self.keep_standing();
        let mut state_seconds = BTreeMap::new();
        for (state, samples) in State::ALL.iter().zip(finished.state_samples) {
            if samples > 0 {
                state_seconds.insert(*state, samples as f64 / self.fs);
            }
        }
        let removed = f64::from(finished.removed_fraction);
        Some(Summary {
            fs: self.fs,
            samples: finished.samples,
            order: self.order,
            alarms: self.alarms,
            alarms_left_out: self.alarms_left_out,
            state_seconds,
            notices: self.notices,
            notices_left_out: self.notices_left_out,
            spindle: SpindleSummary {
                rpm_first: self.rpm_first,
                rpm_last: self.rpm_last,
                locked_s: finished.locked_samples as f64 / self.fs,
                notch_hz: self.notch_hz,
            },
            removed_db: (removed > 0.0).then(|| 10.0 * removed.log10()),
            channels: None,
            notes: BTreeMap::new(),
        })
    }
}

/// A collector that keeps every line: for runs of minutes.
#[derive(Debug, Default)]
pub struct WholeRun {
    collector: Collector,
    lines: Vec<Line>,
    histograms: Vec<HistogramRecord>,
}

impl WholeRun {
    /// Takes one message.
    pub fn take(&mut self, message: &Telemetry) {
        let news = self.collector.take(message);
        self.keep(news);
    }

    /// Keeps what a collector elsewhere has said.
    pub fn keep(&mut self, news: News) {
        match news {
            News::Line(line) => self.lines.push(line),
            News::Histogram(histogram) => self.histograms.push(histogram),
            News::None | News::On(_) | News::Off(_) | News::Notice(_) => {}
        }
    }

    /// The run, none if its last message has not come.
    pub fn run(self) -> Option<Run> {
        let summary = self.collector.summary()?;
        Some(Run {
            lines: self.lines,
            summary,
            histograms: self.histograms,
        })
    }

    /// The run with the summary of a collector elsewhere.
    pub fn with(self, summary: Summary) -> Run {
        Run {
            lines: self.lines,
            summary,
            histograms: self.histograms,
        }
    }
}
