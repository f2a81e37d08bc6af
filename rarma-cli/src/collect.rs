//! Telemetry of a box to the records of a run.

use crate::record::{
    Alarm, HistogramRecord, Line, NoticeRecord, Run, SpeedSource, SpindleSummary, Summary,
};
use crate::translate::{STATES, line, notice};
use rarma_core::condition::HealthCounts;
use rarma_core::decide::{Agreement, Histogram};
use rarma_core::wire::{Finished, Refusal, Telemetry};
use std::collections::BTreeMap;

/// Puts messages together as they come.
#[derive(Debug, Default)]
pub struct Collector {
    fs: f64,
    order: [usize; 2],
    lines: Vec<Line>,
    alarms: Vec<Alarm>,
    notices: Vec<NoticeRecord>,
    histograms: Vec<HistogramRecord>,
    finished: Option<Finished>,
    refused: Option<Refusal>,
}

/// What a message was, for a caller that shows things as they happen.
#[derive(Debug, Clone, PartialEq)]
pub enum News<'a> {
    /// Nothing to show.
    None,
    /// A telemetry line.
    Line(&'a Line),
    /// An alarm was called.
    On(&'a Alarm),
    /// An alarm was released.
    Off(&'a Alarm),
}

impl Collector {
    /// Takes one message.
    pub fn take(&mut self, message: &Telemetry) -> News<'_> {
        match message {
            Telemetry::Started { fs_hz, p, q } => {
                self.fs = *fs_hz;
                self.order = [usize::from(*p), usize::from(*q)];
            }
            Telemetry::Verdict(verdict) => {
                self.lines.push(line(verdict, self.fs));
                if let Some(last) = self.lines.last() {
                    return News::Line(last);
                }
            }
            Telemetry::Alarm(message) => {
                let t = message.sample as f64 / self.fs;
                if message.on {
                    self.alarms.push(Alarm {
                        on: t,
                        off: None,
                        f: decimal(message.frequency),
                        zeta: decimal(message.damping),
                    });
                    if let Some(alarm) = self.alarms.last() {
                        return News::On(alarm);
                    }
                } else if let Some(alarm) = self.alarms.last_mut() {
                    alarm.off = Some(t);
                    alarm.f = decimal(message.frequency);
                    alarm.zeta = decimal(message.damping);
                    return News::Off(alarm);
                }
            }
            Telemetry::Finished(finished) => {
                self.finished = Some(*finished);
                if let (Some((f, zeta)), Some(alarm)) = (finished.standing, self.alarms.last_mut())
                    && alarm.off.is_none()
                {
                    alarm.f = decimal(f);
                    alarm.zeta = decimal(zeta);
                }
            }
            Telemetry::Refused(refusal) => self.refused = Some(*refusal),
            Telemetry::Amplitude(message) => self.histograms.push(HistogramRecord {
                t: message.sample as f64 / self.fs,
                f: decimal(message.frequency),
                counts: Histogram {
                    counts: message.counts,
                    beyond: message.beyond,
                    bin_width: f64::from(message.bin_width),
                },
            }),
            Telemetry::Notice(message) => self.notices.push(NoticeRecord {
                t: message.sample as f64 / self.fs,
                what: notice(&message.notice),
            }),
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

    /// Who hears the mode in question at the last line; of a pair only.
    pub fn agreed(&mut self, agreement: Agreement) {
        if let Some(line) = self.lines.last_mut() {
            line.agreement = Some(agreement);
        }
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

    /// The run, none if its last message has not come.
    pub fn run(self) -> Option<Run> {
        let finished = self.finished?;
        let mut state_seconds = BTreeMap::new();
        for (state, samples) in STATES.iter().zip(finished.state_samples) {
            if samples > 0 {
                state_seconds.insert(*state, samples as f64 / self.fs);
            }
        }
        let removed = f64::from(finished.removed_fraction);
        let locked_s = finished.locked_samples as f64 / self.fs;
        Some(Run {
            histograms: self.histograms,
            summary: Summary {
                fs: self.fs,
                samples: finished.samples,
                order: self.order,
                alarms: self.alarms,
                state_seconds,
                notices: self.notices,
                spindle: spindle(&self.lines, locked_s),
                removed_db: (removed > 0.0).then(|| 10.0 * removed.log10()),
                channels: None,
            },
            lines: self.lines,
        })
    }
}

/// The spindle over the whole run, as far as lines tell.
fn spindle(lines: &[Line], locked_s: f64) -> SpindleSummary {
    let read = |line: &&Line| {
        let source = line.spindle.source;
        matches!(source, SpeedSource::Sound | SpeedSource::Tacho) && line.spindle.rpm.is_some()
    };
    let first = lines.iter().find(read);
    let last = lines.iter().rfind(read);
    let blind = lines.iter().filter(|line| line.spindle.locked);
    SpindleSummary {
        rpm_first: first.and_then(|line| line.spindle.rpm),
        rpm_last: last.and_then(|line| line.spindle.rpm),
        locked_s,
        notch_hz: blind.map(|line| line.spindle.notch_hz).reduce(f64::max),
    }
}

/// A single-precision number as the shortest decimal that stands for it, so that
/// 0.01 is printed as 0.01.
pub(crate) fn decimal(x: f32) -> f64 {
    if !x.is_finite() {
        return f64::from(x);
    }
    x.to_string().parse().unwrap_or(f64::from(x))
}
