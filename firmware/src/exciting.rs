//! The exciting duty: a signal on top of the bias, and what a stepped sine finds out.
//!
//! Rate: once a millisecond. The signal itself runs in the current loop.

use crate::board::CoilReport;
use rarma_box::wire::{EndMessage, ExcitationMessage, LineMessage};
use rarma_rigs::cers::{ExcitationJob, LineCollector, OutOfReach, Reach, SensorPath, Source};

/// A signal, from the command to its end.
#[derive(Debug, Default)]
pub struct Exciting {
    /// Checked, and not started yet.
    next: Option<(ExcitationJob, Source)>,
    /// Handed to the current loop and not reported over.
    running: Option<Running>,
    quiet: bool,
    lines: LineCollector,
    started: Option<ExcitationJob>,
    line: Option<LineMessage>,
    ended: Option<EndMessage>,
}

#[derive(Debug, Clone, Copy)]
struct Running {
    /// Counts of the loop when the signal was handed over.
    periods: u32,
    limited: u32,
    /// Counts of the last report in which it ran.
    now: (u32, u32),
    lines: u16,
    early: bool,
    /// The loop has said that it runs.
    seen: bool,
}

impl Exciting {
    /// A job that is to start at the working point; the one before it is forgotten if it has
    /// not started.
    ///
    /// # Errors
    /// Why it does not go.
    pub fn want(&mut self, job: &ExcitationJob, reach: &Reach) -> Result<(), OutOfReach> {
        let source = job.check(reach)?;
        self.next = Some((*job, source));
        Ok(())
    }

    /// The job that waits, if one does, still goes with these settings and this supply.
    ///
    /// # Errors
    /// Why not; it is forgotten then.
    pub fn still_goes(&mut self, reach: &Reach) -> Result<(), OutOfReach> {
        if let Some((job, _)) = self.next.take() {
            self.want(&job, reach)?;
        }
        Ok(())
    }

    /// Ends the signal that runs, and forgets the one that waits.
    pub fn quiet(&mut self) {
        self.next = None;
        self.quiet = self.running.is_some();
    }

    /// Nothing waits any more: the outputs are off.
    pub fn forget(&mut self) {
        self.next = None;
    }

    /// A signal runs.
    pub fn runs(&self) -> bool {
        self.running.is_some()
    }

    /// Whether the loop is told to end the signal that runs.
    pub(crate) fn order(&mut self, going_down: bool) -> bool {
        if going_down {
            self.quiet();
        }
        if let Some(running) = &mut self.running {
            running.early |= self.quiet;
        }
        self.quiet
    }

    /// At the working point: the signal that waits, if none runs.
    pub(crate) fn start(&mut self) -> Option<Source> {
        if self.running.is_some() {
            return None;
        }
        let (job, source) = self.next.take()?;
        self.quiet = false;
        self.lines = LineCollector::default();
        self.running = Some(Running {
            periods: 0,
            limited: 0,
            now: (0, 0),
            lines: 0,
            early: false,
            seen: false,
        });
        self.started = Some(job);
        Some(source)
    }

    /// What the loop says.
    pub(crate) fn report(&mut self, report: &CoilReport, path: &SensorPath) {
        let Some(running) = &mut self.running else {
            return;
        };
        let counts = (report.periods, report.limited);
        if !running.seen {
            // The first report after the order: the signal has not had a period yet.
            (running.periods, running.limited) = counts;
            running.seen = true;
            running.now = counts;
            return;
        }
        running.now = counts;
        if let Some(block) = &report.block
            && let Some(line) = self.lines.add(block, path)
        {
            running.lines = running.lines.saturating_add(1);
            self.line = Some(LineMessage::from(&line));
        }
        if !report.exciting {
            self.ended = Some(EndMessage {
                early: running.early || !report.regulating,
                periods: running.now.0.wrapping_sub(running.periods),
                limited: running.now.1.wrapping_sub(running.limited),
                lines: running.lines,
            });
            self.running = None;
            self.quiet = false;
        }
    }

    /// Something to tell, one message a millisecond.
    pub(crate) fn news(&mut self) -> Option<ExcitationMessage> {
        if let Some(job) = self.started.take() {
            return Some(ExcitationMessage::Started(job));
        }
        if let Some(line) = self.line.take() {
            return Some(ExcitationMessage::Line(line));
        }
        self.ended.take().map(ExcitationMessage::Ended)
    }
}
