use super::*;
use crate::condition::Band;
use crate::decide::State;
use crate::monitor::{MonitorConfig, MonitorError};
use crate::order::Order;

const FS: f64 = 8000.0;

/// Uniform noise of −1 to 1.
fn noise(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*seed >> 8) / 8_388_608.0 - 1.0
}

/// A mode at `f` Hz under noise, damped by 5 % up to `onset` s and by 0.05 % from
/// there on. The force stays as it is, so that the vibration grows.
fn mode(f: f64, onset: f64, seed: u32) -> impl FnMut(usize) -> f32 {
    let (mut seed, mut y1, mut y2) = (seed, 0.0, 0.0);
    move |n| {
        let zeta: f64 = if (n as f64) < onset * FS { 0.05 } else { 5e-4 };
        let w = core::f64::consts::TAU * f / FS;
        let r = (-zeta * w).exp();
        let y = 2.0 * r * w.cos() * y1 - r * r * y2 + noise(&mut seed) * 0.1;
        (y2, y1) = (y1, y);
        y as f32
    }
}

fn monitor() -> MonitorConfig {
    MonitorConfig {
        order: Order::O43,
        full_scale: Some(100.0),
        ..MonitorConfig::new(FS)
    }
}

fn pair(config: &PairConfig) -> PairMonitor<f32> {
    PairMonitor::new(config).unwrap()
}

/// Calls and releases of a run, in seconds; they must take turns.
fn alarms(
    pair: &mut PairMonitor<f32>,
    seconds: f64,
    mut x: impl FnMut(usize) -> [Option<f32>; 2],
    mut look: impl FnMut(f64, &PairReport<f32>),
) -> Vec<(bool, f64)> {
    let mut said: Vec<(bool, f64)> = Vec::new();
    for n in 0..(seconds * FS) as usize {
        let Some(report) = pair.push_some(x(n)) else {
            continue;
        };
        let t = n as f64 / FS;
        let on = match report.report.event {
            AlarmEvent::None => {
                let stands = said.last().is_some_and(|(on, _)| *on);
                assert_eq!(stands, report.report.standing.is_some(), "at {t} s");
                look(t, &report);
                continue;
            }
            AlarmEvent::On { .. } => true,
            AlarmEvent::Off { .. } => false,
        };
        assert_eq!(
            on,
            said.last().is_none_or(|(on, _)| !on),
            "doubled at {t} s"
        );
        said.push((on, t));
        look(t, &report);
    }
    said
}

#[test]
fn settings_are_checked() {
    let good = PairConfig::new(monitor());
    assert_eq!(good.check(), Ok(()));
    let mut bad = good;
    bad.channels[1].threshold = 1.0;
    let wanted = PairError::Channel(1, MonitorError::Threshold);
    assert_eq!(bad.check(), Err(wanted));
    assert_eq!(PairMonitor::<f32>::new(&bad).unwrap_err(), wanted);
    let mut bad = good;
    bad.channels[1].fs_hz = 9000.0;
    assert_eq!(bad.check(), Err(PairError::Rates));
    let hears = |low_hz, high_hz| PairConfig {
        hears: [None, Some(Band { low_hz, high_hz })],
        ..good
    };
    assert_eq!(hears(100.0, 500.0).check(), Ok(()));
    assert_eq!(hears(500.0, 500.0).check(), Err(PairError::Hears));
    assert_eq!(hears(f64::NAN, 500.0).check(), Err(PairError::Hears));
    for (alone_confirmations, wanted) in [
        (f64::INFINITY, Ok(())),
        (0.9, Err(PairError::Alone)),
        (f64::NAN, Err(PairError::Alone)),
    ] {
        let config = PairConfig {
            alone_confirmations,
            ..good
        };
        assert_eq!(config.check(), wanted);
    }
}

#[test]
fn two_that_agree_call_as_one_and_one_alone_later() {
    let run = |config: &PairConfig, second: bool, seed: u32| {
        let (mut both, mut other) = (mode(900.0, 1.0, seed), mode(1500.0, 9.0, seed + 50));
        let mut last = None;
        let said = alarms(
            &mut pair(config),
            2.0,
            |n| {
                let (x, y) = (both(n), other(n));
                [Some(x), Some(if second { -0.1 * x } else { y })]
            },
            |_, report| last = Some(report.agreement),
        );
        (said.first().map(|(_, t)| *t), last.unwrap())
    };
    let config = PairConfig::new(monitor());
    let deaf = PairConfig {
        hears: [
            None,
            Some(Band {
                low_hz: 1200.0,
                high_hz: 2500.0,
            }),
        ],
        ..config
    };
    let strict = PairConfig {
        alone_confirmations: f64::INFINITY,
        ..config
    };
    for seed in 1..=8 {
        let mut single = Monitor::<f32>::new(&monitor()).unwrap();
        let mut signal = mode(900.0, 1.0, seed);
        let alone = (0..16_000)
            .find(|&n| {
                let report = single.push(signal(n));
                report.is_some_and(|r| matches!(r.event, AlarmEvent::On { .. }))
            })
            .unwrap() as f64
            / FS;
        // Later, where one is sure before the other, by one confirmation at most.
        let (both, agreement) = run(&config, true, seed);
        assert_eq!(agreement, Agreement::Both);
        let gain = alone - both.unwrap();
        assert!((-0.065..0.06).contains(&gain), "{gain} s sooner");
        // The other hears something else: once more the time of the confirmation.
        let (first, agreement) = run(&config, false, seed);
        assert_eq!(agreement, Agreement::OnlyFirst);
        let loss = first.unwrap() - alone;
        assert!((0.055..0.075).contains(&loss), "{loss} s later");
        // Both must call it, and one never does.
        let (never, _) = run(&strict, false, seed);
        assert_eq!(never, None);
        // It cannot hear the mode: it is not waited for.
        let (first, _) = run(&deaf, false, seed);
        assert!((first.unwrap() - alone).abs() < 0.003, "{first:?} {alone}");
    }
}

#[test]
fn lost_samples_drop_a_channel_and_the_other_goes_on() {
    for lost in 0..2 {
        let mut signal = mode(900.0, 1.5, 3);
        let mut dropped: Vec<(f64, Option<Dropped>)> = Vec::new();
        let said = alarms(
            &mut pair(&PairConfig::new(monitor())),
            4.0,
            |n| {
                let x = signal(n);
                let mut both = [Some(x), Some(0.5 * x)];
                if (8000..16_000).contains(&n) {
                    both[lost] = None;
                }
                both
            },
            |t, report| {
                if dropped
                    .last()
                    .is_none_or(|(_, d)| *d != report.dropped[lost])
                {
                    dropped.push((t, report.dropped[lost]));
                }
                if report.dropped[lost].is_some() {
                    assert_eq!(report.agreement, Agreement::Single, "{t}");
                }
                assert_eq!(report.dropped[1 - lost], None, "{t}");
            },
        );
        // Called while it was away, and only once.
        let [(true, on)] = said[..] else {
            panic!("{said:?}");
        };
        assert!((1.5..2.0).contains(&on), "{on}");
        let missing = Dropped {
            channel: lost as u8,
            fault: ChannelFault::Samples(Fault::Missing),
        };
        let [(_, None), (gone, Some(why)), (back, None)] = dropped[..] else {
            panic!("{dropped:?}");
        };
        assert_eq!(why, missing);
        // Back after its last fault, the hold of the health room, and a second.
        assert!((1.0..1.005).contains(&gone), "{gone}");
        assert!((3.09..3.12).contains(&back), "{back}");
    }
}

#[test]
fn both_sick_is_invalid_and_the_alarm_does_not_outlive_it_for_long() {
    let mut signal = mode(900.0, 0.5, 4);
    let mut invalid = 0;
    let said = alarms(
        &mut pair(&PairConfig::new(monitor())),
        4.0,
        |n| {
            let x = signal(n);
            let x = if n < 16_000 { x } else { f32::NAN };
            [Some(x); 2]
        },
        |t, report| {
            if t > 2.01 {
                assert_eq!(report.report.state, State::Invalid, "{t}");
                invalid += 1;
            }
            let finite = report.report.modes.iter().flatten().all(|m| {
                m.frequency.is_finite() && m.damping.is_finite() && m.amplitude.is_finite()
            });
            assert!(finite && report.report.level.is_finite(), "{t}");
        },
    );
    let [(true, on), (false, off)] = said[..] else {
        panic!("{said:?}");
    };
    assert!(
        (0.5..1.2).contains(&on) && (3.0..3.02).contains(&off),
        "{said:?}"
    );
    assert!(invalid > 900, "{invalid}");
}

#[test]
fn deterministic() {
    let run = || {
        let (mut a, mut b) = (mode(900.0, 1.0, 5), mode(1300.0, 0.7, 6));
        let mut pair = pair(&PairConfig::new(monitor()));
        let reports: Vec<_> = (0..12_000)
            .filter_map(|n| pair.push([a(n), b(n)]))
            .collect();
        format!("{reports:?}")
    };
    assert_eq!(run(), run());
}
