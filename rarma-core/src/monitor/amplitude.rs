//! The amplitude statistic of the mode that matters: confirmation and label, never the
//! alarm.
//!
//! Rate: `listen` once a decimated sample, `follow` at the decision rate. One mode is
//! followed: the one an alarm stands on, else the least damped one; it is changed only
//! when it has gone from where it was.

use super::MAX_MODES;
use crate::decide::{AmplitudeReading, Fpk, Histogram, Mode};
use crate::real::Real;
use crate::spectrum::Envelope;
use crate::visit::state;

/// Above this damping ratio a pole pair is no mode to follow.
const MOST_DAMPING: f64 = 0.2;
/// The mode is the same within this part of its frequency.
const SAME: f64 = 0.05;
/// Without the mode for this long, s, another one is followed.
const PATIENCE_S: f64 = 0.3;

/// What the amplitude of the followed mode says.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AmplitudeReport<T> {
    /// Frequency of the mode, Hz.
    pub frequency: T,
    /// Scintillation and verdict.
    pub reading: AmplitudeReading<T>,
}

/// Follows one mode's envelope.
#[derive(Debug, Clone)]
pub(super) struct AmplitudeWatch<T> {
    envelope: Envelope<T>,
    statistic: Fpk<T>,
    frequency: Option<T>,
    missed_s: T,
}

state! { AmplitudeWatch<T> { envelope, statistic, frequency, missed_s } }

impl<T: Real> AmplitudeWatch<T> {
    pub(super) fn new(fs: f64, period_s: f64) -> Self {
        Self {
            envelope: Envelope::new(fs),
            statistic: Fpk::new(period_s),
            frequency: None,
            missed_s: T::ZERO,
        }
    }

    /// One decimated sample, without the spindle's lines.
    #[inline(always)]
    pub(super) fn listen(&mut self, y: T) {
        self.envelope.process(y);
    }

    /// The modes of a decision; `alarm_hz` is where an alarm stands.
    pub(super) fn follow(
        &mut self,
        modes: &[Option<Mode<T>>; MAX_MODES],
        alarm_hz: Option<T>,
        period_s: T,
    ) {
        let at = |mode: &Mode<T>, f: T| (mode.frequency - f).abs() <= f * T::from_f64(SAME);
        let candidates = || {
            let damped = |mode: &&Mode<T>| mode.damping < T::from_f64(MOST_DAMPING);
            modes
                .iter()
                .flatten()
                .filter(|mode| !mode.origin.explains())
                .filter(damped)
        };
        let least = |wanted: Option<T>| {
            let mut best: Option<&Mode<T>> = None;
            for mode in candidates().filter(|mode| wanted.is_none_or(|f| at(mode, f))) {
                if best.is_none_or(|b| mode.damping < b.damping) {
                    best = Some(mode);
                }
            }
            best
        };
        let alarm = alarm_hz.and_then(|f| least(Some(f)));
        let here = self.frequency.and_then(|f| least(Some(f)));
        let Some(mode) = alarm.or(here) else {
            self.missed_s += period_s;
            if self.missed_s > T::from_f64(PATIENCE_S) || self.frequency.is_none() {
                self.frequency = least(None).map(|mode| mode.frequency);
                self.begin();
            }
            return;
        };
        if !self.frequency.is_some_and(|f| at(mode, f)) {
            self.begin();
        }
        self.missed_s = T::ZERO;
        self.frequency = Some(mode.frequency);
        self.envelope.steer(mode.frequency, mode.damping);
        self.statistic
            .push(self.envelope.squared(), mode.frequency, mode.damping);
    }

    fn begin(&mut self) {
        self.missed_s = T::ZERO;
        self.envelope.reset();
        self.statistic.reset();
    }

    pub(super) fn report(&self) -> Option<AmplitudeReport<T>> {
        self.frequency.map(|frequency| AmplitudeReport {
            frequency,
            reading: self.statistic.reading(),
        })
    }

    pub(super) fn histogram(&self) -> Histogram<T> {
        self.statistic.histogram()
    }
}
