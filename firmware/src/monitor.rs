//! The monitor duty: samples in, telemetry out. Fast path; once a sample.

use crate::notices::Notices;
use crate::visit::{flag, long};
use rarma_box::wire::{AlarmMessage, Finished, HistogramMessage, MonitorJob, Telemetry, Verdict};
use rarma_core::condition::{Fault, HealthCounts};
use rarma_core::decide::{AlarmEvent, Histogram};
use rarma_core::estimate::StateVisitor;
use rarma_core::monitor::{Monitor, MonitorError, Report};

/// The distribution of the followed mode's amplitude is told this often, s.
const HISTOGRAM_S: f64 = 1.0;

/// Samples that may be missing between two decisions in a state that is put in: two weeks at 48 kHz.
/// Lines are said one by one up to the present sample.
const MOST_MISSING: u64 = 1 << 36;

/// Listens, and says at the rate asked for what it hears; alarms at once.
///
/// A duty is 51 KB: a board with little memory keeps one in a static, idle at first, and
/// has it [`begin`](Self::begin) there.
#[derive(Debug, Clone)]
pub struct MonitorDuty {
    /// Always there, so that a job begins where the monitor lies.
    monitor: Monitor<f32>,
    /// None while idle.
    telling: Option<Telling>,
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
            monitor: Monitor::unstarted(),
            telling: None,
        }
    }

    /// Begins a job, whatever it did before.
    ///
    /// # Errors
    /// The setting that is out of range; the duty is then as it was.
    pub fn begin(&mut self, job: &MonitorJob) -> Result<(), MonitorError> {
        self.monitor.restart(&job.monitor)?;
        self.telling = Some(Telling::new(job));
        Ok(())
    }

    /// Whether it takes no notice of samples.
    pub fn is_idle(&self) -> bool {
        self.telling.is_none()
    }

    /// Takes no notice of samples from now on.
    pub fn end(&mut self) {
        self.telling = None;
    }

    /// First message of the run; of no rate and no order while idle.
    pub fn started(&self) -> Telemetry {
        let none = Telemetry::Started {
            fs_hz: 0.0,
            p: 0,
            q: 0,
        };
        self.telling.as_ref().map_or(none, Telling::started)
    }

    /// Takes samples in a row; hands what there is to say to `say`.
    #[inline]
    pub fn samples(&mut self, samples: &[f32], say: &mut impl FnMut(&Telemetry)) {
        let Some(telling) = &mut self.telling else {
            return;
        };
        let mut samples = samples.iter();
        while let Some(report) = fast_path::push(&mut self.monitor, &mut samples) {
            let monitor = &self.monitor;
            telling.report(&report, || monitor.histogram(), say);
        }
    }

    /// A tacho pulse has just come, `fraction` of a sample before the newest sample.
    pub fn pulse(&mut self, fraction: f32) {
        if !self.is_idle() {
            self.monitor.pulse(fraction);
        }
    }

    /// The control tells the speed of the spindle, Hz; see [`Monitor::tell_speed`].
    ///
    /// # Errors
    /// As there; nothing has changed then. While idle nothing is refused, and nothing changes.
    pub fn tell_speed(&mut self, spindle_hz: f32) -> Result<(), MonitorError> {
        if self.is_idle() {
            return Ok(());
        }
        self.monitor.tell_speed(spindle_hz)
    }

    /// The source lost samples.
    pub fn missing(&mut self, samples: u32) {
        if !self.is_idle() {
            self.monitor.missing(samples);
        }
    }

    /// What is wrong with the samples that it takes.
    pub fn fault(&self) -> Option<Fault> {
        self.monitor.fault()
    }

    /// Shows every number of the state to `visitor`; see [`Monitor::visit_state`]. Of no use while idle.
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<f32>) -> bool {
        let Some(telling) = &mut self.telling else {
            return false;
        };
        let sound = telling.visit_state(visitor) && self.monitor.visit_state(visitor);
        let since = self.monitor.samples().checked_sub(telling.counted_to);
        sound && since.is_some_and(|since| since < MOST_MISSING)
    }

    /// Last message of the run.
    pub fn finished(
        &self,
        longest_block_us: u32,
        late_blocks: u32,
        dropped_frames: u32,
    ) -> Telemetry {
        let monitor = &self.monitor;
        let told = self.telling.as_ref();
        let totals = told.map(|telling| telling.finished(monitor.samples(), monitor.health()));
        Telemetry::Finished(Finished {
            longest_block_us,
            late_blocks,
            dropped_frames,
            ..totals.unwrap_or_default()
        })
    }
}

/// Turns the reports of a monitor, whatever it listens to, into telemetry.
#[derive(Debug, Clone)]
pub struct Telling {
    job: MonitorJob,
    /// Sample of the next line, and what is over in 2^-32 of a sample.
    next_line: u64,
    next_part: u32,
    /// Samples between two lines, likewise: whole numbers, so that rounding never adds up,
    /// and no double precision where samples are taken.
    every: u64,
    every_part: u32,
    state_samples: [u64; 6],
    counted_to: u64,
    standing: Option<(f32, f32)>,
    notices: Notices,
    /// Sample of the next histogram, and samples between two.
    next_histogram: u64,
    histogram_samples: u64,
    locked_samples: u64,
    /// Sums over decisions of the power removed and of the band's.
    removed: LongSum,
    heard: LongSum,
}

impl Telling {
    /// Nothing has been said yet.
    pub fn new(job: &MonitorJob) -> Self {
        let every = (job.every_s * job.monitor.fs_hz).max(1.0) * PARTS;
        let (every, every_part) = ((every / PARTS) as u64, (every % PARTS) as u32);
        let histogram_samples = ((HISTOGRAM_S * job.monitor.fs_hz) as u64).max(1);
        Self {
            job: *job,
            next_line: every,
            next_part: every_part,
            every,
            every_part,
            state_samples: [0; 6],
            counted_to: 0,
            standing: None,
            notices: Notices::new(job.monitor.fs_hz),
            next_histogram: histogram_samples,
            histogram_samples,
            locked_samples: 0,
            removed: LongSum::default(),
            heard: LongSum::default(),
        }
    }

    fn visit_state(&mut self, visitor: &mut impl StateVisitor<f32>) -> bool {
        // All of them by name, so that none is forgotten.
        let Self {
            job: _,
            next_line,
            next_part,
            every: _,
            every_part: _,
            state_samples,
            counted_to,
            standing,
            notices,
            next_histogram,
            histogram_samples: _,
            locked_samples,
            removed,
            heard,
        } = self;
        visitor.part("Telling next_line next_part state_samples counted_to standing notices next_histogram locked_samples removed heard");
        for n in state_samples {
            long(n, visitor);
        }
        for n in [&mut *next_line, counted_to, next_histogram, locked_samples] {
            long(n, visitor);
        }
        visitor.count(next_part);
        let mut stands = standing.is_some();
        let (mut frequency, mut damping) = standing.unwrap_or_default();
        flag(&mut stands, visitor);
        for x in [&mut frequency, &mut damping] {
            visitor.number(x);
        }
        *standing = stands.then_some((frequency, damping));
        notices.visit_state(visitor);
        for sum in [removed, heard] {
            visitor.number(&mut sum.sum);
            visitor.number(&mut sum.excess);
        }
        *next_line > *counted_to
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
            removed_fraction: if self.heard.value() > 0.0 {
                (self.removed.value() / self.heard.value()) as f32
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
        self.removed.add(report.spindle.removed_power);
        self.heard.add(report.level * report.level);
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
            let over = report.sample.checked_rem(self.histogram_samples);
            let over = over.unwrap_or(0);
            self.next_histogram = report.sample - over + self.histogram_samples;
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
            while self.next_line <= report.sample {
                self.line_said();
            }
        }
    }

    /// The next line is one interval later.
    fn line_said(&mut self) {
        let (part, carry) = self.next_part.overflowing_add(self.every_part);
        self.next_part = part;
        self.next_line += self.every + u64::from(carry);
    }
}

/// Parts of a sample, see [`Telling`].
const PARTS: f64 = 4_294_967_296.0;

/// A sum of more numbers than one of single precision can count: what an addition loses
/// goes into the next (Kahan's compensation).
#[derive(Debug, Clone, Copy, Default)]
struct LongSum {
    sum: f32,
    excess: f32,
}

impl LongSum {
    fn add(&mut self, x: f32) {
        let x = x - self.excess;
        let sum = self.sum + x;
        self.excess = (sum - self.sum) - x;
        self.sum = sum;
    }

    fn value(&self) -> f64 {
        f64::from(self.sum) - f64::from(self.excess)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rarma_core::monitor::MonitorConfig;

    #[test]
    fn a_long_sum_keeps_what_single_precision_loses() {
        let (mut sum, mut plain, mut exact) = (LongSum::default(), 0.0f32, 0.0f64);
        for k in 0..40_000_000u32 {
            let x = 0.1 + (k & 7) as f32 * 0.01;
            sum.add(x);
            plain += x;
            exact += f64::from(x);
        }
        let error = sum.value() / exact - 1.0;
        assert!(error.abs() < 1e-7, "{error}");
        let plain = f64::from(plain) / exact - 1.0;
        assert!(plain.abs() > 1e-3, "{plain}");
    }

    #[test]
    fn lines_stand_at_multiples_of_their_interval() {
        for (fs_hz, every_s) in [(48_000.0, 0.01), (44_100.0, 0.1), (6_000.0, 1.0 / 7.0)] {
            let mut telling = Telling::new(&MonitorJob {
                monitor: MonitorConfig::new(fs_hz),
                channel: 0,
                every_s,
            });
            for line in 1..100_000u64 {
                let exact = line as f64 * every_s * fs_hz;
                let off = telling.next_line as f64 - exact;
                assert!(
                    (-1.0..=1e-3).contains(&off),
                    "{fs_hz} {every_s} {line}: {off}"
                );
                telling.line_said();
            }
        }
    }
}
