//! Frames that are lost, doubled and cut, against a truth that is counted apart.

use super::*;
use crate::record::Name;
use proptest::prelude::*;
use rarma_box::wire::{AlarmMessage, SpindleMessage, VERSION};
use rarma_core::decide;
use rarma_core::monitor::SpeedSource;
use rarma_core::named::Named;
use std::collections::BTreeMap;

const FS_HZ: f64 = 48_000.0;

fn at(seconds: f64) -> Utc {
    Utc::from_micros(1_800_000_000_000_000)
        .unwrap()
        .plus_s(seconds)
}

fn verdict(t: f64, state: State) -> Telemetry {
    let mut modes = heapless::Vec::new();
    modes
        .push(rarma_box::wire::ModeMessage {
            frequency: 900.0,
            frequency_sd: 1.0,
            damping: 0.02,
            damping_sd: 0.001,
            amplitude: 0.1,
            gradient: 0.0,
            label: decide::Label::Structural,
            harmonic: None,
            origin: decide::Origin::Free,
            time_left_s: None,
        })
        .unwrap();
    Telemetry::Verdict(rarma_box::wire::Verdict {
        sample: (t * FS_HZ) as u64,
        state,
        reason: decide::Reason::None,
        level: 0.5,
        modes,
        spindle: SpindleMessage {
            hz: Some(80.0),
            source: SpeedSource::Told,
            locked: false,
            notch_hz: 0.0,
            removed_power: 0.0,
        },
        amplitude: None,
    })
}

fn alarm(t: f64, on: bool) -> Telemetry {
    Telemetry::Alarm(AlarmMessage {
        sample: (t * FS_HZ) as u64,
        on,
        frequency: 901.0,
        damping: -0.003,
    })
}

fn head(session: u32, sequence: u32) -> Head {
    Head {
        version: VERSION,
        session,
        sequence,
        crc: 0,
    }
}

fn condenser(before: Option<UnderWay>) -> Condenser {
    let whose = Whose::new(Name::new("box-1").unwrap(), Name::new("M1").unwrap());
    let mut condenser = Condenser::new(whose, BoxClock::since(at(0.0)), 60.0, before);
    condenser.rate(FS_HZ);
    condenser
}

/// A day in frames: a verdict a second, chatter now and then with its alarms.
fn frames(states: &[bool]) -> Vec<(u32, f64, Telemetry)> {
    let mut frames = Vec::new();
    let mut number = 0;
    let mut say = |t, message| {
        number += 1;
        frames.push((number, t, message));
    };
    let mut before = false;
    for (k, &chatter) in states.iter().enumerate() {
        let t = k as f64;
        if chatter != before {
            say(t, alarm(t, chatter));
        }
        before = chatter;
        say(
            t,
            verdict(
                t,
                if chatter {
                    State::Chatter
                } else {
                    State::Stable
                },
            ),
        );
    }
    frames
}

fn seconds_of(records: &[Record]) -> BTreeMap<(State, String), f64> {
    let mut sums = BTreeMap::new();
    for record in records {
        if let Body::Verdict(v) = &record.body {
            *sums.entry((v.state, v.reason.to_string())).or_insert(0.0) += v.seconds;
        }
    }
    sums
}

fn states() -> impl Strategy<Value = Vec<bool>> {
    proptest::collection::vec((any::<bool>(), 1_usize..90), 2..12).prop_map(|runs| {
        runs.into_iter()
            .flat_map(|(s, n)| std::iter::repeat_n(s, n))
            .collect()
    })
}

proptest! {
    /// Any frames may be lost, and the gateway may be killed and restarted from what it kept: the
    /// stretches still follow one another without hole and overlap, every alarm is called and released
    /// at most once, and numbers never come twice.
    #[test]
    fn stretches_tile_time_whatever_is_lost(
        states in states(),
        losses in proptest::collection::vec((0.0..1.0_f64, 1_usize..40), 0..5),
        kills in proptest::collection::vec(0.0..1.0_f64, 0..3),
    ) {
        let frames = frames(&states);
        let place = |part: f64| (part * frames.len() as f64) as usize;
        let lost: std::collections::BTreeSet<usize> =
            losses.iter().flat_map(|&(from, n)| place(from)..place(from) + n).collect();
        let kills: Vec<usize> = kills.into_iter().map(place).collect();
        let mut condenser = condenser(None);
        let mut records = Vec::new();
        let mut heard = Vec::new();
        for (k, (sequence, t, message)) in frames.iter().enumerate() {
            if kills.contains(&k) {
                let kept = serde_json::to_string(&condenser.under_way()).unwrap();
                condenser = self::condenser(serde_json::from_str(&kept).unwrap());
            }
            if !lost.contains(&k) {
                if matches!(message, Telemetry::Verdict(_)) { heard.push(*t); }
                let fault = condenser.take(head(7, *sequence), message, at(*t), &mut |r| records.push(r));
                prop_assert_eq!(fault, None);
            }
        }
        condenser.end(&mut |r| records.push(r));
        prop_assert!(records.windows(2).all(|w| w[0].id < w[1].id), "in order, and none twice");
        let mut end = None;
        for record in &records {
            prop_assert!(record.check().is_ok());
            if let Body::Verdict(v) = &record.body {
                if let Some(end) = end {
                    prop_assert!(record.time.since_s(end).abs() < 1e-5, "hole or overlap at {}", record.time);
                }
                end = Some(record.time.plus_s(v.seconds));
            }
        }
        if let (Some(first), Some(last)) = (heard.first(), heard.last()) {
            let sum: f64 = seconds_of(&records).values().sum();
            prop_assert!((sum - (last - first)).abs() < 1e-4, "{sum} of {}", last - first);
        }
        let mut standing = None;
        for record in &records {
            match &record.body {
                Body::AlarmCalled(_) => prop_assert!(standing.replace(record.id.seq).is_none()),
                Body::AlarmReleased(a) => prop_assert_eq!(standing.take(), Some(a.called)),
                _ => {}
            }
        }
    }

    /// Nothing lost: seconds of each state are those of the truth, and every alarm is there.
    #[test]
    fn nothing_lost_is_nothing_missing(states in states()) {
        let mut condenser = condenser(None);
        let mut records = Vec::new();
        for (sequence, t, message) in frames(&states) {
            let _ = condenser.take(head(7, sequence), &message, at(t), &mut |r| records.push(r));
        }
        condenser.end(&mut |r| records.push(r));
        let chatter = states[..states.len() - 1].iter().filter(|&&s| s).count() as f64;
        let sums = seconds_of(&records);
        let of = |state| sums.get(&(state, "none".to_owned())).copied().unwrap_or(0.0);
        prop_assert!((of(State::Chatter) - chatter).abs() < 1e-6);
        prop_assert!((of(State::Stable) - ((states.len() - 1) as f64 - chatter)).abs() < 1e-6);
        prop_assert_eq!(of(State::Invalid), 0.0);
        let calls = records.iter().filter(|r| matches!(r.body, Body::AlarmCalled(_))).count();
        let ups = states.windows(2).filter(|w| !w[0] && w[1]).count() + usize::from(states[0]);
        prop_assert_eq!(calls, ups);
    }
}

#[test]
fn a_restart_of_the_box_is_a_hole_and_ends_the_alarm() {
    let mut condenser = condenser(None);
    let mut records = Vec::new();
    let mut with = |r| records.push(r);
    for (k, t) in [0.0, 1.0, 2.0].into_iter().enumerate() {
        let _ = condenser.take(
            head(7, k as u32),
            &verdict(t, State::Chatter),
            at(t),
            &mut with,
        );
    }
    let fault = condenser.take(
        head(8, 0),
        &verdict(0.0, State::Starting),
        at(30.0),
        &mut with,
    );
    assert_eq!(
        fault, None,
        "a box that was started anew has a clock that begins again"
    );
    let kinds: Vec<_> = records.iter().map(|r| r.body.kind().name()).collect();
    assert_eq!(kinds, ["alarm-called", "verdict", "alarm-released"]);
}

#[test]
fn a_monitor_started_anew_in_the_same_run_is_named() {
    let mut condenser = condenser(None);
    let mut count = 0;
    let mut with = |_| count += 1;
    let _ = condenser.take(
        head(7, 1),
        &verdict(100.0, State::Stable),
        at(0.0),
        &mut with,
    );
    let fault = condenser.take(head(7, 2), &verdict(1.0, State::Stable), at(1.0), &mut with);
    assert!(matches!(fault, Some(ClockFault::BoxBack { .. })));
}

/// The tool that is told last before a stretch's last verdict is the stretch's; that of a hole nobody knows.
#[test]
fn records_have_the_tool_that_was_told_while_they_lasted() {
    let mut condenser = condenser(None);
    let mut records = Vec::new();
    let mut sequence = 0;
    let mut say = |condenser: &mut Condenser, number: u32, t: f64, state| {
        sequence += number;
        let frame = verdict(t, state);
        let _ = condenser.take(head(7, sequence), &frame, at(t), &mut |r| records.push(r));
    };
    let tool = |name: &str| Some(Name::new(name).unwrap());
    say(&mut condenser, 1, 0.0, State::Stable);
    condenser.whose.tool = tool("T1");
    say(&mut condenser, 1, 1.0, State::Stable);
    say(&mut condenser, 1, 2.0, State::Idle);
    condenser.whose.tool = tool("T2");
    say(&mut condenser, 1, 3.0, State::Stable);
    say(&mut condenser, 1, 4.0, State::Stable);
    // Not heard for a while, in which the tool is changed.
    condenser.whose.tool = tool("T3");
    say(&mut condenser, 90, 94.0, State::Chatter);
    say(&mut condenser, 1, 95.0, State::Idle);
    let kinds: Vec<(f64, &str, Option<&str>)> = records
        .iter()
        .map(|r| {
            let reason = match &r.body {
                Body::Verdict(v) => v.state.name(),
                other => other.kind().name(),
            };
            let tool = r.tool.as_ref().map(Name::as_str);
            (r.time.since_s(at(0.0)), reason, tool)
        })
        .collect();
    assert_eq!(
        kinds,
        [
            (0.0, "stable", Some("T1")),
            (2.0, "idle", Some("T1")),
            (3.0, "stable", Some("T2")),
            (4.0, "invalid", None),
            (94.0, "alarm-called", Some("T3")),
            (94.0, "chatter", Some("T3")),
        ]
    );
}

/// A verdict that is lost within a state hides nothing; one that is lost where the state changes leaves a hole, for
/// nobody knows when it changed; another frame that is lost leaves none.
#[test]
fn what_is_lost_between_two_states_is_not_heard() {
    let mut condenser = condenser(None);
    let mut records = Vec::new();
    let mut sequence = 0;
    let mut say = |number: u32, t: f64, state| {
        sequence += number;
        let frame = verdict(t, state);
        let _ = condenser.take(head(7, sequence), &frame, at(t), &mut |r| records.push(r));
    };
    let (stable, idle) = (State::Stable, State::Idle);
    say(1, 0.0, stable);
    say(1, 1.0, stable);
    say(2, 3.0, stable);
    say(2, 5.0, idle);
    say(1, 6.0, idle);
    // Not a verdict.
    say(2, 7.0, stable);
    say(1, 8.0, idle);
    let told: Vec<(f64, State, f64)> = (records.iter())
        .filter_map(|r| match &r.body {
            Body::Verdict(v) => Some((r.time.since_s(at(0.0)), v.state, v.seconds)),
            _ => None,
        })
        .collect();
    assert_eq!(
        told,
        [
            (0.0, State::Stable, 3.0),
            (3.0, State::Invalid, 2.0),
            (5.0, State::Idle, 2.0),
            (7.0, State::Stable, 1.0),
        ]
    );
}
