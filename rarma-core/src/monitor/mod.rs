//! One sample in, a verdict out: condition, estimate, spectrum and decide composed.
//!
//! Fast path: [`Monitor::push`] does a fixed amount of work per sample. Every
//! decimated sample gets a new model and new roots; every
//! [`DECISION_PERIOD_S`] the modes are read, with their uncertainty, and judged.

mod any;
mod config;
mod report;

pub use any::AnyMonitor;
pub use config::{DECISION_PERIOD_S, LEAST_MEMORY, MonitorConfig, MonitorError};
pub use report::{MAX_MODES, Report};

use crate::condition::{Band, BandFilter, Fault, Health, HealthCounts};
use crate::decide::{
    Alarm, AlarmEvent, IdleFinder, Mode, ModeTrack, Reading, Reason, Rotation, State,
};
use crate::estimate::{RecursiveArma, Status};
use crate::real::Real;
use crate::spectrum::{FactorTracker, LOCKIN_TAU_S, LockIn, Modal, Tracking, deviation, modal};

/// Smoothing of the band's power, s.
const POWER_TAU_S: f64 = 0.03;
/// A line at a half or a third of a mode with this part of its power makes the
/// mode an overtone.
const OVERTONE_RATIO: f64 = 0.2;
/// Part of the band's power that is never taken for explained: a lock-in reads a
/// line's power to a few percent only.
const LEAST_REST: f64 = 0.05;
/// The last roots stand for the present ones for this long while they are searched
/// for anew, s. They are found within milliseconds.
const LOST_HOLD_S: f64 = 0.1;
/// An alarm outlives bad samples for this long, s.
const ALARM_HOLD_S: f64 = 1.0;

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
    alarm: Alarm<T>,
    rotation: Rotation<T>,
    band: (T, T),
    idle_samples: Option<(u64, u64)>,
    fs: T,
    lockin_gain: T,
    power: T,
    power_gain: T,
    samples: u64,
    until_decision: u32,
    decision_every: u32,
    period_s: T,
    lost: bool,
    lost_s: T,
    fault_s: T,
}

/// One tracked mode: its factor's place, its lock-ins and its memory.
#[derive(Debug, Clone, Copy)]
struct Slot<T> {
    at: LockIn<T>,
    half: LockIn<T>,
    third: LockIn<T>,
    track: ModeTrack<T>,
}

impl<T: Real> Default for Slot<T> {
    fn default() -> Self {
        Self {
            at: LockIn::default(),
            half: LockIn::default(),
            third: LockIn::default(),
            track: ModeTrack::default(),
        }
    }
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
            alarm: Alarm::new(config.alarm()),
            rotation: Rotation {
                spindle_hz: config.spindle_hz.map(T::from_f64),
            },
            band: (T::from_f64(band.low_hz), T::from_f64(band.high_hz)),
            idle_samples: config.idle_s.map(|(from, to)| {
                let sample = |t: f64| (t * config.fs_hz) as u64;
                (sample(from), sample(to))
            }),
            fs: T::from_f64(fs),
            lockin_gain: T::from_f64((1.0 / (LOCKIN_TAU_S * fs)).min(1.0)),
            power: T::ZERO,
            power_gain: T::from_f64((1.0 / (POWER_TAU_S * fs)).min(1.0)),
            samples: 0,
            until_decision: decision_every,
            decision_every,
            period_s: T::from_f64(period_s),
            lost: true,
            lost_s: T::from_f64(LOST_HOLD_S),
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

    /// Counts of bad samples since the start.
    pub fn health(&self) -> HealthCounts {
        self.health.counts()
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
        self.power += self.power_gain * (y * y - self.power);
        for slot in &mut self.slots[..P.div_ceil(2)] {
            slot.at.process(y, self.lockin_gain);
            slot.half.process(y, self.lockin_gain);
            slot.third.process(y, self.lockin_gain);
        }
    }

    /// Reads the modes and judges them.
    fn decide(&mut self) -> Report<T> {
        self.lost_s = if self.lost {
            self.lost_s + self.period_s
        } else {
            T::ZERO
        };
        let lost = self.lost_s > T::from_f64(LOST_HOLD_S);
        let ready = self.model.ready() && !lost;
        let fault = self.health.fault();
        self.fault_s = match fault {
            Some(_) => self.fault_s + self.period_s,
            None => T::ZERO,
        };
        let level = self.power.sqrt();
        let told_idle = self
            .idle_samples
            .is_some_and(|(from, to)| (from..to).contains(&self.samples));
        let cutting = self
            .idle
            .update(level, told_idle, ready && self.trusts_samples());

        let mut modes = [None; MAX_MODES];
        if ready {
            let mut readings = [None; MAX_MODES];
            for (k, place) in readings.iter_mut().enumerate().take(P.div_ceil(2)) {
                *place = self.read_mode(k);
            }
            self.judge_modes(&mut readings, &mut modes);
        }
        let bad = !self.trusts_samples();
        let mut event = AlarmEvent::None;
        if ready && !bad {
            event = self
                .alarm
                .update(&modes, cutting && fault.is_none(), self.period_s);
        } else if self.alarm.standing().is_some() && self.fault_s > T::from_f64(ALARM_HOLD_S) {
            event = self.alarm.release();
        }
        let (state, reason) = match fault {
            Some(fault) if bad || self.alarm.standing().is_none() => {
                (State::Invalid, Reason::Samples(fault))
            }
            _ if !self.model.ready() => (State::Starting, Reason::EstimatorStarting),
            _ if lost && self.alarm.standing().is_none() => (State::Starting, Reason::RootsLost),
            _ => self.alarm.judge(&modes, cutting),
        };
        Report::new(
            self.samples,
            state,
            reason,
            event,
            level,
            &modes,
            self.alarm.standing(),
        )
    }

    /// Mode `k` as it is now, and the power at it; none for real roots.
    fn read_mode(&mut self, k: usize) -> Option<(Reading<T>, T)> {
        let factor = *self.roots.factors(P).get(k)?;
        let slot = self.slots.get_mut(k)?;
        let Some(Modal { frequency, damping }) = modal(&factor, self.fs) else {
            slot.track.reset();
            return None;
        };
        let sd = deviation(
            self.model.a(),
            N,
            &factor,
            self.fs,
            self.model.covariance(),
            self.model.covariance_factor(),
        )?;
        let all_finite = [frequency, damping, sd.frequency, sd.damping]
            .iter()
            .all(|x| x.is_finite());
        if !all_finite {
            return None;
        }
        let angle = T::from_f64(2.0) * T::PI * frequency / self.fs;
        slot.at.steer(angle);
        slot.half.steer(angle * T::from_f64(0.5));
        slot.third.steer(angle * T::from_f64(1.0 / 3.0));
        let here = slot.at.power();
        let rotation = self.rotation;
        // A line below explains the mode only where the known speed does not
        // explain that line: otherwise the speed itself decides.
        let explains = |part: f64, power: T| {
            let f = frequency * T::from_f64(part);
            power > here * T::from_f64(OVERTONE_RATIO)
                && rotation.harmonic(f, sd.frequency).is_none()
        };
        let reading = Reading {
            frequency: (frequency, sd.frequency),
            damping: (damping, sd.damping),
            amplitude: slot.at.amplitude(),
            share: T::ZERO,
            harmonic: rotation.harmonic(frequency, sd.frequency),
            overtone: explains(0.5, slot.half.power()) || explains(1.0 / 3.0, slot.third.power()),
            in_band: frequency >= self.band.0 && frequency <= self.band.1,
        };
        Some((reading, here))
    }

    /// Shares of the power that the rotation does not explain, and the labels.
    fn judge_modes(
        &mut self,
        readings: &mut [Option<(Reading<T>, T)>; MAX_MODES],
        modes: &mut [Option<(Mode<T>, T)>; MAX_MODES],
    ) {
        let mut forced = T::ZERO;
        for (reading, here) in readings.iter().flatten() {
            if reading.harmonic.is_some() {
                forced += *here;
            }
        }
        for ((reading, slot), mode) in readings.iter_mut().zip(&mut self.slots).zip(modes) {
            let Some((reading, here)) = reading else {
                continue;
            };
            let rest = (self.power - forced)
                .max(self.power * T::from_f64(LEAST_REST))
                .max(*here);
            if rest > T::ZERO && reading.harmonic.is_none() {
                reading.share = *here / rest;
            }
            let judged = slot
                .track
                .update(reading, self.alarm.config(), self.period_s);
            *mode = Some((judged, slot.track.suspicion_s()));
        }
    }
}
