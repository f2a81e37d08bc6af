//! A monitor begins, where it lies.
//!
//! Slow path. A monitor is 51 KB, and a box has one for ever, in static memory. A new one that
//! is built by value needs its size on the stack, and again for every function that hands it
//! on; so each part is begun anew in its place, and nothing larger than a small part lies on
//! the stack meanwhile.

use super::amplitude::AmplitudeWatch;
use super::blind::Blindness;
use super::identifier::Identifier;
use super::slot::{Gains, Slot};
use super::spindle::Spindle;
use super::{DECISION_PERIOD_S, MAX_MODES, Monitor, MonitorConfig, MonitorError, verdict};
use crate::condition::{BandFilter, Health};
use crate::decide::{Alarm, AlarmConfig, IdleFinder, Onset, Places};
use crate::real::Real;
use crate::verdict::Verdict;

/// Smoothing of the band's power, s.
const POWER_TAU_S: f64 = 0.03;

impl<T: Real> Monitor<T> {
    /// A monitor of no settings: it takes samples, but makes nothing of them until
    /// [`Self::restart`]. Cheap to put in its place, because its large parts are not there yet.
    pub fn unstarted() -> Self {
        Self {
            health: Health::new(1.0, None),
            filter: BandFilter::unstarted(),
            identifier: Identifier::default(),
            slots: [Slot::default(); MAX_MODES],
            idle: IdleFinder::new(1.0),
            places: Places::default(),
            onset: Onset::default(),
            was_locked: false,
            blindness: Blindness::default(),
            amplitude: AmplitudeWatch::new(1.0, 1.0),
            alarm: Alarm::new(AlarmConfig::default()),
            spindle: Spindle::default(),
            sources: Verdict::BLANK,
            hears_lines: false,
            heard_speed: false,
            band: (T::ZERO, T::ZERO),
            idle_samples: None,
            fs: T::ZERO,
            gains: Gains::new(1.0),
            power: T::ZERO,
            rest_power: T::ZERO,
            loudest: T::ZERO,
            power_gain: T::ZERO,
            samples: 0,
            heard_s: T::ZERO,
            until_decision: 0,
            decision_every: 0,
            period_s: T::ZERO,
            lost_s: T::ZERO,
            fault_s: T::ZERO,
        }
    }

    /// Forgets everything and begins with these settings, as [`Self::new`] does, but in place.
    ///
    /// # Errors
    /// See [`MonitorConfig::check`]; nothing has changed then.
    #[inline(never)]
    pub fn restart(&mut self, config: &MonitorConfig) -> Result<(), MonitorError> {
        config.check()?;
        // All of them by name, so that none is forgotten.
        let Self {
            health,
            filter,
            identifier,
            slots,
            idle,
            places,
            onset,
            was_locked,
            blindness,
            amplitude,
            alarm,
            spindle,
            sources,
            hears_lines,
            heard_speed,
            band,
            idle_samples,
            fs: rate,
            gains,
            power,
            rest_power,
            loudest,
            power_gain,
            samples,
            heard_s,
            until_decision,
            decision_every,
            period_s: period,
            lost_s,
            fault_s,
        } = self;
        let analysed = config.band();
        filter
            .restart(analysed, config.fs_hz)
            .map_err(MonitorError::Band)?;
        let fs = config.fs_hz / filter.factor() as f64;
        *decision_every = ((DECISION_PERIOD_S * fs) as u32).max(1);
        *until_decision = *decision_every;
        let period_s = f64::from(*decision_every) / fs;
        *health = Health::new(config.fs_hz, config.full_scale);
        identifier.restart(config.order, config.estimator(fs));
        slots.fill(Slot::default());
        *idle = IdleFinder::new(period_s);
        *places = Places::default();
        *onset = Onset::default();
        *blindness = Blindness::default();
        *amplitude = AmplitudeWatch::new(fs, period_s);
        *alarm = Alarm::new(config.alarm());
        spindle.restart(config, fs);
        let told = config.listening(fs);
        *hears_lines = sources.restart(&config.verdict, &told).is_ok();
        *band = (T::from_f64(analysed.low_hz), T::from_f64(analysed.high_hz));
        *idle_samples = config.idle_s.map(|(from, to)| {
            let sample = |t: f64| (t * config.fs_hz) as u64;
            (sample(from), sample(to))
        });
        *rate = T::from_f64(fs);
        *gains = Gains::new(fs);
        *power_gain = T::from_f64((1.0 / (POWER_TAU_S * fs)).min(1.0));
        *period = T::from_f64(period_s);
        *lost_s = T::from_f64(verdict::LOST_HOLD_S);
        (*was_locked, *heard_speed) = (false, false);
        *samples = 0;
        for x in [power, rest_power, loudest, heard_s, fault_s] {
            *x = T::ZERO;
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "start_tests.rs"]
mod tests;
