//! The monitor duty: samples in, telemetry out. Fast path; once a sample.

use crate::notices::Notices;
use rarma_core::AnyMonitor;
use rarma_core::condition::HealthCounts;
use rarma_core::decide::{AlarmEvent, Histogram};
use rarma_core::monitor::{MonitorConfig, MonitorError, Report};
use rarma_core::wire::{AlarmMessage, Finished, HistogramMessage, MonitorJob, Telemetry, Verdict};

/// The distribution of the followed mode's amplitude is told this often, s.
const HISTOGRAM_S: f64 = 1.0;

/// Listens, and says at the rate asked for what it hears; alarms at once.
///
/// A duty is 21 KB: a board with little memory keeps one in a static, idle at first, and
/// has it [`begin`](Self::begin) there.
#[derive(Debug, Clone)]
pub struct MonitorDuty {
    /// None while idle.
    monitor: Option<AnyMonitor<f32>>,
    telling: Telling,
}

impl MonitorDuty {
    /// A duty that has heard nothing.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn new(job: &MonitorJob) -> Result<Self, MonitorError> {
        let mut duty = Self::idle();
        duty.begin(job)?;
        Ok(duty)
    }

    /// A duty that takes no notice of samples.
    pub fn idle() -> Self {
        Self {
            monitor: None,
            telling: Telling::new(&MonitorJob {
                monitor: MonitorConfig::new(1.0),
                channel: 0,
                every_s: 1.0,
            }),
        }
    }

    /// Begins a job, whatever it did before.
    ///
    /// # Errors
    /// The setting that is out of range; the duty is then as it was.
    pub fn begin(&mut self, job: &MonitorJob) -> Result<(), MonitorError> {
        AnyMonitor::place(&mut self.monitor, &job.monitor)?;
        self.telling = Telling::new(job);
        Ok(())
    }

    /// First message of the run.
    pub fn started(&self) -> Telemetry {
        self.telling.started()
    }

    /// Takes one sample; hands what there is to say to `say`.
    #[inline]
    pub fn sample(&mut self, x: f32, say: &mut impl FnMut(&Telemetry)) {
        if let Some(monitor) = &mut self.monitor
            && let Some(report) = monitor.push(x)
        {
            self.telling.report(&report, || monitor.histogram(), say);
        }
    }

    /// A tacho pulse has just come, `fraction` of a sample before the newest sample.
    pub fn pulse(&mut self, fraction: f32) {
        if let Some(monitor) = &mut self.monitor {
            monitor.pulse(fraction);
        }
    }

    /// The source lost samples.
    pub fn missing(&mut self, samples: u32) {
        if let Some(monitor) = &mut self.monitor {
            monitor.missing(samples);
        }
    }

    /// Last message of the run.
    pub fn finished(
        &self,
        longest_block_us: u32,
        late_blocks: u32,
        dropped_frames: u32,
    ) -> Telemetry {
        let heard = self.monitor.as_ref();
        let (samples, health) = heard.map_or_else(Default::default, |monitor| {
            (monitor.samples(), monitor.health())
        });
        Telemetry::Finished(Finished {
            longest_block_us,
            late_blocks,
            dropped_frames,
            ..self.telling.finished(samples, health)
        })
    }
}

/// Turns the reports of a monitor, whatever it listens to, into telemetry.
#[derive(Debug, Clone)]
pub struct Telling {
    job: MonitorJob,
    /// Sample of the next line, and how many lines there have been.
    next_line: u64,
    lines: u32,
    every_samples: f64,
    state_samples: [u64; 6],
    counted_to: u64,
    standing: Option<(f32, f32)>,
    notices: Notices,
    /// Sample of the next histogram, and samples between two.
    next_histogram: u64,
    histogram_samples: u64,
    locked_samples: u64,
    /// Sums over decisions of the power removed and of the band's: double, since a
    /// shift has more decisions than a single-precision sum can count.
    removed: f64,
    heard: f64,
}

impl Telling {
    /// Nothing has been said yet.
    pub fn new(job: &MonitorJob) -> Self {
        let every_samples = job.every_s * job.monitor.fs_hz;
        let histogram_samples = ((HISTOGRAM_S * job.monitor.fs_hz) as u64).max(1);
        Self {
            job: *job,
            next_line: every_samples as u64,
            lines: 1,
            every_samples: if every_samples >= 1.0 {
                every_samples
            } else {
                1.0
            },
            state_samples: [0; 6],
            counted_to: 0,
            standing: None,
            notices: Notices::new(job.monitor.fs_hz),
            next_histogram: histogram_samples,
            histogram_samples,
            locked_samples: 0,
            removed: 0.0,
            heard: 0.0,
        }
    }

    /// First message of the run.
    pub fn started(&self) -> Telemetry {
        let monitor = &self.job.monitor;
        Telemetry::Started {
            fs_hz: monitor.fs_hz,
            p: monitor.order.p() as u8,
            q: monitor.order.q() as u8,
        }
    }

    /// Totals of the run; the clock and the link are the caller's to add.
    pub fn finished(&self, samples: u64, health: HealthCounts) -> Finished {
        Finished {
            samples,
            state_samples: self.state_samples,
            health,
            locked_samples: self.locked_samples,
            removed_fraction: if self.heard > 0.0 {
                (self.removed / self.heard) as f32
            } else {
                0.0
            },
            standing: self.standing,
            longest_block_us: 0,
            late_blocks: 0,
            dropped_frames: 0,
        }
    }

    /// Decision rate: hands what a report has to say to `say`. `histogram` is that of the
    /// mode that the report's amplitude is about.
    pub fn report(
        &mut self,
        report: &Report<f32>,
        histogram: impl FnOnce() -> Histogram<f32>,
        say: &mut impl FnMut(&Telemetry),
    ) {
        let passed = report.sample.saturating_sub(self.counted_to);
        if let Some(count) = self.state_samples.get_mut(report.state as usize) {
            *count += passed;
        }
        if report.spindle.locked {
            self.locked_samples += passed;
        }
        self.removed += f64::from(report.spindle.removed_power);
        self.heard += f64::from(report.level * report.level);
        self.counted_to = report.sample;
        self.standing = report.standing;
        let alarm = |on, frequency, damping| {
            Telemetry::Alarm(AlarmMessage {
                sample: report.sample,
                on,
                frequency,
                damping,
            })
        };
        match report.event {
            AlarmEvent::None => {}
            AlarmEvent::On { frequency, damping } => say(&alarm(true, frequency, damping)),
            AlarmEvent::Off {
                frequency,
                lowest_damping,
            } => say(&alarm(false, frequency, lowest_damping)),
        }
        self.notices.look(report, say);
        if report.sample >= self.next_histogram {
            self.next_histogram =
                report.sample - report.sample % self.histogram_samples + self.histogram_samples;
            if let Some(amplitude) = report.amplitude {
                let counts = histogram();
                // A mode that has just been taken up has none yet.
                if counts.total() > 0 {
                    let message =
                        HistogramMessage::new(report.sample, amplitude.frequency, &counts);
                    say(&Telemetry::Amplitude(message));
                }
            }
        }
        if report.sample >= self.next_line {
            say(&Telemetry::Verdict(Verdict::from_report(report)));
            // Slow path: multiples of the interval, so that its rounding never adds up.
            while self.next_line <= report.sample {
                self.lines += 1;
                self.next_line = (f64::from(self.lines) * self.every_samples) as u64;
            }
        }
    }
}
