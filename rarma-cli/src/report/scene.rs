//! What all pictures share: ranges, alarm spans, harmonics, and marks for them.

use super::ReportInput;
use super::axis::Axis;
use super::panel::{Panel, RIGHT};
use super::text::{hertz, px, seconds};
use crate::record::{NoticeKind, NoticeRecord, SpeedSource};

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
    /// End of the time axis, positive, s.
    pub(super) t_end: f64,
    /// Top of both frequency axes, Hz: the analysed band and a little more, for
    /// above it there is nothing but noise.
    pub(super) f_top: f64,
    /// Alarms with finite times.
    pub(super) spans: Vec<Span>,
}

/// Distance of two labels above each other at which both can be read, pixels.
const APART: f64 = 13.0;

impl<'a> Scene<'a> {
    /// Finds the ranges.
    pub(super) fn new(job: &'a ReportInput<'a>) -> Self {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let fs = if positive(job.fs) { job.fs } else { 1.0 };
        let lines = job.run.lines.iter().map(|l| l.t);
        let alarms = job.run.summary.alarms.iter();
        let t_end = lines
            .chain(alarms.flat_map(|a| [a.on, a.off.unwrap_or(0.0)]))
            .filter(|t| t.is_finite())
            .fold(job.samples.len() as f64 / fs, f64::max);
        let t_end = if positive(t_end) { t_end } else { 1.0 };
        let spans = job
            .run
            .summary
            .alarms
            .iter()
            .filter(|a| a.on.is_finite())
            .map(|a| Span {
                on: a.on,
                off: a.off.filter(|t| t.is_finite()).unwrap_or(t_end),
                f: a.f,
            })
            .collect();
        let highest = job
            .run
            .lines
            .iter()
            .flat_map(|l| &l.modes)
            .map(|m| m.f)
            .filter(|f| f.is_finite())
            .fold(0.0, f64::max);
        let wanted = (1.15 * job.band_hz.1).max(1.05 * highest);
        let f_top = if positive(wanted) { wanted } else { fs };
        Self {
            job,
            fs,
            t_end,
            f_top: f_top.min(0.5 * fs),
            spans,
        }
    }

    /// The true onset, if there is one on the time axis.
    pub(super) fn truth(&self) -> Option<f64> {
        let onset = self.job.truth_onset_s?;
        (0.0..=self.t_end).contains(&onset).then_some(onset)
    }

    /// Teeth of the cutter, where the speed in use is that of the spindle for certain: one
    /// that was found in the sound alone, or against what was told, may be the teeth's.
    pub(super) fn teeth_of_the_speed(&self) -> Option<u32> {
        let run = self.job.run;
        let tacho = run
            .lines
            .iter()
            .any(|l| l.spindle.source == SpeedSource::Tacho);
        let contradicted = |n: &NoticeRecord| matches!(n.what, NoticeKind::Contradiction { .. });
        let told = self.job.rpm.is_some() && !run.summary.notices.iter().any(contradicted);
        self.job.teeth.filter(|z| *z > 1 && (told || tacho))
    }

    /// Frequency whose multiples are forced vibration, Hz, and its name: tooth
    /// passing if the teeth are known, else the spindle. By the last speed that was read
    /// off sound or tacho, else by the told one.
    pub(super) fn forcing(&self) -> Option<(f64, &'static str)> {
        let read = self.job.run.summary.spindle.rpm_last;
        let rpm = read.or(self.job.rpm);
        let turn = rpm.filter(|r| r.is_finite() && *r > 0.0)? / 60.0;
        Some(self.forcing_of(turn))
    }

    /// The same at an instant.
    pub(super) fn forcing_at(&self, t: f64) -> Option<(f64, &'static str)> {
        self.spindle_at(t).map(|turn| self.forcing_of(turn))
    }

    fn forcing_of(&self, turn: f64) -> (f64, &'static str) {
        match self.teeth_of_the_speed() {
            Some(teeth) => (turn * f64::from(teeth), "tooth passing"),
            None => (turn, "spindle"),
        }
    }

    /// Spindle speed at an instant, Hz: that of the nearest line, else the told one.
    pub(super) fn spindle_at(&self, t: f64) -> Option<f64> {
        let lines = self.job.run.lines.iter().filter(|l| l.t.is_finite());
        let known = lines.filter_map(|l| Some((l.t, l.spindle.rpm?)));
        let nearest = known.min_by(|a, b| (a.0 - t).abs().total_cmp(&(b.0 - t).abs()));
        let rpm = nearest.map(|(_, rpm)| rpm).or(self.job.rpm)?;
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

/// Whether a label at `at` overlaps none of those already there.
pub(super) fn free(taken: &[f64], at: f64) -> bool {
    taken.iter().all(|other| (other - at).abs() >= APART)
}
