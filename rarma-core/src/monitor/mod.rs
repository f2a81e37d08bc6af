//! One sample in, a verdict out: condition, estimate, spectrum and decide composed.
//!
//! Fast path: [`Monitor::push`] does a fixed amount of work per sample. Every
//! decimated sample gets a new model and new roots; every
//! [`DECISION_PERIOD_S`] the modes are read, with their uncertainty, and judged.

mod amplitude;
mod blind;
mod config;
mod drift;
mod feedback;
mod identifier;
mod pair;
mod report;
mod slot;
mod spindle;
mod start;
mod verdict;

pub use amplitude::AmplitudeReport;
pub use config::{DECISION_PERIOD_S, LEAST_MEMORY, MonitorConfig, MonitorError};
pub use identifier::{Identifier, MAX_MODES};
pub use pair::{ALONE_CONFIRMATIONS, PairConfig, PairError, PairMonitor, PairReport};
pub use report::Report;
pub use spindle::{SpeedSource, SpindleReport};

use crate::condition::{BandFilter, Fault, Health, HealthCounts};
use crate::decide::{Alarm, Histogram, IdleFinder, Onset, Places};
use crate::real::Real;
use crate::verdict::Verdict;
use crate::visit::{State, StateVisitor, state};
use amplitude::AmplitudeWatch;
use blind::Blindness;
use core::slice::Iter;
use slot::{Gains, Slot};
use spindle::Spindle;

/// Listens to one channel with an ARMA model of the order in its settings.
///
/// ```
/// use rarma_core::Order;
/// use rarma_core::monitor::{Monitor, MonitorConfig};
/// let config = MonitorConfig { order: Order::O21, ..MonitorConfig::new(8000.0) };
/// let mut monitor = Monitor::<f32>::new(&config).unwrap();
/// let mut last = None;
/// for n in 0..16_000 {
///     last = monitor.push((n as f32 * 0.7).sin()).or(last);
/// }
/// // An undamped tone of unknown origin at 8000·0.7/2π = 891 Hz.
/// let report = last.unwrap();
/// let mode = report.modes.iter().flatten().next().unwrap();
/// assert!((mode.frequency - 891.3).abs() < 1.0 && mode.damping < 0.01);
/// ```
#[derive(Debug, Clone)]
pub struct Monitor<T> {
    health: Health<T>,
    filter: BandFilter<T>,
    identifier: Identifier<T>,
    slots: [Slot<T>; MAX_MODES],
    idle: IdleFinder<T>,
    places: Places<T>,
    onset: Onset<T>,
    was_locked: bool,
    blindness: Blindness<T>,
    amplitude: AmplitudeWatch<T>,
    alarm: Alarm<T>,
    spindle: Spindle<T>,
    sources: Verdict<T>,
    /// The rate is high enough for lines.
    hears_lines: bool,
    /// Nobody tells the speed, and the lines go by the one that is heard.
    heard_speed: bool,
    band: (T, T),
    idle_samples: Option<(u64, u64)>,
    fs: T,
    gains: Gains<T>,
    /// Mean square of the band, and of what is left of it without the spindle's lines.
    power: T,
    rest_power: T,
    /// Power of the loudest mode.
    loudest: T,
    power_gain: T,
    samples: u64,
    /// Time heard, up to a second, s.
    heard_s: T,
    /// 0 in one that has not been started.
    until_decision: u32,
    decision_every: u32,
    period_s: T,
    lost_s: T,
    fault_s: T,
}

state! { Monitor<T> {
    health, filter, identifier, slots, idle, places, onset, was_locked, blindness,
    amplitude, alarm, spindle, sources, heard_speed, power, rest_power, loudest, samples,
    heard_s, until_decision, lost_s, fault_s;
    settings hears_lines, band, idle_samples, fs, gains, power_gain, decision_every,
    period_s;
    where (*until_decision > 0) == (*decision_every > 0) && *until_decision <= *decision_every
} }

impl<T: Real> Monitor<T> {
    /// A monitor that has heard nothing.
    ///
    /// # Errors
    /// See [`MonitorConfig::check`].
    pub fn new(config: &MonitorConfig) -> Result<Self, MonitorError> {
        let mut monitor = Self::unstarted();
        monitor.restart(config)?;
        Ok(monitor)
    }

    /// Takes one input sample; gives a report at every decision. One that has not been
    /// started never does.
    #[inline]
    pub fn push(&mut self, x: T) -> Option<Report<T>> {
        self.samples += 1;
        let good = self.health.admit(x);
        let (wide, y) = self.filter.process_both(good)?;
        self.hear(wide, y)
    }

    /// [`Self::push`] of samples in a row, up to the first report: those between two decimated ones
    /// share some of the work.
    #[inline]
    pub fn push_row(&mut self, samples: &mut Iter<'_, T>) -> Option<Report<T>> {
        loop {
            let here = samples.as_slice();
            let count = self.filter.row().min(here.len());
            let (row, later) = here.split_at_checked(count)?;
            if row.is_empty() {
                return None;
            }
            *samples = later.iter();
            self.samples += count as u64;
            let heard = if self.health.admit_row(row) {
                self.filter.process_row(row)
            } else {
                self.filter_singly(row)
            };
            if let Some((wide, y)) = heard
                && let Some(report) = self.hear(wide, y)
            {
                return Some(report);
            }
        }
    }

    /// Samples in a row of which there is something to count, out of the way of the others.
    #[cold]
    #[inline(never)]
    fn filter_singly(&mut self, row: &[T]) -> Option<(T, T)> {
        let mut heard = None;
        for &x in row {
            let good = self.health.admit(x);
            heard = self.filter.process_both(good);
        }
        heard
    }

    /// Takes one decimated sample, before and after the high-pass. A function of its own, so that
    /// the samples between two of them do not save registers for it.
    #[inline(never)]
    fn hear(&mut self, wide: T, y: T) -> Option<Report<T>> {
        if self.trusts_samples() {
            if self.hears_lines {
                self.sources.process(wide);
            }
            self.listen(y);
        }
        self.until_decision = self.until_decision.checked_sub(1)?;
        if self.until_decision > 0 {
            return None;
        }
        self.until_decision = self.decision_every;
        Some(self.decide())
    }

    /// The source lost `samples` samples just now.
    pub fn missing(&mut self, samples: u32) {
        self.samples += u64::from(samples);
        self.health.missing(samples);
    }

    /// A tacho pulse has just come, `fraction` of a sample before the newest sample.
    pub fn pulse(&mut self, fraction: T) {
        self.spindle.pulse(self.samples, fraction);
    }

    /// The control tells the speed of the spindle, Hz: at once, and as often as it likes. The
    /// teeth are those of the settings, and count only if these tell a speed, too.
    ///
    /// # Errors
    /// [`MonitorError::Spindle`], as for a setting; nothing has changed then.
    pub fn tell_speed(&mut self, spindle_hz: T) -> Result<(), MonitorError> {
        if !MonitorConfig::is_speed(spindle_hz.to_f64()) {
            return Err(MonitorError::Spindle);
        }
        self.spindle.tell(spindle_hz);
        self.sources.tell_speed(spindle_hz);
        self.heard_speed = false;
        Ok(())
    }

    /// Histogram of the squared amplitude of the mode that is followed, for display.
    pub fn histogram(&self) -> Histogram<T> {
        self.amplitude.histogram()
    }

    /// Counts of bad samples since the start.
    pub fn health(&self) -> HealthCounts {
        self.health.counts()
    }

    /// Shows every number that the samples have changed to `visitor`, to be kept and gone on from
    /// later, as [`RecursiveArma::visit_state`](crate::estimate::RecursiveArma::visit_state) does.
    /// The monitor that takes a state in has been made with the same settings as the one that gave it.
    /// False where what `visitor` has put in is not the state of such a monitor; it is of no use then
    /// until it is restarted. Slow path.
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        State::visit_state(self, visitor)
    }

    /// What is wrong with the samples now.
    pub fn fault(&self) -> Option<Fault> {
        self.health.fault()
    }

    /// Input samples taken, missing ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The model of this moment, and its roots.
    pub fn model(&self) -> &Identifier<T> {
        &self.identifier
    }

    /// Clipped samples still tell of the vibration; the others tell of nothing and
    /// leave the estimator as it is.
    fn trusts_samples(&self) -> bool {
        matches!(self.health.fault(), None | Some(Fault::Clipped))
    }

    /// A new model, new roots, and the loudness at each mode.
    #[inline(always)]
    fn listen(&mut self, y: T) {
        self.power += self.power_gain * (y * y - self.power);
        let y = self.spindle.process(y);
        self.rest_power += self.power_gain * (y * y - self.rest_power);
        let mut own = [T::ZERO; MAX_MODES];
        let modes = self.identifier.update(y, &mut own);
        self.amplitude.listen(y);
        for (slot, own) in self.slots.iter_mut().zip(own).take(modes) {
            slot.listen(y, own, &self.gains);
        }
    }
}

#[cfg(test)]
mod state_tests;
