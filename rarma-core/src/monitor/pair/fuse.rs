//! Two channels' reports put into one.

use crate::condition::Fault;
use crate::decide::{ChannelFault, Dropped, Hearing, Mode, Reason, State, partner, surer};
use crate::monitor::{MAX_MODES, Report};
use crate::real::Real;

/// Which of two verdicts is the graver.
fn gravity(state: State) -> u8 {
    match state {
        State::Invalid => 0,
        State::Starting => 1,
        State::Idle => 2,
        State::Stable => 3,
        State::Warning => 4,
        State::Chatter => 5,
    }
}

/// What a channel says: the fault of its samples and its last report.
pub(super) fn hearing<T: Real>(fault: Option<Fault>, last: Option<&Report<T>>) -> Hearing<'_, T> {
    let state = last.map_or(State::Starting, |r| r.state);
    Hearing {
        fault,
        judging: !matches!(state, State::Starting | State::Invalid),
        cutting: !matches!(state, State::Starting | State::Invalid | State::Idle),
        level: last.map_or(T::ZERO, |r| r.level),
        modes: last.map_or(&[], |r| &r.modes),
    }
}

/// One word for both: that of the alarm, else the graver of those that are listened to
/// (`heard`), else why nobody is.
pub(super) fn state<T: Real>(
    alarm: bool,
    heard: &[Option<Report<T>>; 2],
    dropped: &[Option<Dropped>; 2],
) -> (State, Reason) {
    let bad = dropped.map(|d| match d?.fault {
        ChannelFault::Samples(fault) => Some(fault),
        _ => None,
    });
    if alarm && !bad.iter().all(|f| f.is_some_and(|f| f != Fault::Clipped)) {
        return (State::Chatter, Reason::None);
    }
    let mut gravest: Option<(State, Reason)> = None;
    for report in heard.iter().flatten() {
        let word = match report.state {
            // One alone, and not for long enough.
            State::Chatter => (State::Warning, Reason::Undamped),
            state => (state, report.reason),
        };
        if gravest.is_none_or(|(state, _)| gravity(word.0) > gravity(state)) {
            gravest = Some(word);
        }
    }
    let starting = (State::Starting, Reason::EstimatorStarting);
    gravest.unwrap_or_else(|| match bad {
        // A sick channel and one that is silent: there is nothing to hear.
        [Some(fault), _] | [_, Some(fault)] if dropped.iter().all(Option::is_some) => {
            (State::Invalid, Reason::Samples(fault))
        }
        _ => starting,
    })
}

/// The leading channel's modes, each as the surer of the two reads it, then those that
/// only the other hears, while there is room.
pub(super) fn modes<T: Real>(
    lead: &[Option<Mode<T>>; MAX_MODES],
    other: &[Option<Mode<T>>; MAX_MODES],
) -> [Option<Mode<T>>; MAX_MODES] {
    let mut out = [None; MAX_MODES];
    let mut places = out.iter_mut();
    for mode in lead.iter().flatten() {
        let read = match partner(mode, other) {
            Some(there) => Mode {
                amplitude: mode.amplitude,
                share: mode.share,
                ..surer(*mode, there)
            },
            None => *mode,
        };
        if let Some(place) = places.next() {
            *place = Some(read);
        }
    }
    for mode in other.iter().flatten() {
        if partner(mode, lead).is_none()
            && let Some(place) = places.next()
        {
            *place = Some(*mode);
        }
    }
    out
}
