//! Promise: the supervisor permits outputs only with everything that it takes; the judges
//! judge as their formulas say.

use proptest::prelude::*;
use rarma_box::guard::{
    CheckIns, Denial, Disobedience, Duty, Facts, FaultCode, FaultRecord, Follows, Heat, InARow,
    Mode, Severity, Stage, Still, Supervisor,
};

#[derive(Debug, Clone)]
enum Event {
    Start(Mode),
    Arm,
    Stop,
    Clear,
    Heartbeat,
    Fault(FaultCode),
    Enable(bool),
    StopChain(bool),
    Ticks(u16),
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        2 => (0usize..4).prop_map(|k| Event::Start(Mode::ALL[k])),
        4 => Just(Event::Arm),
        1 => Just(Event::Stop),
        3 => Just(Event::Clear),
        6 => Just(Event::Heartbeat),
        1 => (0..FaultCode::ALL.len()).prop_map(|k| Event::Fault(FaultCode::ALL[k])),
        2 => prop::bool::weighted(0.8).prop_map(Event::Enable),
        2 => prop::bool::weighted(0.8).prop_map(Event::StopChain),
        6 => (1u16..300).prop_map(Event::Ticks),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn gate_needs_everything(events in proptest::collection::vec(event(), 1..80)) {
        let mut supervisor = Supervisor::new(None);
        let (mut now, mut heartbeat) = (1_000_000u64, None);
        let (mut enable, mut stop_chain) = (true, true);
        // When it last tripped, and every millisecond in which the enable input was open.
        let (mut tripped, mut open_ms) = (None, Vec::new());
        for event in events {
            match event {
                Event::Start(mode) => { let _ = supervisor.start(mode); }
                Event::Arm => { let _ = supervisor.arm(now); }
                Event::Stop => supervisor.stop(now),
                Event::Clear => { let _ = supervisor.clear(now, supervisor.gate()); }
                Event::Heartbeat => { supervisor.heartbeat(now); heartbeat = Some(now); }
                Event::Enable(closed) => enable = closed,
                Event::StopChain(closed) => stop_chain = closed,
                Event::Fault(code) => {
                    let record = FaultRecord { code, place: 0, value: 0.0, at_us: now };
                    let stage = supervisor.stage();
                    if supervisor.report(record) == Severity::Trip {
                        if stage != Stage::Faulted { tripped = Some(now); }
                        prop_assert!(!supervisor.gate());
                        prop_assert_eq!(supervisor.stage(), Stage::Faulted);
                    } else {
                        prop_assert_eq!(supervisor.stage(), stage);
                    }
                }
                Event::Ticks(n) => for _ in 0..n {
                    now += 1000;
                    let facts = Facts { now_us: now, enable, stop_chain, energised: supervisor.gate(), arrived: true, steady: true, exciting: false };
                    let before = supervisor.stage();
                    let permission = supervisor.tick(&facts, &mut |_, _| {});
                    let trips = before != Stage::Faulted && supervisor.stage() == Stage::Faulted;
                    if trips || !stop_chain { tripped = Some(now); }
                    if !enable { open_ms.push(now); }
                    if permission.gate {
                        let released = tripped.is_none_or(|at| {
                            open_ms.iter().filter(|ms| **ms >= at).count() >= 50
                        });
                        prop_assert!(released, "on again without a release of the enable input");
                        prop_assert!(supervisor.gate() && supervisor.mode().owns_outputs());
                        prop_assert!(enable && stop_chain && supervisor.fault().is_none());
                        prop_assert!(heartbeat.is_some_and(|at| now - at <= 500_000));
                        prop_assert!(supervisor.stage().energised());
                    }
                    prop_assert!(!permission.calibrate || !permission.gate);
                },
            }
            prop_assert!(!supervisor.gate() || supervisor.fault().is_none());
        }
    }
}

#[test]
fn outputs_can_come_on_at_all() {
    let mut s = Supervisor::new(None);
    let mut facts = Facts {
        now_us: 0,
        enable: true,
        stop_chain: true,
        energised: false,
        arrived: true,
        steady: false,
        exciting: false,
    };
    s.tick(&facts, &mut |_, _| {});
    s.start(Mode::Cers).expect("off");
    s.heartbeat(0);
    s.arm(0).expect("everything there");
    let mut on = None;
    for ms in 1..100u64 {
        facts.now_us = 1000 * ms;
        facts.energised = s.gate();
        facts.steady = ms >= 50;
        if s.tick(&facts, &mut |r, _| panic!("{r:?}")).gate {
            on = on.or(Some(ms));
        }
    }
    assert_eq!(on, Some(70));
    assert_eq!(s.stage(), Stage::Ready);
}

#[test]
fn heat_fills_after_the_time_of_its_formula() {
    // r = 2.778, τ = 100 s: τ·ln(r/(r − 1)) = 44.6 s.
    let mut heat = Heat::default();
    let mut ms = 0;
    while heat.update(2.778, 1e-3, 100.0) < 1.0 {
        ms += 1;
    }
    assert!((44_400..44_900).contains(&ms), "{ms}");
    // At the nominal current it never does, to the rounding of single precision.
    let mut heat = Heat::default();
    for _ in 0..2_000_000 {
        heat.update(0.98, 1e-3, 100.0);
    }
    assert!((0.97..0.99).contains(&heat.theta()), "{}", heat.theta());
    assert!(Heat::default().update(f32::NAN, 1.0, 100.0) > 0.0);
}

fn pressures(
    set: impl Fn(usize) -> f32,
    real: impl Fn(usize, f32) -> f32,
) -> Option<(usize, Disobedience)> {
    let mut follows = Follows::default();
    let mut p = set(0);
    follows.reset(p);
    (0..5000).find_map(|ms| {
        p += 1e-3 / 0.101 * (set(ms) - p);
        let shown = real(ms, p);
        follows
            .update(set(ms), shown, 0.1, 3e4, 0.5)
            .map(|d| (ms, d))
    })
}

#[test]
fn pressure_that_follows_is_let_be_and_one_that_does_not_is_named() {
    let step = |ms: usize| if ms < 1000 { 1e5 } else { 5e5 };
    assert_eq!(pressures(step, |_, p| p), None);
    // 20 ms of dead time and a little short are let be, too.
    let lazy = |ms: usize, p: f32| if ms < 1020 { 1e5 } else { p - 1e4 };
    assert_eq!(pressures(step, lazy), None);
    let (ms, what) = pressures(step, |_, _| 1e5).expect("stuck");
    assert_eq!(what, Disobedience::Stuck);
    assert!((1500..1530).contains(&ms), "{ms}");
    let leak = |ms: usize, p: f32| if ms < 2000 { p } else { 0.6 * p };
    let (ms, what) = pressures(|_| 4e5, leak).expect("leak");
    // 0.5 s of 1 ms steps, to the rounding of their quotient.
    assert!((2498..2502).contains(&ms), "{ms}");
    assert!(matches!(what, Disobedience::Leak), "{what:?}");
    let over = |ms: usize, p: f32| p + (ms as f32 * 50.0).min(2e5);
    let (_, what) = pressures(|_| 2e5, over).expect("over");
    assert_eq!(what, Disobedience::Over);
    assert!(pressures(|_| 2e5, |_, _| f32::NAN).is_some());
}

#[test]
fn late_duty_is_named_and_the_watchdog_waits_for_all() {
    let mut check = CheckIns::new(0);
    assert!(!check.feed());
    for duty in Duty::ALL {
        assert!(!check.feed());
        check.here(duty, 1000);
    }
    assert!(check.feed() && !check.feed());
    assert_eq!(check.late(4000), None);
    for duty in [Duty::Samples, Duty::Link, Duty::Loop] {
        check.here(duty, 5000);
    }
    assert_eq!(check.late(5001), Some((Duty::Slow, 4001)));
    assert_eq!((check.times_late(), check.longest_us()[0]), (1, 4000));
}

#[test]
fn rows_of_bad_readings_and_still_codes() {
    let mut row = InARow::default();
    let bad = [true, false, true, true, true].map(|b| row.bad(b, 3));
    assert_eq!(bad, [false, false, false, false, true]);
    let mut still = Still::default();
    let codes = [5, 5, 5, 6, 6, 6, 6].map(|c| still.still(c, 3));
    assert_eq!(codes, [false, false, false, false, false, false, true]);
}

/// A supervisor that has tripped, been cleared, and has everything for arming but the edge.
fn tripped_and_cleared() -> (Supervisor, Facts) {
    let mut s = Supervisor::new(None);
    let facts = Facts {
        now_us: 1_000_000,
        enable: true,
        stop_chain: true,
        energised: false,
        arrived: true,
        steady: true,
        exciting: false,
    };
    s.tick(&facts, &mut |_, _| {});
    s.start(Mode::Cers).expect("off");
    s.heartbeat(facts.now_us);
    s.arm(facts.now_us).expect("a first time");
    let record = FaultRecord {
        code: FaultCode::OverCurrent,
        place: 0,
        value: 0.0,
        at_us: facts.now_us,
    };
    assert_eq!(s.report(record), Severity::Trip);
    s.clear(facts.now_us, false).expect("nothing stands");
    (s, facts)
}

/// Holds the contacts for so many milliseconds.
fn hold(s: &mut Supervisor, facts: &mut Facts, enable: bool, stop_chain: bool, ms: u64) {
    (facts.enable, facts.stop_chain) = (enable, stop_chain);
    for _ in 0..ms {
        facts.now_us += 1000;
        s.tick(facts, &mut |_, _| {});
    }
    s.heartbeat(facts.now_us);
}

#[test]
fn after_a_trip_the_enable_input_counts_by_its_edge() {
    // Open for so long, ms, then closed: only a hand counts, no bouncing contact.
    for (open_ms, arms) in [
        (0, false),
        (1, false),
        (49, false),
        (52, true),
        (5000, true),
    ] {
        let (mut s, mut facts) = tripped_and_cleared();
        hold(&mut s, &mut facts, true, true, 200);
        hold(&mut s, &mut facts, false, true, open_ms);
        hold(&mut s, &mut facts, true, true, 2);
        let expected = if arms {
            Ok(())
        } else {
            Err(Denial::EnableHeld)
        };
        assert_eq!(s.arm(facts.now_us), expected, "open for {open_ms} ms");
    }
    // A release while the emergency stop is pressed is none.
    let (mut s, mut facts) = tripped_and_cleared();
    hold(&mut s, &mut facts, false, false, 100);
    hold(&mut s, &mut facts, true, true, 10);
    s.clear(facts.now_us, false).expect("the chain is closed");
    assert_eq!(s.arm(facts.now_us), Err(Denial::EnableHeld));
    // Neither is one before the trip.
    let (mut s, mut facts) = tripped_and_cleared();
    hold(&mut s, &mut facts, false, true, 100);
    hold(&mut s, &mut facts, true, true, 10);
    s.arm(facts.now_us).expect("pressed again");
    s.stop(facts.now_us);
    s.arm(facts.now_us).expect("a stop is no trip");
    hold(&mut s, &mut facts, false, true, 1);
    assert_eq!(s.fault().map(|f| f.code), Some(FaultCode::EnableLost));
    hold(&mut s, &mut facts, true, true, 10);
    s.clear(facts.now_us, false).expect("nothing stands");
    assert_eq!(s.arm(facts.now_us), Err(Denial::EnableHeld));
    // What a reset has left behind is a trip, too; taking over what is on asks for a hand.
    let record = s.fault().unwrap_or(FaultRecord {
        code: FaultCode::Watchdog,
        place: 0,
        value: 0.0,
        at_us: 0,
    });
    assert!(Supervisor::new(Some(record)).press_again());
    assert!(!Supervisor::new(None).press_again());
}

#[test]
fn handing_over_lets_down_what_is_on_and_asks_for_a_hand() {
    let (mut s, mut facts) = tripped_and_cleared();
    hold(&mut s, &mut facts, false, true, 100);
    hold(&mut s, &mut facts, true, true, 10);
    s.hand_over(facts.now_us);
    assert!(!s.press_again(), "nothing was on");
    s.arm(facts.now_us).expect("pressed again");
    s.hand_over(facts.now_us);
    assert_eq!((s.stage(), s.press_again()), (Stage::Off, true));
}
