//! The pair's one alarm: when the two channels together call a mode, and until when
//! it stands.

use super::PairConfig;
use crate::decide::{AlarmConfig, AlarmEvent, Dropped, Mode};
use crate::real::Real;

/// An alarm outlives the channel that held it for this long, s.
const ORPHAN_HOLD_S: f64 = 1.0;
/// After a release, the same mode is called jointly again only after this long, s:
/// what rings on is left to each channel's own alarm.
const AFTERGLOW_S: f64 = 1.0;
/// Two alarms within this part of f are one.
const SAME_ALARM: f64 = 0.03;

/// An alarm that stands.
#[derive(Debug, Clone, Copy)]
struct StandingAlarm<T> {
    /// Channel whose alarm this is; none while only both together are suspicious.
    lead: Option<usize>,
    frequency: T,
    lowest_damping: T,
    /// Nobody has held it for this long, s.
    over_s: T,
}

/// The alarm of two channels: calls, follows, releases.
#[derive(Debug, Clone)]
pub(super) struct PairAlarm<T> {
    standing: Option<StandingAlarm<T>>,
    /// Frequency of the last alarm, and for how long it is remembered, s.
    before: Option<(T, T)>,
    /// Each channel's own alarm has stood for this long, s, while it was listened to.
    stood_s: [T; 2],
    /// Where each sensor can hear, Hz.
    hears: [(T, T); 2],
    /// An alarm of one channel waits for this long for the other, s.
    alone_s: T,
    /// An alarm that both hold together ends when they have not for this long, s.
    release_s: T,
}

impl<T: Real> PairAlarm<T> {
    /// No alarm; `alarm` are the settings of the first channel's own one.
    pub(super) fn new(config: &PairConfig, alarm: &AlarmConfig<T>) -> Self {
        let hears = [0, 1].map(|i| {
            let hears = config.hears[i].unwrap_or_else(|| config.channels[i].band());
            (T::from_f64(hears.low_hz), T::from_f64(hears.high_hz))
        });
        Self {
            standing: None,
            before: None,
            stood_s: [T::ZERO; 2],
            hears,
            alone_s: alarm.confirm_s * T::from_f64(config.alone_confirmations - 1.0),
            release_s: alarm.release_s,
        }
    }

    /// Frequency, Hz, and lowest damping ratio of the alarm that stands.
    pub(super) fn standing(&self) -> Option<(T, T)> {
        self.standing.map(|a| (a.frequency, a.lowest_damping))
    }

    /// `period_s` later: each channel's `own` alarm (frequency, damping), whether the
    /// other waits for it, why it is left out, and the mode both suspect.
    pub(super) fn update(
        &mut self,
        own: &[Option<(T, T)>; 2],
        waited_for: &[bool; 2],
        dropped: &[Option<Dropped>; 2],
        joint: Option<Mode<T>>,
        period_s: T,
    ) -> AlarmEvent<T> {
        for (stood_s, own) in self.stood_s.iter_mut().zip(own) {
            *stood_s = match own {
                Some(_) => *stood_s + period_s,
                None => T::ZERO,
            };
        }
        let event = match self.standing {
            None => self.call(own, waited_for, joint),
            Some(alarm) => self.follow(alarm, own, dropped, joint.is_some(), period_s),
        };
        self.before = self
            .before
            .map(|(f, left_s)| (f, left_s - period_s))
            .filter(|(_, left_s)| *left_s > T::ZERO);
        event
    }

    /// Calls a mode, if there is one to call.
    fn call(
        &mut self,
        own: &[Option<(T, T)>; 2],
        waited_for: &[bool; 2],
        joint: Option<Mode<T>>,
    ) -> AlarmEvent<T> {
        let mut found = None;
        for (i, alarm) in own.iter().enumerate() {
            let Some((frequency, damping)) = *alarm else {
                continue;
            };
            let hears = self.hears[1 - i];
            let deaf = frequency < hears.0 || frequency > hears.1;
            let shared = own[1 - i].is_some_and(|(f, _)| is_near(f, frequency));
            let long = self.stood_s[i] >= self.alone_s;
            if found.is_none() && (shared || deaf || !waited_for[1 - i] || long) {
                found = Some((Some(i), frequency, damping));
            }
        }
        if found.is_none()
            && let Some(mode) = joint
            && !self.before.is_some_and(|(f, _)| is_near(f, mode.frequency))
        {
            found = Some((None, mode.frequency, mode.damping));
        }
        let Some((lead, frequency, damping)) = found else {
            return AlarmEvent::None;
        };
        self.standing = Some(StandingAlarm {
            lead,
            frequency,
            lowest_damping: damping,
            over_s: T::ZERO,
        });
        AlarmEvent::On { frequency, damping }
    }

    /// Keeps the alarm while a channel holds it.
    fn follow(
        &mut self,
        mut alarm: StandingAlarm<T>,
        own: &[Option<(T, T)>; 2],
        dropped: &[Option<Dropped>; 2],
        joint: bool,
        period_s: T,
    ) -> AlarmEvent<T> {
        let led = alarm.lead.filter(|i| own[*i].is_some());
        let lead = led.or_else(|| own.iter().position(Option::is_some));
        if let Some((i, (frequency, damping))) = lead.and_then(|i| Some((i, own[i]?))) {
            alarm.lead = Some(i);
            alarm.frequency = frequency;
            alarm.lowest_damping = alarm.lowest_damping.min(damping);
        }
        let jointly = alarm.lead.is_none() && joint;
        // A channel releases its own alarm after a time of its own. One that is left
        // out cannot say that the vibration is over.
        let patience = match alarm.lead {
            None => self.release_s,
            Some(i) if dropped[i].is_some() => T::from_f64(ORPHAN_HOLD_S),
            Some(_) => T::ZERO,
        };
        alarm.over_s = match lead.is_some() || jointly {
            true => T::ZERO,
            false => alarm.over_s + period_s,
        };
        if alarm.over_s <= patience {
            self.standing = Some(alarm);
            return AlarmEvent::None;
        }
        self.standing = None;
        self.before = Some((alarm.frequency, T::from_f64(AFTERGLOW_S)));
        AlarmEvent::Off {
            frequency: alarm.frequency,
            lowest_damping: alarm.lowest_damping,
        }
    }
}

/// Whether two frequencies are of one alarm.
pub(super) fn is_near<T: Real>(a: T, b: T) -> bool {
    (a - b).abs() < b * T::from_f64(SAME_ALARM)
}
