//! A box's frames as records: stretches of one state, alarms, and what was not heard.
//!
//! A box says twenty verdicts a second; what is kept is how long each state lasted. Stretches of a box
//! follow one another without holes: where frames are missing for longer than [`GAP_S`], or the gateway
//! was not there, a stretch of state `invalid` with the reason `not-heard` stands in their place.
//!
//! Everything a record is made of comes from frames, and its number from the number of the frame that
//! completed it: frames that are read twice (a recording, a copy) give the same records.

mod under_way;

use super::clock::{BoxClock, ClockFault};
use super::words;
use crate::record::{AlarmCalled, Body, Clock, Record, State, Utc, Verdict};
use rarma_box::wire::{Head, Telemetry};
use under_way::{
    ALARM_ENDED, Alarm, CALLED, HOLE, RELEASED, STRETCH, STRETCH_ENDED, Seen, Stretch, number,
    rounded_s, stretch,
};
pub use under_way::{UnderWay, Whose};

/// Verdicts of one state further apart than this leave a hole, s. Shorter losses of single frames do
/// not part a stretch: the state on both sides of them is known, and the same.
pub const GAP_S: f64 = 2.0;

/// Makes records of one box's frames.
#[derive(Debug)]
pub struct Condenser {
    /// What stands in the head of records from now on.
    pub whose: Whose,
    /// The box's clock against UTC.
    pub clock: BoxClock,
    /// A stretch is ended after so long, s.
    stretch_s: f64,
    fs_hz: Option<f64>,
    last_frame: Option<(u32, u32)>,
    /// Frames were lost since the last verdict, or may have been.
    lost: bool,
    under_way: Option<UnderWay>,
}

impl Condenser {
    /// Nothing heard yet; or going on where another one was.
    #[must_use]
    pub fn new(whose: Whose, clock: BoxClock, stretch_s: f64, before: Option<UnderWay>) -> Self {
        Self {
            whose,
            clock,
            stretch_s,
            fs_hz: before.as_ref().map(|u| u.fs_hz),
            last_frame: None,
            lost: true,
            under_way: before,
        }
    }

    /// What is under way, to be kept.
    #[must_use]
    pub fn under_way(&self) -> Option<&UnderWay> {
        self.under_way.as_ref()
    }

    /// Rate of the box's samples, Hz, as it was told: without it verdicts have no time of the box.
    pub fn rate(&mut self, fs_hz: f64) {
        if fs_hz > 0.0 && fs_hz.is_finite() {
            self.fs_hz = Some(fs_hz);
        }
    }

    /// Takes a message as it arrives; hands on the records that it completes. Says if a clock
    /// ran backwards.
    pub fn take(
        &mut self,
        head: Head,
        message: &Telemetry,
        arrival: Utc,
        with: &mut dyn FnMut(Record),
    ) -> Option<ClockFault> {
        let last = self.last_frame.replace((head.session, head.sequence));
        match last {
            Some((session, _)) if session != head.session => self.clock.restart(),
            Some((_, sequence)) if head.sequence == sequence.wrapping_add(1) => {}
            _ => self.lost = true,
        }
        match message {
            Telemetry::Started { fs_hz, .. } => self.rate(*fs_hz),
            Telemetry::Hello(identity) => self.rate(f64::from(identity.sample_rate_hz)),
            Telemetry::Verdict(verdict) => {
                let (box_s, time, clock, fault) = self.when(verdict.sample, arrival)?;
                let seen = Seen { head, time, clock };
                let next = stretch(verdict, time, box_s, self.whose.tool.clone());
                self.verdict(&seen, next, with);
                return fault;
            }
            Telemetry::Alarm(alarm) => {
                let (_, time, clock, fault) = self.when(alarm.sample, arrival)?;
                let seen = Seen { head, time, clock };
                let said = (
                    words::decimal(alarm.frequency),
                    words::decimal(alarm.damping),
                );
                if alarm.on {
                    self.call(&seen, said, with);
                } else {
                    self.release(&seen, Some(said), with);
                }
                return fault;
            }
            _ => {}
        }
        None
    }

    /// When a sample was taken; nothing before the rate is known.
    fn when(&mut self, sample: u64, arrival: Utc) -> Option<(f64, Utc, Clock, Option<ClockFault>)> {
        #[allow(clippy::cast_precision_loss, reason = "2^53 samples are 5000 years")]
        let box_s = sample as f64 / self.fs_hz?;
        let fault = self.clock.hears(box_s, arrival);
        let (time, clock) = self.clock.time(box_s, arrival);
        Some((box_s, time, clock, fault))
    }

    fn verdict(&mut self, seen: &Seen, next: Stretch, with: &mut dyn FnMut(Record)) {
        let lost = std::mem::take(&mut self.lost);
        let state = next.state;
        let heard = next.modes.iter().min_by(|a, b| a.zeta.total_cmp(&b.zeta));
        let heard = heard.map(|m| (m.f_hz, m.zeta));
        match self
            .under_way
            .as_ref()
            .map(|before| before.goes_on(seen, state, lost))
        {
            None => self.begin(seen, next, None),
            Some(true) => self.go_on(seen, next, lost, with),
            Some(false) => self.hole(seen, next, with),
        }
        let Some(under_way) = &mut self.under_way else {
            return;
        };
        if let (Some(alarm), Some((_, zeta))) = (&mut under_way.alarm, heard) {
            alarm.zeta_lowest = alarm.zeta_lowest.min(zeta);
        }
        // Among the lost frames there may have been a call or a release: the state tells.
        match (lost, state, under_way.alarm.is_some(), heard) {
            (true, State::Chatter, false, Some(said)) => self.call(seen, said, with),
            (true, State::Starting | State::Idle | State::Stable, true, _) => {
                self.release(seen, None, with);
            }
            _ => {}
        }
    }

    fn begin(&mut self, seen: &Seen, stretch: Stretch, alarm: Option<Alarm>) {
        self.under_way = Some(UnderWay {
            session: seen.session(),
            sequence: seen.head.sequence,
            box_s: seen.clock.box_s,
            fs_hz: self.fs_hz.unwrap_or_default(),
            every_s: None,
            stretch,
            alarm,
        });
    }

    fn go_on(&mut self, seen: &Seen, next: Stretch, lost: bool, with: &mut dyn FnMut(Record)) {
        let Some(before) = &mut self.under_way else {
            return;
        };
        let box_s = seen.clock.box_s;
        let same = before.stretch.state == next.state && before.stretch.reason == next.reason;
        // Where frames are lost there may have been verdicts between the two.
        let apart_s = box_s - before.box_s;
        before.every_s = before
            .every_s
            .filter(|every_s| lost && *every_s < apart_s)
            .or(Some(apart_s));
        (before.sequence, before.box_s) = (seen.head.sequence, box_s);
        if same && box_s - before.stretch.from_box_s < self.stretch_s {
            before.stretch.merge(next);
            return;
        }
        let ended = std::mem::replace(&mut before.stretch, next);
        let seconds = box_s - ended.from_box_s;
        let clock = Clock {
            box_s: ended.from_box_s,
            ..seen.clock
        };
        let id = (seen.session(), number(seen.head.sequence, STRETCH));
        let tool = ended.tool.clone();
        with(
            self.whose
                .record(id, tool, ended.from, clock, ended.body(seconds)),
        );
    }

    /// What was under way ended where it was last heard; then comes a hole, then `next`.
    fn hole(&mut self, seen: &Seen, next: Stretch, with: &mut dyn FnMut(Record)) {
        let Some(before) = self.under_way.take() else {
            return;
        };
        let same_run = before.session == seen.session() && before.box_s <= seen.clock.box_s;
        let (box_s, last) = (before.box_s, before.last());
        let alarm = self.end_at_last(before, same_run && next.state == State::Chatter, with);
        let (seconds, from_box_s) = if same_run {
            (seen.clock.box_s - box_s, box_s)
        } else {
            (seen.time.since_s(last), 0.0)
        };
        if seconds > 0.0 {
            let hole = Body::Verdict(Verdict {
                state: State::Invalid,
                reason: words::name("not-heard"),
                seconds: rounded_s(seconds),
                level: None,
                rpm: None,
                modes: Vec::new(),
            });
            let clock = Clock {
                box_s: from_box_s,
                ..seen.clock
            };
            let id = (seen.session(), number(seen.head.sequence, HOLE));
            // Which tools there were meanwhile is not known either.
            with(self.whose.record(id, None, last, clock, hole));
        }
        self.begin(seen, next, alarm);
    }

    /// Ends the stretch where it was last heard. The alarm that stood ends there, too, unless it
    /// is known to go on.
    fn end_at_last(
        &mut self,
        ended: UnderWay,
        alarm_goes_on: bool,
        with: &mut dyn FnMut(Record),
    ) -> Option<Alarm> {
        let seconds = ended.box_s - ended.stretch.from_box_s;
        let last = ended.last();
        let clock = |box_s| Clock {
            box_s,
            drift_ppm: None,
            drift_sd_ppm: None,
            time_sd_s: None,
        };
        let (session, sequence) = (ended.session, ended.sequence);
        let tool = ended.stretch.tool.clone();
        if seconds > 0.0 {
            let from = ended.stretch.from;
            let clock = clock(ended.stretch.from_box_s);
            let id = (session, number(sequence, STRETCH_ENDED));
            let body = ended.stretch.body(seconds);
            with(self.whose.record(id, tool.clone(), from, clock, body));
        }
        let alarm = ended.alarm?;
        if alarm_goes_on {
            return Some(alarm);
        }
        let clock = clock(ended.box_s);
        let id = (session, number(sequence, ALARM_ENDED));
        let body = alarm.released(None, ended.box_s);
        with(self.whose.record(id, tool, last, clock, body));
        None
    }

    fn call(&mut self, seen: &Seen, (f_hz, zeta): (f64, f64), with: &mut dyn FnMut(Record)) {
        let Some(under_way) = &mut self.under_way else {
            return;
        };
        if let Some(before) = under_way.alarm.take() {
            // Its release was lost, and all verdicts up to the next call.
            let id = (under_way.session, number(under_way.sequence, ALARM_ENDED));
            let clock = Clock {
                box_s: under_way.box_s,
                ..seen.clock
            };
            let body = before.released(None, under_way.box_s);
            let tool = self.whose.tool.clone();
            with(self.whose.record(id, tool, under_way.last(), clock, body));
        }
        under_way.sequence = seen.head.sequence;
        let called = number(seen.head.sequence, CALLED);
        let rpm = under_way.stretch.rpm;
        under_way.alarm = Some(Alarm {
            called,
            at_box_s: seen.clock.box_s,
            f_hz,
            zeta_lowest: zeta,
            rpm,
        });
        let body = Body::AlarmCalled(AlarmCalled {
            f_hz,
            zeta,
            rpm,
            teeth: self.whose.teeth,
        });
        let (id, tool) = ((seen.session(), called), self.whose.tool.clone());
        with(self.whose.record(id, tool, seen.time, seen.clock, body));
    }

    fn release(&mut self, seen: &Seen, said: Option<(f64, f64)>, with: &mut dyn FnMut(Record)) {
        // The call of an alarm that stood when the gateway first heard of the box is not known.
        let Some(alarm) = self.under_way.as_mut().and_then(|u| u.alarm.take()) else {
            return;
        };
        if let Some(under_way) = &mut self.under_way {
            under_way.sequence = seen.head.sequence;
        }
        let body = alarm.released(said, seen.clock.box_s);
        let id = (seen.session(), number(seen.head.sequence, RELEASED));
        let tool = self.whose.tool.clone();
        with(self.whose.record(id, tool, seen.time, seen.clock, body));
    }

    /// The box will not be heard for a while, or ever: ends what is under way where it was last heard.
    pub fn end(&mut self, with: &mut dyn FnMut(Record)) {
        if let Some(ended) = self.under_way.take() {
            let _ = self.end_at_last(ended, false, with);
        }
    }
}

#[cfg(test)]
#[path = "condense_tests.rs"]
mod tests;
