//! Telemetry of a box to the records of a run.

use crate::record::{Alarm, Label, Line, ModeRecord, Run, State, Summary};
use rarma_core::condition::HealthCounts;
use rarma_core::decide::{self, Agreement};
use rarma_core::wire::{Finished, ModeMessage, Refusal, Telemetry, Verdict};
use std::collections::BTreeMap;

/// Puts messages together as they come.
#[derive(Debug, Default)]
pub struct Collector {
    fs: f64,
    order: [usize; 2],
    lines: Vec<Line>,
    alarms: Vec<Alarm>,
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
        Some(Run {
            lines: self.lines,
            summary: Summary {
                fs: self.fs,
                samples: finished.samples,
                order: self.order,
                alarms: self.alarms,
                state_seconds,
                channels: None,
            },
        })
    }
}

/// States in the order of [`decide::State`].
const STATES: [State; 6] = [
    State::Starting,
    State::Idle,
    State::Stable,
    State::Warning,
    State::Chatter,
    State::Invalid,
];

fn line(verdict: &Verdict, fs: f64) -> Line {
    Line {
        t: verdict.sample as f64 / fs,
        state: STATES[verdict.state as usize],
        modes: verdict.modes.iter().map(mode).collect(),
        agreement: None,
    }
}

fn mode(m: &ModeMessage) -> ModeRecord {
    ModeRecord {
        f: decimal(m.frequency),
        f_sd: decimal(m.frequency_sd),
        zeta: decimal(m.damping),
        zeta_sd: decimal(m.damping_sd),
        amplitude: decimal(m.amplitude),
        label: match m.label {
            decide::Label::SelfExcited => Label::SelfExcited,
            decide::Label::Structural => Label::Structural,
            decide::Label::Forced => Label::Forced,
        },
        harmonic: m.harmonic,
        zeta_process: None,
        zeta_process_sd: None,
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
