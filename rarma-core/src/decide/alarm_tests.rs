use super::*;
use crate::decide::{Evidence, ModeTrack, Reading};

const PERIOD_S: f64 = 0.002;

/// One track, one alarm, fed with readings of a mode at 900 Hz.
struct Bench {
    track: ModeTrack<f64>,
    alarm: Alarm<f64>,
    now_s: f64,
}

impl Bench {
    fn new() -> Self {
        Self {
            track: ModeTrack::default(),
            alarm: Alarm::new(AlarmConfig::default()),
            now_s: 0.0,
        }
    }

    fn reading(damping: f64, share: f64, amplitude: f64) -> Reading<f64> {
        Reading {
            frequency: (900.0, 0.5),
            damping: (damping, 0.001),
            amplitude,
            share,
            share_of_all: share,
            origin: Origin::Free,
            harmonic: None,
            in_band: true,
            grew: false,
            threshold: 0.01,
            evidence: Evidence::default(),
        }
    }

    /// Feeds a reading for some seconds; the time of the first event, and it.
    fn feed(
        &mut self,
        reading: &Reading<f64>,
        seconds: f64,
        may_call: bool,
    ) -> Option<(f64, AlarmEvent<f64>)> {
        let mut first = None;
        for _ in 0..(seconds / PERIOD_S) as usize {
            self.now_s += PERIOD_S;
            let mode = self
                .track
                .update(reading, &AlarmConfig::default(), PERIOD_S);
            let modes = [Some(mode)];
            let callers = Callers {
                modes: &[may_call],
                line_hz: None,
            };
            let event = self.alarm.update(&modes, &callers, PERIOD_S);
            if event != AlarmEvent::None && first.is_none() {
                first = Some((self.now_s, event));
            }
        }
        first
    }
}

#[test]
fn calls_after_the_confirmation_and_holds_through_smeared_damping() {
    let mut bench = Bench::new();
    assert_eq!(bench.feed(&Bench::reading(0.03, 0.5, 1.0), 1.0, true), None);
    let (t, event) = bench
        .feed(&Bench::reading(0.004, 0.8, 2.0), 0.6, true)
        .expect("called");
    assert!((1.055..1.07).contains(&t), "called at {t}");
    assert!(matches!(event, AlarmEvent::On { .. }));
    // 3.5 % is above the threshold, but not damped for certain.
    assert_eq!(
        bench.feed(&Bench::reading(0.035, 0.4, 1.0), 5.0, true),
        None
    );
    let (_, event) = bench
        .feed(&Bench::reading(0.08, 0.4, 1.0), 1.0, true)
        .expect("released");
    let AlarmEvent::Off {
        frequency,
        lowest_damping,
    } = event
    else {
        panic!("not a release: {event:?}");
    };
    assert_eq!((frequency, lowest_damping), (900.0, 0.004));
}

#[test]
fn releases_when_the_vibration_has_gone_whatever_the_damping_reads() {
    let mut bench = Bench::new();
    bench.feed(&Bench::reading(0.004, 0.8, 2.0), 0.5, true);
    assert!(bench.alarm.standing().is_some());
    let (t, event) = bench
        .feed(&Bench::reading(0.004, 0.8, 0.2), 0.5, true)
        .expect("released");
    assert!(
        (0.64..0.67).contains(&t) && matches!(event, AlarmEvent::Off { .. }),
        "{t}"
    );
    // What rings on is not called again; the same mode at full size is.
    assert!(bench.alarm.standing().is_none());
    assert_eq!(
        bench.feed(&Bench::reading(0.004, 0.8, 0.2), 0.3, true),
        None
    );
    assert!(
        bench
            .feed(&Bench::reading(0.004, 0.8, 2.0), 0.2, true)
            .is_some()
    );
}

#[test]
fn forced_soft_damped_out_of_band_and_idle_modes_are_not_called() {
    let undamped = Bench::reading(0.001, 0.9, 1.0);
    for reading in [
        Reading {
            origin: Origin::Rotation,
            harmonic: Some(6),
            share: 0.0,
            ..undamped
        },
        Reading {
            origin: Origin::Overtone,
            ..undamped
        },
        Reading {
            share: 0.1,
            ..undamped
        },
        Reading {
            in_band: false,
            ..undamped
        },
        Reading {
            damping: (0.0101, 0.005),
            ..undamped
        },
        Reading {
            damping: (f64::NAN, f64::NAN),
            ..undamped
        },
    ] {
        assert_eq!(Bench::new().feed(&reading, 2.0, true), None, "{reading:?}");
    }
    assert_eq!(Bench::new().feed(&undamped, 2.0, false), None);
}

#[test]
fn an_alarm_that_settles_on_a_multiple_of_the_speed_is_withdrawn() {
    let mut bench = Bench::new();
    let undamped = Bench::reading(0.001, 0.9, 1.0);
    bench.feed(&undamped, 0.6, true);
    let passing = Reading {
        origin: Origin::Rotation,
        harmonic: Some(33),
        ..undamped
    };
    assert_eq!(
        bench.feed(&passing, 0.8, true),
        None,
        "drifting through is no reason"
    );
    assert_eq!(bench.feed(&undamped, 0.1, true), None);
    let (t, _) = bench.feed(&passing, 2.0, true).expect("withdrawn");
    assert!((2.49..2.52).contains(&t), "{t}");
}

#[test]
fn an_alarm_with_little_to_stand_on_goes_easily() {
    let mut bench = Bench::new();
    bench.feed(&Bench::reading(0.004, 0.8, 2.0), 0.1, true);
    assert!(bench.alarm.standing().is_some());
    let (t, _) = bench
        .feed(&Bench::reading(0.02, 0.8, 2.0), 1.0, true)
        .expect("released");
    assert!((0.24..0.27).contains(&t), "{t}");
    // A model that claims impossible growth is no reason for one.
    assert_eq!(
        Bench::new().feed(&Bench::reading(-0.05, 0.8, 2.0), 1.0, true),
        None
    );
}

#[test]
fn a_falling_damping_warns_before_the_threshold() {
    let mut bench = Bench::new();
    let mut warned_at = None;
    for k in 0..500 {
        let zeta = 0.05 - 0.1 * f64::from(k) * PERIOD_S;
        let reading = Bench::reading(zeta, 0.5, 1.0);
        let mode = bench
            .track
            .update(&reading, &AlarmConfig::default(), PERIOD_S);
        let modes = [Some(mode)];
        if warned_at.is_none()
            && bench.alarm.judge(&modes, &[true], true).1 == Reason::LosingDamping
        {
            warned_at = Some(zeta);
        }
    }
    let zeta = warned_at.expect("a warning");
    assert!((0.02..0.04).contains(&zeta), "warned at {zeta}");
}
