//! The decision: modes read, explained, judged, and put into a word. Decision rate.

use super::feedback::Feedback;
use super::slot::{Slot, Surroundings};
use super::{MAX_MODES, Monitor, Report};
use crate::decide::{
    AlarmEvent, CUT_RATIO, Callers, Mode, Origin, Reading, Reason, SAME_MODE, Sight, State,
};
use crate::real::Real;
use crate::spectrum::{Modal, ModalDeviation, modal};

/// Factor on the share of power of a mode, as long as the machine has not been heard idling: it may be a tone of
/// the machine.
const NO_IDLE: f64 = 0.33;
/// A removed line with less than this part of the band's power is no chatter that would mark the surface: what
/// runout leaves of a line lies 10 to 20 dB below the lines of the teeth.
const STANDS_OUT: f64 = 0.1;
/// At least this part of the band's power counts as unexplained: a lock-in reads the power of a line to a few
/// percent only.
const LEAST_REST: f64 = 0.05;
/// While the roots of the model are searched for anew, the last ones are used for at most this long, s. The search
/// takes milliseconds.
pub(super) const LOST_HOLD_S: f64 = 0.1;
/// A mode may call an alarm only if the rotation makes its line with less than this chance. With 0.03 the results on
/// the population are the same.
const FREE: f64 = 0.1;
/// A mode belongs to the cut only while the band's power is at least this part of the largest so far (10 dB). When the
/// tool leaves the cut, fans and neighbours that chatter become audible, at times at the frequency of a mode that was damped
/// before. Of five false alarms by modes (16 in all) two are left with 5 to 10 dB and three with 13 dB; no chatter is
/// missed with any of them.
const OF_THE_CUT: f64 = 0.1;
/// A mode and a line whose frequencies differ by less than this part are one vibration.
const SAME_LINE: f64 = 0.02;
/// Bad samples end an alarm only after this time, s.
const ALARM_HOLD_S: f64 = 1.0;
/// From this time on the level has settled and is used, s.
const SETTLED_S: f64 = 0.2;

impl<T: Real> Monitor<T> {
    /// Reads the modes and judges them.
    pub(super) fn decide(&mut self) -> Report<T> {
        self.lost_s = if self.identifier.is_lost() {
            self.lost_s + self.period_s
        } else {
            T::ZERO
        };
        let lost = self.lost_s > T::from_f64(LOST_HOLD_S);
        let is_ready = self.identifier.is_ready();
        let ready = is_ready && !lost;
        let fault = self.health.fault();
        self.fault_s = match fault {
            Some(_) => self.fault_s + self.period_s,
            None => T::ZERO,
        };
        let level = self.power.sqrt();
        let told_idle = self
            .idle_samples
            .is_some_and(|(from, to)| (from..to).contains(&self.samples));
        let was_in_cut = self.idle.is_cutting() && self.idle.idle_level().is_some();
        self.heard_s = (self.heard_s + self.period_s).min(T::ONE);
        let settled = self.heard_s > T::from_f64(SETTLED_S);
        let cutting = self
            .idle
            .update(level, told_idle, settled && self.trusts_samples());
        // The entry of a tool raises the whole band, and not one line alone.
        let rest = (self.power - self.loudest).max(T::ZERO);
        let broad = self
            .idle
            .idle_level()
            .is_some_and(|idle| rest > idle * idle * T::from_f64(CUT_RATIO));
        let begins = cutting && !was_in_cut && broad;
        self.spindle
            .decide(self.samples, cutting, begins, self.period_s);
        self.tell_lines();

        let mut modes = [None; MAX_MODES];
        if ready {
            let mut readings = [None; MAX_MODES];
            let found = self.find_again();
            self.places.age(self.period_s);
            let locked = self.spindle.is_locked();
            if locked != self.was_locked {
                self.onset.begin_anew();
                if locked {
                    self.places.begin_anew();
                }
                self.was_locked = locked;
            }
            self.onset.note(self.rest_power, self.power, self.period_s);
            let modes_of_model = self.identifier.factors().len();
            let deviations = self.identifier.deviations(self.fs);
            let places = readings.iter_mut().zip(found.iter().zip(&deviations));
            for (k, (place, (modal, sd))) in places.enumerate().take(modes_of_model) {
                *place = self.read_mode(k, modal.as_ref(), sd.as_ref());
            }
            self.judge_modes(&mut readings, &mut modes);
            self.watch_lines(cutting);
        }
        let bad = !self.trusts_samples();
        let mut event = AlarmEvent::None;
        let is_heard = cutting && fault.is_none() && !self.onset.is_falling(self.power);
        let mut may_call = [false; MAX_MODES];
        for ((may_call, mode), slot) in may_call.iter_mut().zip(modes).zip(&self.slots) {
            *may_call = is_heard && mode.is_some_and(|mode| self.may_call(&mode, slot.runs_away()));
        }
        if ready && !bad {
            let callers = Callers {
                modes: &may_call,
                line_hz: self.suspected_line(true).filter(|_| fault.is_none()),
            };
            event = self.alarm.update(&modes, &callers, self.period_s);
        } else if self.alarm.standing().is_some() && self.fault_s > T::from_f64(ALARM_HOLD_S) {
            event = self.alarm.release();
        }
        let alarm_hz = self.alarm.standing().map(|standing| standing.frequency);
        if ready && !bad {
            self.amplitude.follow(&modes, alarm_hz, self.period_s);
        }
        let (state, reason) = match fault {
            Some(fault) if bad || self.alarm.standing().is_none() => {
                (State::Invalid, Reason::Samples(fault))
            }
            _ if !is_ready => (State::Starting, Reason::EstimatorStarting),
            _ if lost && self.alarm.standing().is_none() => (State::Starting, Reason::RootsLost),
            _ => match self.alarm.judge(&modes, &may_call, cutting) {
                (State::Stable, _) if self.blindness.is_blind() => {
                    (State::Warning, Reason::BlindAtMultiple)
                }
                (State::Stable, _)
                    if self.may_hide_chatter() || self.suspected_line(false).is_some() =>
                {
                    (State::Warning, Reason::OriginUnknown)
                }
                (State::Stable, Reason::ForcedOnly) if self.spindle.is_entering() => {
                    (State::Stable, Reason::Entering)
                }
                judged => judged,
            },
        };
        let standing = self.alarm.standing();
        let report = Report {
            sample: self.samples,
            state,
            reason,
            event,
            level,
            modes,
            spindle: self.spindle.report(),
            amplitude: self.amplitude.report(),
            standing: standing.map(|s| (s.frequency, s.lowest_damping)),
        };
        let report = report.in_order(standing.map(|s| s.slot));
        let alarm_stands = standing.is_some();
        self.hand_back(&Feedback {
            modes: ready.then_some(&modes),
            alarm_stands,
            alarm_ended: matches!(event, AlarmEvent::Off { .. }),
        });
        report
    }

    /// Passes the speed on to the verdict by lines: that of the tacho, or, where no speed is told, that of the
    /// comb of multiples that is heard and removed.
    fn tell_lines(&mut self) {
        if let Some(hz) = self.spindle.by_tacho() {
            self.sources.tell_speed(hz);
        } else if let Some(hz) = self.spindle.by_sound_alone() {
            // The lines follow it by themselves from then on, within the range that they search.
            if !(self.heard_speed && self.sources.reaches(hz)) {
                self.sources.tell_speed(hz);
            }
            self.heard_speed = true;
        } else if let Some(hz) = self.spindle.by_setting().filter(|_| self.heard_speed) {
            // The sound contradicted the speed that was told, and no longer does. Lines that a turned speed shares
            // with the told one make it look so, while the belief may have followed the turn.
            if !self.sources.explains_most() {
                self.sources.tell_speed(hz);
            }
            self.heard_speed = false;
        }
    }

    /// Frequency of the line that the verdict by lines calls chatter, Hz; none unless whether it knows the speed is
    /// as `known` asks.
    fn suspected_line(&self, known: bool) -> Option<T> {
        let said = self.sources.judgement();
        let says = self.hears_lines && self.knows_speed() == known && said.chatter;
        says.then_some(said.f_hz)
    }

    /// Whether the verdict by lines has a speed: one that is told and that the sound does not contradict, or one that is heard.
    fn knows_speed(&self) -> bool {
        self.heard_speed || self.spindle.is_told()
    }

    /// Whether a mode may call an alarm. It must have lost its damping while the cut went on, or grow by its own
    /// damping (`runs_away`), or have grown where idle was not heard, so that levels over idle are not known. If the speed is
    /// known, the verdict by lines must hold besides that the rotation does not make its line. If it is not known, a mode may
    /// also call at a line that would be called if the rotation did not make it.
    fn may_call(&self, mode: &Mode<T>, runs_away: bool) -> bool {
        if !self.hears_lines {
            return true;
        }
        let lost = mode.was_damped && self.sources.is_loud(T::from_f64(OF_THE_CUT));
        let grew = mode.grew && self.idle.idle_level().is_none();
        if !self.knows_speed() {
            let is_near = |hz: T| (hz - mode.frequency).abs() < hz * T::from_f64(SAME_LINE);
            return lost || grew || runs_away || self.suspected_line(false).is_some_and(is_near);
        }
        let forced = self.sources.forced_at(mode.frequency);
        let is_free = forced.is_some_and(|forced| forced < T::from_f64(FREE));
        // Flip chatter lies on multiples of the speed, where only the damping tells it from a forced line.
        let is_flip = mode.origin == Origin::Unknown;
        (lost && (is_free || is_flip)) || ((grew || runs_away) && is_free)
    }

    /// Whether a line that was removed as forced, though it may be self-excited, is as loud as a mode must be to be
    /// called.
    fn may_hide_chatter(&self) -> bool {
        let flip = self.spindle.loudest_standing();
        let known = if self.idle.idle_level().is_some() {
            T::ONE
        } else {
            T::from_f64(NO_IDLE)
        };
        let share = known * flip / (self.rest_power + flip);
        self.power > T::ZERO
            && self.alarm.config().loud(share, flip / self.power)
            && flip > self.power * T::from_f64(STANDS_OUT)
    }

    /// Watches whether a removed line rises by itself, for what is removed is not judged as a mode.
    fn watch_lines(&mut self, cutting: bool) {
        let changing = !cutting || self.spindle.is_changing();
        self.blindness
            .note(self.spindle.removed(), self.power, changing, self.period_s);
    }

    /// The modes of the model; none for real roots. Keeps each mode's memory with its frequency: where poles have
    /// changed places since the last decision, their slots are swapped.
    fn find_again(&mut self) -> [Option<Modal<T>>; MAX_MODES] {
        let mut modes = [None; MAX_MODES];
        for (mode, factor) in modes.iter_mut().zip(self.identifier.factors()) {
            *mode = modal(factor, self.fs);
        }
        let found = modes.map(|mode| mode.map(|mode| mode.frequency));
        for k in 0..MAX_MODES {
            let Some(frequency) = found.get(k).copied().flatten() else {
                continue;
            };
            let knows = |slot: Option<&Slot<T>>, f: T| slot.is_some_and(|s| s.track.is_at(f));
            if knows(self.slots.get(k), frequency) {
                continue;
            }
            let abandoned = (0..MAX_MODES).find(|&j| {
                let there = found.get(j).copied().flatten();
                knows(self.slots.get(j), frequency)
                    && !there.is_some_and(|f| knows(self.slots.get(j), f))
            });
            if let Some(j) = abandoned {
                self.slots.swap(k, j);
            }
        }
        modes
    }

    /// Mode `k` as it is now, and the power at it; none for real roots.
    fn read_mode(
        &mut self,
        k: usize,
        modal: Option<&Modal<T>>,
        sd: Option<&ModalDeviation<T>>,
    ) -> Option<(Reading<T>, T)> {
        let knows_speed = self.knows_speed();
        let slot = self.slots.get_mut(k)?;
        let Some(modal) = modal else {
            slot.reset();
            return None;
        };
        let sd = sd?;
        let all_finite = [modal.frequency, modal.damping, sd.frequency, sd.damping]
            .iter()
            .all(|x| x.is_finite());
        all_finite.then(|| {
            let around = Surroundings {
                fs: self.fs,
                band: self.band,
                rotation: self.spindle.rotation(),
                spindle: &self.spindle,
                sources: &self.sources,
                places: &self.places,
                config: self.alarm.config(),
                idle_known: self.idle.idle_level().is_some(),
                louder: self.onset.is_louder(self.rest_power) && !self.spindle.is_entering(),
                knows_speed,
                period_s: self.period_s,
            };
            slot.read(modal, sd, &around)
        })
    }

    /// Whether a pole pair is the least damped one at its place: a model of more poles than
    /// there are modes puts two at one.
    fn least_damped(&self, readings: &[Option<(Reading<T>, T)>; MAX_MODES]) -> [bool; MAX_MODES] {
        let mut least = [true; MAX_MODES];
        for (reading, least) in readings.iter().zip(&mut least) {
            let Some((one, _)) = reading else { continue };
            let (f, zeta) = (one.frequency.0, one.damping.0);
            *least = !readings.iter().flatten().any(|(other, _)| {
                (other.frequency.0 - f).abs() < f * T::from_f64(SAME_MODE) && other.damping.0 < zeta
            });
        }
        least
    }

    /// Shares of the power that nothing else explains, and the labels.
    fn judge_modes(
        &mut self,
        readings: &mut [Option<(Reading<T>, T)>; MAX_MODES],
        modes: &mut [Option<Mode<T>>; MAX_MODES],
    ) {
        let idle_known = self.idle.idle_level().is_some();
        let mut explained = T::ZERO;
        self.loudest = T::ZERO;
        for (reading, here) in readings.iter().flatten() {
            if reading.origin.explains() {
                explained += *here;
            }
            self.loudest = self.loudest.max(*here);
        }
        let places = self.least_damped(readings);
        let each = readings.iter_mut().zip(&mut self.slots).zip(modes);
        for (((reading, slot), mode), is_least) in each.zip(places) {
            let Some((reading, here)) = reading else {
                continue;
            };
            let rest = (self.rest_power - explained)
                .max(self.rest_power * T::from_f64(LEAST_REST))
                .max(*here);
            if rest > T::ZERO && !reading.origin.explains() {
                // Before idle is known, a line that no speed explains may have been there all along: it
                // must hold nearly all of the power.
                let doubted = !reading.grew && !idle_known;
                let known = T::from_f64(if doubted { NO_IDLE } else { 1.0 });
                reading.share = known * *here / rest;
            }
            if self.power > T::ZERO {
                reading.share_of_all = *here / self.power;
            }
            let ((f, _), (zeta, _)) = (reading.frequency, reading.damping);
            self.places.see(
                f,
                zeta,
                &Sight {
                    share: reading.share,
                    part: if is_least {
                        *here / self.rest_power
                    } else {
                        T::ZERO
                    },
                    power: *here,
                    is_steady: slot.is_steady(),
                },
                self.alarm.config(),
                self.period_s,
            );
            let line = self.alarm.config().may_be_line(reading.damping);
            if line && self.onset.rose_alone(*here, self.rest_power) {
                let clearly = self.onset.rose_clearly(*here, self.rest_power);
                self.places.rose(f, clearly, self.alarm.config());
            }
            *mode = Some(
                slot.track
                    .update(reading, self.alarm.config(), self.period_s),
            );
        }
    }
}
