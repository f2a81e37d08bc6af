//! One sample in, a verdict out: condition, estimate, spectrum and decide composed.
//!
//! Fast path: [`Monitor::push`] does a fixed amount of work per sample. Every
//! decimated sample gets a new model and new roots; every
//! [`DECISION_PERIOD_S`] the modes are read, with their uncertainty, and judged.

mod amplitude;
mod any;
mod blind;
mod config;
mod drift;
mod pair;
mod report;
mod slot;
mod spindle;
mod verdict;

pub use amplitude::AmplitudeReport;
pub use any::AnyMonitor;
pub use config::{DECISION_PERIOD_S, LEAST_MEMORY, MonitorConfig, MonitorError};
pub use pair::{ALONE_CONFIRMATIONS, PairConfig, PairError, PairMonitor, PairReport};
pub use report::{MAX_MODES, Report};
pub use spindle::{SpeedSource, SpindleReport};

use crate::condition::{Band, BandFilter, Fault, Health, HealthCounts};
use crate::decide::{Alarm, Background, Histogram, IdleFinder, Onset, Places};
use crate::estimate::{RecursiveArma, Status};
use crate::real::Real;
use crate::spectrum::{FactorTracker, Tracking, isolate};
use amplitude::AmplitudeWatch;
use blind::Blindness;
use slot::{Gains, Slot};
use spindle::Spindle;

/// Smoothing of the band's power, s.
const POWER_TAU_S: f64 = 0.03;
/// Listens to one channel with an ARMA(P, Q) model, N = P + Q.
///
/// ```
/// use rarma_core::monitor::{Monitor, MonitorConfig};
/// let mut monitor = Monitor::<f32, 2, 1, 3>::new(&MonitorConfig::new(8000.0)).unwrap();
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
pub struct Monitor<T, const P: usize, const Q: usize, const N: usize> {
    health: Health<T>,
    filter: BandFilter<T>,
    model: RecursiveArma<T, P, Q, N>,
    roots: FactorTracker<T, P>,
    slots: [Slot<T>; MAX_MODES],
    idle: IdleFinder<T>,
    background: Background<T>,
    places: Places<T>,
    onset: Onset<T>,
    was_locked: bool,
    blindness: Blindness<T>,
    amplitude: AmplitudeWatch<T>,
    alarm: Alarm<T>,
    spindle: Spindle<T>,
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
    until_decision: u32,
    decision_every: u32,
    period_s: T,
    lost: bool,
    lost_s: T,
    fault_s: T,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Monitor<T, P, Q, N> {
    /// A monitor that has heard nothing.
    ///
    /// # Errors
    /// See [`MonitorConfig::check`].
    pub fn new(config: &MonitorConfig) -> Result<Self, MonitorError> {
        const { assert!(P.div_ceil(2) <= MAX_MODES, "more modes than a report holds") };
        config.check()?;
        let band: Band = config.band();
        let filter = BandFilter::new(band, config.fs_hz).map_err(MonitorError::Band)?;
        let fs = config.fs_hz / filter.factor() as f64;
        let decision_every = ((DECISION_PERIOD_S * fs) as u32).max(1);
        let period_s = f64::from(decision_every) / fs;
        Ok(Self {
            health: Health::new(config.fs_hz, config.full_scale),
            filter,
            model: RecursiveArma::new(config.estimator(fs)),
            roots: FactorTracker::new(),
            slots: [Slot::default(); MAX_MODES],
            idle: IdleFinder::new(period_s),
            background: Background::default(),
            places: Places::default(),
            onset: Onset::default(),
            was_locked: false,
            blindness: Blindness::default(),
            amplitude: AmplitudeWatch::new(fs, period_s),
            alarm: Alarm::new(config.alarm()),
            spindle: Spindle::new(config, fs),
            band: (T::from_f64(band.low_hz), T::from_f64(band.high_hz)),
            idle_samples: config.idle_s.map(|(from, to)| {
                let sample = |t: f64| (t * config.fs_hz) as u64;
                (sample(from), sample(to))
            }),
            fs: T::from_f64(fs),
            gains: Gains::new(fs),
            power: T::ZERO,
            rest_power: T::ZERO,
            loudest: T::ZERO,
            power_gain: T::from_f64((1.0 / (POWER_TAU_S * fs)).min(1.0)),
            samples: 0,
            heard_s: T::ZERO,
            until_decision: decision_every,
            decision_every,
            period_s: T::from_f64(period_s),
            lost: true,
            lost_s: T::from_f64(verdict::LOST_HOLD_S),
            fault_s: T::ZERO,
        })
    }

    /// Takes one input sample; gives a report at every decision.
    #[inline]
    pub fn push(&mut self, x: T) -> Option<Report<T>> {
        self.samples += 1;
        let good = self.health.admit(x);
        let y = self.filter.process(good)?;
        if self.trusts_samples() {
            self.listen(y);
        }
        self.until_decision -= 1;
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

    /// Histogram of the squared amplitude of the mode that is followed, for display.
    pub fn histogram(&self) -> Histogram<T> {
        self.amplitude.histogram()
    }

    /// Counts of bad samples since the start.
    pub fn health(&self) -> HealthCounts {
        self.health.counts()
    }

    /// What is wrong with the samples now.
    pub fn fault(&self) -> Option<Fault> {
        self.health.fault()
    }

    /// Input samples taken, missing ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The model of this moment.
    pub fn model(&self) -> &RecursiveArma<T, P, Q, N> {
        &self.model
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
        let step = self.model.update(y);
        match step.status {
            Status::Rejected => {}
            // No model yet: its roots are sought when it is there.
            Status::Starting => {
                self.roots.search();
                self.lost = true;
            }
            _ => self.lost = self.roots.track(self.model.a()) == Tracking::Searching,
        }
        self.amplitude.listen(y);
        let a = self.model.a();
        let filtered = self.model.filtered_outputs();
        for (slot, factor) in self.slots.iter_mut().zip(self.roots.factors(P)) {
            slot.listen(y, isolate(a, factor, filtered), &self.gains);
        }
    }
}
