//! `rarma monitor --second`: two channels of one recording, one verdict.

use crate::collect::{Collector, News};
use crate::failure::Failure;
use crate::record::{ChannelRecord, FaultRecord};
use firmware::monitor::Telling;
use rarma_box::wire::{MonitorJob, Telemetry};
use rarma_core::condition::HealthCounts;
use rarma_core::decide::ChannelFault;
use rarma_core::monitor::{MonitorError, PairConfig, PairMonitor, PairReport};
use rarma_core::named::Named;

/// Stretches without a channel that a summary lists, the first ones.
const MOST_FAULTS: usize = 1_000;

/// A pair of monitors over two channels in step, on the host.
#[derive(Clone)]
pub(super) struct Pair {
    monitor: PairMonitor<f32>,
    telling: Telling,
    channels: [Log; 2],
    fs: f64,
}

impl Pair {
    /// For two channels of a recording, counted from 0.
    ///
    /// # Errors
    /// Settings out of range.
    pub(super) fn new(job: &MonitorJob, channels: [usize; 2]) -> Result<Self, Failure> {
        let refused = |error| Failure::Usage(format!("setting out of range: {error:?}"));
        Ok(Self {
            monitor: PairMonitor::new(&PairConfig::new(job.monitor)).map_err(refused)?,
            telling: Telling::new(job),
            channels: channels.map(Log::new),
            fs: job.monitor.fs_hz,
        })
    }

    pub(super) fn started(&self) -> Telemetry {
        self.telling.started()
    }

    /// Takes one sample of each, none for one that is missing.
    pub(super) fn sample(
        &mut self,
        x: [Option<f32>; 2],
        collector: &mut Collector,
        hear: &mut impl FnMut(News),
    ) {
        let Some(report) = self.monitor.push_some(x) else {
            return;
        };
        let histogram = || self.monitor.histogram();
        self.telling
            .report(&report.report, histogram, &mut |message| {
                let mut news = collector.take(message);
                if let News::Line(line) = &mut news {
                    line.agreement = Some(report.agreement);
                }
                hear(news);
            });
        for (i, log) in self.channels.iter_mut().enumerate() {
            log.take(i, &report, self.fs);
        }
    }

    /// A tacho pulse has just come, `before` samples ago.
    pub(super) fn pulse(&mut self, before: f32) {
        self.monitor.pulse(before);
    }

    /// The control tells the speed of the spindle, Hz.
    ///
    /// # Errors
    /// Out of range.
    pub(super) fn tell_speed(&mut self, spindle_hz: f32) -> Result<(), MonitorError> {
        self.monitor.tell_speed(spindle_hz)
    }

    pub(super) fn finished(&self) -> Telemetry {
        let health = [0, 1].map(|i| self.monitor.health(i).unwrap_or_default());
        let samples = self.monitor.samples();
        Telemetry::Finished(self.telling.finished(samples, total(health)))
    }

    /// What befell each channel.
    pub(super) fn records(self) -> Vec<ChannelRecord> {
        let end_s = self.monitor.samples() as f64 / self.fs;
        self.channels.map(|log| log.record(end_s)).into()
    }
}

/// What befell each channel, in words.
pub fn words(channels: &[ChannelRecord]) {
    for channel in channels {
        let stretch = |f: &FaultRecord| match f.off {
            Some(off) => format!("{} from {:.3} to {off:.3} s", f.fault, f.on),
            None => format!("{} from {:.3} s to the end", f.fault, f.on),
        };
        if !channel.faults.is_empty() {
            let mut why: Vec<String> = channel.faults.iter().map(stretch).collect();
            if channel.faults_left_out > 0 {
                why.push(format!("and {} times more", channel.faults_left_out));
            }
            say!(
                "Channel {} was left out for {:.2} s: {}.",
                channel.channel,
                channel.dropped_s,
                why.join(", ")
            );
        }
    }
}

fn total([a, b]: [HealthCounts; 2]) -> HealthCounts {
    HealthCounts {
        not_finite: a.not_finite.saturating_add(b.not_finite),
        clipped: a.clipped.saturating_add(b.clipped),
        stuck: a.stuck.saturating_add(b.stuck),
        missing: a.missing.saturating_add(b.missing),
    }
}

/// The stretches for which one channel was left out.
#[derive(Clone)]
struct Log {
    channel: usize,
    faults: Vec<FaultRecord>,
    left_out: u64,
    dropped_s: f64,
    /// What is wrong now, and since when, s.
    now: Option<ChannelFault>,
    since: Option<f64>,
}

impl Log {
    fn new(channel: usize) -> Self {
        Self {
            channel,
            faults: Vec::new(),
            left_out: 0,
            dropped_s: 0.0,
            now: None,
            since: None,
        }
    }

    fn take(&mut self, i: usize, report: &PairReport<f32>, fs: f64) {
        let fault = report.dropped[i].map(|d| d.fault);
        if fault == self.now {
            return;
        }
        let t = report.report.sample as f64 / fs;
        self.end(Some(t), t);
        self.since = fault.map(|_| t);
        self.now = fault;
    }

    /// Ends the stretch that goes on, at `off` or with the recording.
    fn end(&mut self, off: Option<f64>, at: f64) {
        let (Some(fault), Some(on)) = (self.now.take(), self.since.take()) else {
            return;
        };
        self.dropped_s += at - on;
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(FaultRecord {
                fault: fault.name().to_owned(),
                on,
                off,
            });
        } else {
            self.left_out += 1;
        }
    }

    fn record(mut self, end_s: f64) -> ChannelRecord {
        self.end(None, end_s);
        ChannelRecord {
            channel: self.channel,
            dropped_s: self.dropped_s,
            faults: self.faults,
            faults_left_out: self.left_out,
        }
    }
}
