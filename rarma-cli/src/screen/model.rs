//! What the screen knows: a plain value, changed by what is heard and said.

use super::spectrum::{ROW_S, Row, Waterfall};
use crate::advice::{AtBox, USUAL_HZ, sentences};
use crate::collect::News;
use crate::frames::{control_words, fault_words, status_words, words};
use crate::output::aside;
use crate::record::{Alarm, Line};
use crate::translate;
use crate::wording;
use rarma_box::settings::{MONITOR_BAND_HIGH, MONITOR_BAND_LOW, MONITOR_THRESHOLD, SettingValue};
use rarma_box::wire::{Answer, Status, Telemetry};
use std::collections::VecDeque;

/// Lines of the log that are kept.
const LOG: usize = 500;
/// Levels in the trend.
const TREND: usize = 120;
/// So long after raw samples more of them are waited for, s.
const SAMPLES_S: f64 = 0.5;

/// Numbers of the settings of a box that are shown.
pub(crate) fn settings() -> Vec<u16> {
    let real = [MONITOR_THRESHOLD, MONITOR_BAND_LOW, MONITOR_BAND_HIGH];
    let real = real.into_iter().map(|key| key.number());
    real.chain([AtBox::setting()]).collect()
}

/// How a line of the log is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Alarm,
    Released,
    Notice,
    /// What was typed.
    Said,
    /// What came back, or happened.
    Answer,
}

/// A line of the log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    /// Time of what is listened to, s.
    pub(super) t_s: Option<f64>,
    pub(super) kind: Kind,
    pub(super) text: String,
}

/// What a box says of itself beside its verdicts.
#[derive(Debug, Clone, Default)]
pub(super) struct BoxModel {
    pub(super) status: Option<Status>,
    /// Whole frames, and what was lost, if anything.
    pub(super) frames: u64,
    pub(super) losses: Option<String>,
    ear: AtBox,
}

impl BoxModel {
    /// Stage, readings, fault and control, a line each.
    pub(super) fn lines(&self) -> Vec<String> {
        let Some(status) = &self.status else {
            return vec!["no status yet".to_owned()];
        };
        let fault = match &status.fault {
            Some(fault) => format!(
                "FAULT {}: `clear` when its cause is gone",
                fault_words(fault)
            ),
            None => "no fault".to_owned(),
        };
        let link = match &self.losses {
            Some(losses) => losses.clone(),
            None => format!("{} frames, none lost", self.frames),
        };
        vec![
            status_words(status),
            format!("{fault} · {} · {link}", control_words(&status.control)),
        ]
    }
}

/// All that the screen shows.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    /// What is listened to.
    pub(super) title: String,
    pub(super) band_hz: (f64, f64),
    /// Damping ratio below which a mode counts as undamped.
    pub(super) threshold: f64,
    pub(super) line: Option<Line>,
    /// The alarm that stands.
    pub(super) standing: Option<Alarm>,
    /// Alarms so far.
    pub(super) alarms: u64,
    pub(super) advice: Vec<String>,
    pub(super) waterfall: Waterfall,
    /// Root mean square of the band, the newest last.
    pub(super) levels: VecDeque<f32>,
    pub(super) log: VecDeque<Entry>,
    /// How far what is listened to has come, s; of a box, its clock.
    pub(super) t_s: f64,
    /// Then the last verdict came, and the last row of modes.
    pub(super) verdict_s: f64,
    row_s: f64,
    /// None where no box is talked to.
    pub(super) at_box: Option<BoxModel>,
}

impl Model {
    /// Nothing is known yet.
    pub(crate) fn new(title: String, band_hz: (f64, f64), threshold: f64) -> Self {
        Self {
            title,
            band_hz,
            threshold,
            line: None,
            standing: None,
            alarms: 0,
            advice: Vec::new(),
            waterfall: Waterfall::default(),
            levels: VecDeque::new(),
            log: VecDeque::new(),
            t_s: 0.0,
            verdict_s: 0.0,
            row_s: 0.0,
            at_box: None,
        }
    }

    /// A box is talked to; until it tells its settings, the usual ones are assumed.
    pub(crate) fn of_a_box(title: String) -> Self {
        use rarma_core::monitor::MonitorConfig;
        let usual = MonitorConfig::new(USUAL_HZ);
        let band = usual.band();
        Self {
            at_box: Some(BoxModel::default()),
            ..Self::new(title, (band.low_hz, band.high_hz), usual.threshold)
        }
    }

    /// A line for the log.
    pub(crate) fn log(&mut self, t_s: Option<f64>, kind: Kind, text: String) {
        self.log.push_back(Entry { t_s, kind, text });
        if self.log.len() > LOG {
            self.log.pop_front();
        }
    }

    /// What a monitor says.
    pub(super) fn news(&mut self, news: &News) {
        match news {
            News::Line(line) => {
                (self.t_s, self.verdict_s) = (line.t, line.t);
                self.line = Some(line.clone());
            }
            News::On(alarm) => self.alarm(alarm, alarm.on),
            News::Off(alarm) => self.released(alarm, alarm.off.unwrap_or(self.t_s)),
            News::Notice(notice) => {
                self.log(Some(notice.t), Kind::Notice, wording::notice(notice));
            }
            News::None | News::Histogram(_) => {}
        }
    }

    fn alarm(&mut self, alarm: &Alarm, t_s: f64) {
        self.alarms += 1;
        self.log(Some(t_s), Kind::Alarm, wording::called(alarm));
        self.standing = Some(alarm.clone());
    }

    fn released(&mut self, alarm: &Alarm, t_s: f64) {
        self.standing = None;
        self.log(Some(t_s), Kind::Released, wording::released(alarm));
    }

    /// A row of the spectrum, and the level of the band.
    pub(super) fn row(&mut self, row: Row, rms: f32) {
        self.waterfall.push(row);
        self.levels.push_back(rms);
        if self.levels.len() > TREND {
            self.levels.pop_front();
        }
    }

    /// What a box says; `own`: it answers what nobody has typed.
    pub(super) fn message(&mut self, message: &Telemetry, own: bool) {
        let fs = self.fs();
        let Some(at_box) = &mut self.at_box else {
            return;
        };
        let advice = at_box.ear.take(message);
        match message {
            Telemetry::Status(status) => {
                at_box.status = Some(*status);
                self.t_s = 1e-6 * status.now_us as f64;
            }
            Telemetry::Verdict(verdict) => {
                let line = translate::line(verdict, fs);
                self.verdict_s = self.t_s;
                // As often as rows of samples, where none of those come.
                if line.t >= self.row_s + ROW_S || line.t < self.row_s - SAMPLES_S {
                    self.row_s = line.t;
                    let modes = line.modes.iter().map(|mode| mode.f).collect();
                    self.row(Row::Modes(modes), verdict.level);
                }
                self.line = Some(line);
            }
            Telemetry::Alarm(message) => {
                let alarm = translate::alarm(message, fs);
                if message.on {
                    self.alarm(&alarm, self.t_s);
                    self.advice = match advice {
                        Some(advice) => sentences(&advice),
                        None => vec!["Which speed to turn instead cannot be said: `set monitor.spindle HZ` and `set monitor.teeth N` tell speed and teeth.".to_owned()],
                    };
                } else {
                    self.released(&alarm, self.t_s);
                }
                return;
            }
            Telemetry::Reply(reply) => {
                if let Answer::Setting(s) = &reply.answer {
                    self.setting(s.setting, s.value);
                }
            }
            _ => {}
        }
        // Speed or teeth were told after the alarm.
        if let Some(advice) = advice {
            self.advice = sentences(&advice);
        }
        let kind = match message {
            Telemetry::Fault(_) | Telemetry::Refused(_) | Telemetry::Notice(_) => Kind::Notice,
            Telemetry::Status(_) | Telemetry::Health(_) => return,
            _ if own => return,
            _ => Kind::Answer,
        };
        if let Some(text) = words(message) {
            let status = self.at_box.as_ref().and_then(|at_box| at_box.status);
            // Until its first status its clock is not known.
            self.log(status.map(|_| self.t_s), kind, text);
        }
    }

    /// A row of the spectrum of raw samples, in place of one of modes.
    pub(super) fn spectrum_row(&mut self, row: Row) {
        self.row_s = self.line.as_ref().map_or(0.0, |line| line.t) + SAMPLES_S;
        self.waterfall.push(row);
    }

    /// Rate of a box's microphone, Hz.
    pub(super) fn fs(&self) -> f64 {
        self.at_box
            .as_ref()
            .map_or(USUAL_HZ, |at_box| at_box.ear.fs_hz())
    }

    /// Frames of a box so far, and what was lost of them.
    pub(super) fn frames(&mut self, whole: u64, lost: Option<String>) {
        if let Some(at_box) = &mut self.at_box {
            (at_box.frames, at_box.losses) = (whole, lost);
        }
    }

    /// A setting that changes what is drawn.
    fn setting(&mut self, number: u16, value: SettingValue) {
        match value {
            SettingValue::Real(x) if number == MONITOR_THRESHOLD.number() => {
                self.threshold = f64::from(x);
            }
            SettingValue::Real(x) if number == MONITOR_BAND_LOW.number() => {
                self.band_hz.0 = f64::from(x);
            }
            SettingValue::Real(x) if number == MONITOR_BAND_HIGH.number() => {
                self.band_hz.1 = f64::from(x);
            }
            _ => {}
        }
    }

    /// What others in this program would have printed.
    pub(super) fn take_aside(&mut self) {
        for text in aside::news() {
            self.log(None, Kind::Notice, text);
        }
    }
}
