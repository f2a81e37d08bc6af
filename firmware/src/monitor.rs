//! The monitor duty: samples in, telemetry out. Fast path; once a sample.

use rarma_core::AnyMonitor;
use rarma_core::condition::HealthCounts;
use rarma_core::decide::AlarmEvent;
use rarma_core::monitor::{MonitorError, Report};
use rarma_core::wire::{AlarmMessage, Finished, MonitorJob, Telemetry, Verdict};

/// Listens, and says at the rate asked for what it hears; alarms at once.
#[derive(Debug, Clone)]
pub struct MonitorDuty {
    monitor: AnyMonitor<f32>,
    telling: Telling,
}

impl MonitorDuty {
    /// A duty that has heard nothing.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn new(job: &MonitorJob) -> Result<Self, MonitorError> {
        Ok(Self {
            monitor: AnyMonitor::new(&job.monitor)?,
            telling: Telling::new(job),
        })
    }

    /// First message of the run.
    pub fn started(&self) -> Telemetry {
        self.telling.started()
    }

    /// Takes one sample; hands what there is to say to `say`.
    #[inline]
    pub fn sample(&mut self, x: f32, say: &mut impl FnMut(&Telemetry)) {
        if let Some(report) = self.monitor.push(x) {
            self.telling.report(&report, say);
        }
    }

    /// The source lost samples.
    pub fn missing(&mut self, samples: u32) {
        self.monitor.missing(samples);
    }

    /// Last message of the run.
    pub fn finished(
        &self,
        longest_block_us: u32,
        late_blocks: u32,
        dropped_frames: u32,
    ) -> Telemetry {
        Telemetry::Finished(Finished {
            longest_block_us,
            late_blocks,
            dropped_frames,
            ..self
                .telling
                .finished(self.monitor.samples(), self.monitor.health())
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
}

impl Telling {
    /// Nothing has been said yet.
    pub fn new(job: &MonitorJob) -> Self {
        let every_samples = job.every_s * job.monitor.fs_hz;
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
            standing: self.standing,
            longest_block_us: 0,
            late_blocks: 0,
            dropped_frames: 0,
        }
    }

    /// Decision rate: hands what a report has to say to `say`.
    pub fn report(&mut self, report: &Report<f32>, say: &mut impl FnMut(&Telemetry)) {
        if let Some(count) = self.state_samples.get_mut(report.state as usize) {
            *count += report.sample - self.counted_to;
        }
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
