//! Two sensors at one machine: each has a monitor of its own, and one verdict comes
//! of their reports.
//!
//! Fast path: a fixed amount of work per sample, that of two [`Monitor`](crate::monitor::Monitor)s;
//! the reports are put together at the decision rate. The channels share one sample
//! clock.

mod alarm;
mod config;
mod fuse;

pub use config::{ALONE_CONFIRMATIONS, PairConfig, PairError};

use super::{MAX_MODES, Monitor, MonitorError, Report, SpindleReport};
use crate::condition::{Fault, HealthCounts};
use crate::decide::{
    Agreement, AlarmConfig, AlarmEvent, ChannelFault, ChannelWatch, Dropped, Histogram, Label,
    Mode, SILENT_RATIO, jointly_suspicious, partner,
};
use crate::real::Real;
use alarm::{PairAlarm, is_near};

/// The second channel's reports stand in for the first's after this many without.
const REPORTS_WITHOUT_FIRST: u32 = 2;

/// The verdict of a pair at one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairReport<T> {
    /// One state, one alarm. Modes, amplitudes and level are those of the first
    /// channel that is listened to; the surer reading of ζ and f is taken where both
    /// hear a mode, and modes that only the other hears fill up the rest.
    pub report: Report<T>,
    /// Who hears the mode in question.
    pub agreement: Agreement,
    /// Channels that are left out, and why.
    pub dropped: [Option<Dropped>; 2],
}

/// One channel.
#[derive(Debug, Clone)]
struct Channel<T> {
    monitor: Monitor<T>,
    last: Option<Report<T>>,
}

/// Listens to two channels in step.
///
/// * Both are suspicious of the same mode: the call comes sooner
///   ([`Agreement`](crate::decide::Agreement)).
/// * Only one calls: the pair follows after [`PairConfig::alone_confirmations`], or at once where
///   the other is deaf ([`PairConfig::hears`], or a level below [`SILENT_RATIO`] of this
///   one's), dropped or still starting.
/// * The alarm ends when no channel holds it any more.
/// * A bad channel is left out and named ([`ChannelFault`](crate::decide::ChannelFault)); the other goes on alone.
///
/// ```
/// use rarma_core::Order;
/// use rarma_core::decide::Agreement;
/// use rarma_core::monitor::{MonitorConfig, PairConfig, PairMonitor};
/// let monitor = MonitorConfig { order: Order::O21, ..MonitorConfig::new(8000.0) };
/// let mut pair = PairMonitor::<f32>::new(&PairConfig::new(monitor)).unwrap();
/// let mut last = None;
/// for n in 0..16_000 {
///     let x = (n as f32 * 0.7).sin();
///     // The second sensor's cable breaks after a second.
///     let second = if n < 8000 { 0.1 * x } else { 0.0 };
///     last = pair.push([x, second]).or(last);
/// }
/// let last = last.unwrap();
/// let mode = last.report.modes.iter().flatten().next().unwrap();
/// assert!((mode.frequency - 891.3).abs() < 1.0);
/// assert_eq!(last.agreement, Agreement::Single);
/// assert_eq!(last.dropped[1].unwrap().channel, 1);
/// ```
#[derive(Debug, Clone)]
pub struct PairMonitor<T> {
    channels: [Channel<T>; 2],
    config: AlarmConfig<T>,
    watch: ChannelWatch<T>,
    alarm: PairAlarm<T>,
    reports_without_first: u32,
    /// Channel whose level and modes the last report had.
    lead: usize,
    samples: u64,
    decided_at: u64,
    sample_s: T,
}

impl<T: Real> PairMonitor<T> {
    /// A pair that has heard nothing.
    ///
    /// # Errors
    /// See [`PairConfig::check`].
    pub fn new(config: &PairConfig) -> Result<Self, PairError> {
        config.check()?;
        let channel = |i: usize, config: &PairConfig| {
            let monitor = Monitor::new(&config.channels[i])
                .map_err(|error| PairError::Channel(i as u8, error))?;
            Ok(Channel {
                monitor,
                last: None,
            })
        };
        let first = &config.channels[0];
        let alarm: AlarmConfig<T> = first.alarm();
        Ok(Self {
            channels: [channel(0, config)?, channel(1, config)?],
            alarm: PairAlarm::new(config, &alarm),
            config: alarm,
            watch: ChannelWatch::default(),
            reports_without_first: 0,
            lead: 0,
            samples: 0,
            decided_at: 0,
            sample_s: T::from_f64(1.0 / first.fs_hz),
        })
    }

    /// Takes one sample of each channel; gives a report at every decision.
    #[inline]
    pub fn push(&mut self, x: [T; 2]) -> Option<PairReport<T>> {
        self.push_some(x.map(Some))
    }

    /// Takes one sample of each channel, none for one that has been lost.
    #[inline]
    pub fn push_some(&mut self, x: [Option<T>; 2]) -> Option<PairReport<T>> {
        self.samples += 1;
        let mut said = [false; 2];
        for ((channel, x), said) in self.channels.iter_mut().zip(x).zip(&mut said) {
            let Some(x) = x else {
                channel.monitor.missing(1);
                continue;
            };
            if let Some(report) = channel.monitor.push(x) {
                channel.last = Some(report);
                *said = true;
            }
        }
        match said {
            [true, _] => self.reports_without_first = 0,
            [false, true] => {
                self.reports_without_first += 1;
                if self.reports_without_first < REPORTS_WITHOUT_FIRST {
                    return None;
                }
            }
            [false, false] => return None,
        }
        Some(self.decide())
    }

    /// A tacho pulse has just come, `fraction` of a sample before the newest sample; see
    /// [`Monitor::pulse`](super::Monitor::pulse).
    pub fn pulse(&mut self, fraction: T) {
        for channel in &mut self.channels {
            channel.monitor.pulse(fraction);
        }
    }

    /// The control tells the speed of the spindle, Hz; see
    /// [`Monitor::tell_speed`](super::Monitor::tell_speed).
    ///
    /// # Errors
    /// As there; nothing has changed then.
    pub fn tell_speed(&mut self, spindle_hz: T) -> Result<(), MonitorError> {
        for channel in &mut self.channels {
            channel.monitor.tell_speed(spindle_hz)?;
        }
        Ok(())
    }

    /// Histogram of the squared amplitude of the mode that the report's amplitude is
    /// about, for display.
    pub fn histogram(&self) -> Histogram<T> {
        let leading = self.channels.get(self.lead);
        leading.map_or(Histogram::default(), |c| c.monitor.histogram())
    }

    /// Counts of bad samples of channel `i` since the start.
    pub fn health(&self, i: usize) -> Option<HealthCounts> {
        self.channels.get(i).map(|c| c.monitor.health())
    }

    /// Samples taken of each channel, lost ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Puts the two reports together.
    fn decide(&mut self) -> PairReport<T> {
        let passed = (self.samples - self.decided_at).min(u64::from(u32::MAX)) as u32;
        let period_s = T::from_u32(passed) * self.sample_s;
        self.decided_at = self.samples;

        let heard = self
            .channels
            .each_ref()
            .map(|c| fuse::hearing(c.monitor.fault(), c.last.as_ref()));
        self.watch.update(heard, &self.config, period_s);
        let dropped = [self.watch.dropped(0), self.watch.dropped(1)];
        let listened = [0, 1].map(|i| dropped[i].is_none() && heard[i].judging);
        let cutting = listened[0] && heard[0].cutting && listened[1] && heard[1].cutting;
        let joint = match cutting {
            true => jointly_suspicious(heard[0].modes, heard[1].modes),
            false => None,
        };
        let levels = [heard[0].level, heard[1].level];
        // Clipped samples still tell of a vibration that has been called.
        let told = |d: &Option<Dropped>| match d {
            None => true,
            Some(d) => d.fault == ChannelFault::Samples(Fault::Clipped),
        };
        let own = [0, 1].map(|i| self.own_alarm(i).filter(|_| told(&dropped[i])));
        // A channel that all but hears nothing has nothing to confirm.
        let near_silent = |i: usize| levels[i] < levels[1 - i] * T::from_f64(SILENT_RATIO);
        let waited_for = [0, 1].map(|i| listened[i] && !near_silent(i));
        let event = self
            .alarm
            .update(&own, &waited_for, &dropped, joint, period_s);
        self.report(event, &dropped, &listened)
    }

    fn own_alarm(&self, i: usize) -> Option<(T, T)> {
        self.channels[i].last.as_ref().and_then(|r| r.standing)
    }

    fn report(
        &mut self,
        event: AlarmEvent<T>,
        dropped: &[Option<Dropped>; 2],
        listened: &[bool; 2],
    ) -> PairReport<T> {
        let lead = match (listened, dropped) {
            ([true, _], _) => 0,
            ([false, true], _) => 1,
            (_, [Some(_), None]) => 1,
            _ => 0,
        };
        self.lead = lead;
        let none = [None; MAX_MODES];
        let modes = |i: usize| match (&self.channels[i].last, listened[i]) {
            (Some(report), true) => report.modes,
            _ => none,
        };
        let fused = fuse::modes(&modes(lead), &modes(1 - lead));
        let last = [0, 1].map(|i| self.channels[i].last.filter(|_| listened[i]));
        let (state, reason) = fuse::state(self.alarm.standing().is_some(), &last, dropped);
        let level = self.channels[lead].last.map_or(T::ZERO, |r| r.level);
        let leading = self.channels[lead].last;
        let mut report = Report {
            sample: self.samples,
            state,
            reason,
            event,
            level,
            modes: fused,
            spindle: leading.map_or(SpindleReport::default(), |r| r.spindle),
            amplitude: leading.and_then(|r| r.amplitude),
            standing: None,
        }
        .in_order(None);
        report.standing = self.alarm.standing();
        if let Some((frequency, _)) = report.standing {
            let near = |m: &&mut Mode<T>| is_near(m.frequency, frequency);
            if let Some(mode) = report.modes.iter_mut().flatten().find(near) {
                mode.label = Label::SelfExcited;
            }
        }
        PairReport {
            report,
            agreement: self.agreement(listened, &report.modes),
            dropped: *dropped,
        }
    }

    /// Who hears the alarm's mode, or the loudest of `fused`.
    fn agreement(&self, listened: &[bool; 2], fused: &[Option<Mode<T>>; MAX_MODES]) -> Agreement {
        if *listened != [true; 2] {
            return Agreement::Single;
        }
        let mut loudest: Option<&Mode<T>> = None;
        for mode in fused.iter().flatten() {
            if loudest.is_none_or(|l| mode.share > l.share) {
                loudest = Some(mode);
            }
        }
        let hears = [0, 1].map(|i| {
            let Some(report) = &self.channels[i].last else {
                return false;
            };
            match (self.alarm.standing(), loudest) {
                (Some((frequency, _)), _) => report
                    .modes
                    .iter()
                    .flatten()
                    .any(|m| is_near(m.frequency, frequency)),
                (None, Some(mode)) => partner(mode, &report.modes).is_some(),
                (None, None) => true,
            }
        });
        match hears {
            [true, false] => Agreement::OnlyFirst,
            [false, true] => Agreement::OnlySecond,
            _ => Agreement::Both,
        }
    }
}

#[cfg(test)]
#[path = "pair_tests.rs"]
mod tests;
