//! What all pictures share: ranges, alarm spans, harmonics, and marks for them.

use super::ReportInput;
use crate::record::{NoticeKind, NoticeRecord};
use rarma_core::decide::AlarmConfig;
use rarma_pictures::Axis;
use rarma_pictures::text::{hertz, px, seconds};
use rarma_pictures::{Panel, RIGHT, Time, free};

/// An alarm as drawn.
pub(super) struct Span {
    /// Called at, s.
    pub(super) on: f64,
    /// Released at, or the end of the time axis.
    pub(super) off: f64,
    /// Frequency, Hz.
    pub(super) f: f64,
}

/// A report's input with its ranges made safe.
pub(super) struct Scene<'a> {
    /// As handed in.
    pub(super) job: &'a ReportInput<'a>,
    /// Sampling rate, positive.
    pub(super) fs: f64,
    /// End of the run, positive, s.
    pub(super) end_s: f64,
    /// Ends of the time axis, s: of the run, or of the window that is wanted.
    pub(super) t_start: f64,
    /// See [`Self::t_start`].
    pub(super) t_end: f64,
    /// Top of both frequency axes, Hz: the analysed band and a little more, for
    /// above it there is nothing but noise.
    pub(super) f_top: f64,
    /// Alarms with finite times, those of the window.
    pub(super) spans: Vec<Span>,
    /// The same as they are drawn: where there are many, those that touch are one.
    pub(super) drawn: Vec<(f64, f64)>,
}

/// Lines of which each is drawn by itself, at most: two to a pixel.
const DENSE: u64 = 1680;

impl<'a> Scene<'a> {
    /// Finds the ranges.
    pub(super) fn new(job: &'a ReportInput<'a>) -> Self {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let fs = if positive(job.fs) { job.fs } else { 1.0 };
        let alarms = job.summary.alarms.iter();
        let t_end = [job.course.end_s()]
            .into_iter()
            .chain(alarms.flat_map(|a| [a.on, a.off.unwrap_or(0.0)]))
            .filter(|t| t.is_finite())
            .fold(job.sound.heard() as f64 / fs, f64::max);
        let end_s = if positive(t_end) { t_end } else { 1.0 };
        let (t_start, t_end) = match job.window_s {
            Some((from, to)) if from >= 0.0 && to > from && from < end_s => (from, to.min(end_s)),
            _ => (0.0, end_s),
        };
        let spans: Vec<Span> = job
            .summary
            .alarms
            .iter()
            .filter(|a| a.on.is_finite())
            .map(|a| Span {
                on: a.on,
                off: a.off.filter(|t| t.is_finite()).unwrap_or(end_s),
                f: a.f,
            })
            .filter(|s| s.on <= t_end && s.off >= t_start)
            .collect();
        let wanted = (1.15 * job.band_hz.1).max(1.05 * job.course.highest_hz);
        let f_top = if positive(wanted) { wanted } else { fs };
        Self {
            job,
            fs,
            end_s,
            t_start,
            t_end,
            f_top: f_top.min(0.5 * fs),
            drawn: drawn(&spans, t_end - t_start),
            spans,
        }
    }

    /// An empty picture over the time of the run, with a plot of `height`, entitled `title`.
    pub(super) fn panel(&self, height: f64, title: &str) -> Panel<'_> {
        let time = Time {
            start_s: self.t_start,
            end_s: self.t_end,
            spans: &self.drawn,
            mark_s: self.truth(),
        };
        Panel::new(time, height, title)
    }

    /// The true onset, if there is one on the time axis.
    pub(super) fn truth(&self) -> Option<f64> {
        let onset = self.job.truth_onset_s?;
        (self.t_start..=self.t_end)
            .contains(&onset)
            .then_some(onset)
    }

    /// Lines that are drawn are more than two to a pixel.
    pub(super) fn dense(&self) -> bool {
        self.job.course.lines() > DENSE
    }

    /// Damping ratio from which on an alarm may be released by it, 1.
    pub(super) fn release(&self) -> f64 {
        AlarmConfig::<f64>::default().release_ratio * self.job.threshold
    }

    /// Teeth of the cutter, where the speed in use is that of the spindle for certain: one
    /// that was found in the sound alone, or against what was told, may be the teeth's.
    pub(super) fn teeth_of_the_speed(&self) -> Option<u32> {
        let contradicted = |n: &NoticeRecord| matches!(n.what, NoticeKind::Contradiction { .. });
        let told = self.job.rpm.is_some() && !self.job.summary.notices.iter().any(contradicted);
        let known = told || self.job.course.by_tacho;
        self.job.teeth.filter(|z| *z > 1 && known)
    }

    /// Frequency whose multiples are forced vibration, Hz, and its name: tooth
    /// passing if the teeth are known, else the spindle. By the last speed that was read
    /// off sound or tacho, else by the told one.
    pub(super) fn forcing(&self) -> Option<(f64, &'static str)> {
        let read = self.job.summary.spindle.rpm_last;
        let rpm = read.or(self.job.rpm);
        let turn = rpm.filter(|r| r.is_finite() && *r > 0.0)? / 60.0;
        Some(self.forcing_of(turn))
    }

    /// The same where the spindle turns at `turn` revolutions/s.
    pub(super) fn forcing_of(&self, turn: f64) -> (f64, &'static str) {
        match self.teeth_of_the_speed() {
            Some(teeth) => (turn * f64::from(teeth), "tooth passing"),
            None => (turn, "spindle"),
        }
    }

    /// Spindle speed, Hz, where a line told one or none; the told one else.
    pub(super) fn spindle(&self, rpm: Option<f64>) -> Option<f64> {
        let rpm = rpm.or(self.job.rpm)?;
        (rpm.is_finite() && rpm > 0.0).then_some(rpm / 60.0)
    }

    /// The alarms for a text alternative.
    pub(super) fn spans_in_words(&self) -> String {
        match self.spans.as_slice() {
            [] => "No alarm.".into(),
            spans => {
                let list: Vec<String> = spans
                    .iter()
                    .take(5)
                    .map(|s| format!("from {} to {}", seconds(s.on), seconds(s.off)))
                    .collect();
                let more = if spans.len() > 5 { " and more" } else { "" };
                format!("Alarm {}{more}.", list.join(", "))
            }
        }
    }

    /// Dashed lines at the edges of the analysed band.
    pub(super) fn band_edges(&self, panel: &mut Panel<'_>, y: &Axis, class: &str) {
        for edge in [self.job.band_hz.0, self.job.band_hz.1] {
            if edge > y.lo() && edge < y.hi() {
                if class == "over" {
                    panel.level(y.at(edge), "over-case");
                }
                panel.level(y.at(edge), class);
            }
        }
    }

    /// A mark at the right edge for every alarm frequency; where they stand.
    pub(super) fn alarm_marks(&self, panel: &mut Panel<'_>, y: &Axis) -> Vec<f64> {
        let mut taken: Vec<f64> = Vec::new();
        for span in self.spans.iter().filter(|s| y.holds(s.f)) {
            let at = y.at(span.f);
            if !free(&taken, at) {
                continue;
            }
            taken.push(at);
            panel.add(&format!(
                r#"<path class="pointer" d="M{RIGHT} {}l8 -4.5v9z"/>"#,
                px(at)
            ));
            panel.label(RIGHT + 11.0, at + 4.0, "strong", "start", &hertz(span.f));
        }
        taken
    }
}

/// Spans up to so many are drawn one by one.
const FEW: usize = 500;
/// Else those are joined that are this part of the time axis apart.
const TOUCHING: f64 = 1e-3;

fn drawn(spans: &[Span], length: f64) -> Vec<(f64, f64)> {
    let mut drawn: Vec<(f64, f64)> = Vec::new();
    for span in spans {
        match drawn.last_mut() {
            Some(last) if spans.len() > FEW && span.on - last.1 < TOUCHING * length => {
                last.1 = last.1.max(span.off);
            }
            _ => drawn.push((span.on, span.off)),
        }
    }
    drawn
}
