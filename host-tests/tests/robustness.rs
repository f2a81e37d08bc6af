//! Promise: whatever the input, the monitor never panics, never reports a number
//! that is none, names what is wrong, and finds the mode again within seconds of
//! good signal; in single precision its covariance stays positive definite.

use host_tests::signal;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rarma_core::Order;
use rarma_core::condition::Fault;
use rarma_core::decide::{AlarmEvent, Mode, Reason, State};
use rarma_core::monitor::{Monitor, MonitorConfig, Report};
use std::f64::consts::TAU;

const FS: f64 = 8000.0;
const F: f64 = 900.0;

/// Every number of a report, and whether all are numbers.
fn finite(report: &Report<f32>) -> bool {
    let modes = report.modes.iter().flatten().all(|m| {
        [
            m.frequency,
            m.frequency_sd,
            m.damping,
            m.damping_sd,
            m.amplitude,
            m.share,
            m.gradient,
        ]
        .iter()
        .all(|x| x.is_finite())
    });
    let event = match report.event {
        AlarmEvent::None => true,
        AlarmEvent::On { frequency, damping } => frequency.is_finite() && damping.is_finite(),
        AlarmEvent::Off {
            frequency,
            lowest_damping,
        } => frequency.is_finite() && lowest_damping.is_finite(),
    };
    let standing = report
        .standing
        .is_none_or(|(f, z)| f.is_finite() && z.is_finite());
    modes && event && standing && report.level.is_finite()
}

/// Three seconds of a good signal: a resonator of 900 Hz and 2 % under noise.
fn good(seed: u64) -> impl Iterator<Item = f32> {
    signal::modes(&[(F, 0.02)], FS, seed)
        .map(|x| (0.1 * x) as f32)
        .take(3 * FS as usize)
}

/// The samples are trusted and the modes are read, whatever is made of them: after
/// something loud a good signal may well be called idle.
fn judged(state: State) -> bool {
    state != State::Invalid && state != State::Starting
}

/// Part of the reports of the last second in which the mode is there.
fn found(reports: &[Report<f32>]) -> f64 {
    let second = &reports[reports.len() - 500..];
    let there = |r: &&Report<f32>| {
        let near =
            |m: &Mode<f32>| (f64::from(m.frequency) - F).abs() < 30.0 && m.damping.abs() < 0.06;
        judged(r.state) && r.modes.iter().flatten().any(near)
    };
    second.iter().filter(there).count() as f64 / second.len() as f64
}

/// A stretch of hostile input.
#[derive(Debug, Clone)]
enum Hostile {
    Constant(f32),
    Alternating(f32),
    Square(f32, usize),
    Noise(f32, u64),
    Burst(f32),
    Ramp(f32),
    Mixed(u64),
}

impl Hostile {
    fn samples(&self, n: usize) -> Vec<f32> {
        let every = |f: &dyn Fn(usize) -> f32| (0..n).map(f).collect();
        match *self {
            Self::Constant(x) => vec![x; n],
            Self::Alternating(x) => every(&|i| if i % 2 == 0 { x } else { -x }),
            Self::Square(x, half) => every(&|i| if i / half % 2 == 0 { x } else { -x }),
            Self::Noise(scale, seed) => signal::white(seed)
                .map(|x| x as f32 * scale)
                .take(n)
                .collect(),
            Self::Burst(x) => every(&|i| if i % 500 < 3 { x } else { 0.0 }),
            Self::Ramp(x) => every(&|i| x * i as f32),
            Self::Mixed(seed) => signal::white(seed)
                .map(|x| match (x * 1000.0) as i32 % 5 {
                    0 => f32::NAN,
                    1 => f32::INFINITY,
                    2 => f32::from_bits((x * 1e9) as i32 as u32).clamp(-10.0, 10.0),
                    _ => x as f32,
                })
                .take(n)
                .collect(),
        }
    }
}

/// Values a sample may have: none at all, too small ones, and full scale.
fn value() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(f32::NEG_INFINITY),
        Just(1e-40),
        Just(f32::MIN_POSITIVE),
        Just(0.0),
        Just(1.0),
        Just(-1.0),
        -10.0f32..10.0,
    ]
}

/// Values whose square is beyond single precision, though they are not: no
/// converter gives them, a broken float recording may.
fn huge() -> impl Strategy<Value = f32> + Clone {
    prop_oneof![
        Just(1e20f32),
        Just(1e30),
        Just(-1e30),
        Just(f32::MAX),
        Just(f32::MIN)
    ]
}

fn hostile(
    value: impl Strategy<Value = f32> + Clone + 'static,
) -> impl Strategy<Value = (Hostile, usize)> {
    let kind = prop_oneof![
        value.clone().prop_map(Hostile::Constant),
        value.clone().prop_map(Hostile::Alternating),
        (value.clone(), 2usize..200).prop_map(|(x, half)| Hostile::Square(x, half)),
        (value.clone(), any::<u64>()).prop_map(|(x, seed)| Hostile::Noise(x, seed)),
        value.clone().prop_map(Hostile::Burst),
        value.clone().prop_map(Hostile::Ramp),
        any::<u64>().prop_map(Hostile::Mixed),
    ];
    (kind, 1usize..4000)
}

/// Hostile input, then good signal: every number is one, and the mode is there.
fn survives(
    parts: &[(Hostile, usize)],
    config: &MonitorConfig,
    missing: u32,
    seed: u64,
) -> Result<(), TestCaseError> {
    let mut monitor = Monitor::<f32>::new(config).expect("settings in range");
    for (part, n) in parts {
        for x in part.samples(*n) {
            if let Some(report) = monitor.push(x) {
                prop_assert!(finite(&report), "{part:?}: {report:?}");
            }
        }
        if missing > 0 {
            monitor.missing(missing);
        }
    }
    let mut reports = Vec::new();
    for x in good(seed) {
        if let Some(report) = monitor.push(x) {
            prop_assert!(finite(&report), "good signal: {report:?}");
            reports.push(report);
        }
    }
    let (share, last) = (found(&reports), reports.last());
    prop_assert!(
        share > 0.5,
        "the mode is there {share:.2} of the last second: {last:?}"
    );
    Ok(())
}

fn definite(parts: &[(Hostile, usize)]) -> Result<(), TestCaseError> {
    let mut monitor = Monitor::<f32>::new(&MonitorConfig::new(FS)).expect("settings in range");
    for (part, n) in parts {
        for x in part.samples(*n) {
            if monitor.push(x).is_some() {
                prop_assert!(monitor.model().is_definite(), "{part:?}");
            }
        }
    }
    Ok(())
}

fn config(order: usize, full_scale: Option<f64>) -> MonitorConfig {
    MonitorConfig {
        order: Order::ALL[order],
        full_scale,
        ..MonitorConfig::new(FS)
    }
}

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        // The same cases every time: a red test can be run again, a green one stays.
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(cases(128))]

    #[test]
    fn hostile_input_is_survived_and_the_mode_found_again(
        parts in proptest::collection::vec(hostile(value()), 1..7),
        full_scale in prop_oneof![Just(None), Just(Some(1.0))],
        order in 0usize..8,
        missing in 0u32..1000,
        seed in 0u64..1000,
    ) {
        survives(&parts, &config(order, full_scale), missing, seed)?;
    }

    #[test]
    fn covariance_stays_definite(parts in proptest::collection::vec(hostile(value()), 1..7)) {
        definite(&parts)?;
    }

    #[test]
    fn numbers_with_no_square_are_survived_and_the_mode_found_again(
        before in hostile(value()),
        bad in hostile(huge()),
        order in 0usize..8,
        seed in 0u64..1000,
    ) {
        survives(&[before, bad], &config(order, None), 0, seed)?;
    }

    #[test]
    fn covariance_stays_definite_under_numbers_with_no_square(
        before in hostile(value()),
        bad in hostile(huge()),
        after in hostile(value()),
    ) {
        definite(&[before, bad, after])?;
    }
}

/// Without anything hostile: what the others come back to.
#[test]
fn mode_is_found_at_every_order_whatever_the_seed() {
    let mut worst = 1.0f64;
    for (order, name) in Order::ALL.iter().enumerate() {
        let deaf = (0..40).filter(|&seed| {
            let mut monitor = Monitor::<f32>::new(&config(order, None)).unwrap();
            let reports: Vec<_> = good(seed).filter_map(|x| monitor.push(x)).collect();
            found(&reports) < 0.5
        });
        let deaf: Vec<u64> = deaf.collect();
        println!("{name:?}: the mode is not found for seeds {deaf:?} of 40");
        worst = worst.min(1.0 - deaf.len() as f64 / 40.0);
    }
    assert!(
        worst > 0.97,
        "at one order only {worst:.3} of the seeds find the mode"
    );
}

#[test]
fn what_is_wrong_is_named() {
    let mut monitor = Monitor::<f32>::new(&MonitorConfig {
        full_scale: Some(1.0),
        ..MonitorConfig::new(FS)
    })
    .unwrap();
    let mut last = |x: &mut dyn Iterator<Item = f32>| {
        let mut last = None;
        for x in x {
            last = monitor.push(x).or(last);
        }
        let report: Report<f32> = last.expect("a report");
        (report.state, report.reason)
    };
    assert_eq!(last(&mut good(1)), (State::Stable, Reason::None));
    let named = |fault| (State::Invalid, Reason::Samples(fault));
    let nan = last(&mut std::iter::repeat_n(f32::NAN, 40));
    assert_eq!(nan, named(Fault::NotFinite));
    assert!(judged(last(&mut good(2)).0));
    let stuck = last(&mut std::iter::repeat_n(0.3, 900));
    assert_eq!(stuck, named(Fault::Stuck));
    assert!(judged(last(&mut good(3)).0));
    let mut square = (0..800).map(|i| if i / 4 % 2 == 0 { 1.0 } else { -1.0 });
    assert_eq!(last(&mut square), named(Fault::Clipped));
    assert!(judged(last(&mut good(4)).0));
}

/// A first sample far off (a switch-on transient in a float recording) must not cost
/// the precision of everything after it.
#[test]
fn first_sample_far_off_does_not_deafen() {
    for first in [1e3f32, 1e6, 1e9] {
        let mut monitor = Monitor::<f32>::new(&MonitorConfig::new(FS)).unwrap();
        monitor.push(first);
        let reports: Vec<Report<f32>> = good(5).filter_map(|x| monitor.push(x)).collect();
        let level = reports.last().map_or(0.0, |r| r.level);
        assert!(
            (0.04..0.2).contains(&level),
            "after {first}: the band's level is {level}, not 0.1"
        );
        let share = found(&reports);
        assert!(
            share > 0.9,
            "after {first}: the mode is there {share:.2} of the last second"
        );
    }
}

/// Two million samples in single precision at the largest order, then good signal.
fn endures(name: &str, signal: impl Iterator<Item = f32>) {
    let mut monitor = Monitor::<f32>::new(&MonitorConfig::new(FS)).unwrap();
    let mut reports = 0;
    for x in signal.take(2_000_000) {
        if let Some(report) = monitor.push(x) {
            assert!(finite(&report), "{name}: {report:?}");
            assert!(monitor.model().is_definite(), "{name} at {}", report.sample);
            reports += 1;
        }
    }
    assert_eq!(reports, 2_000_000 / 16);
    let after: Vec<Report<f32>> = good(9).filter_map(|x| monitor.push(x)).collect();
    let share = found(&after);
    assert!(
        share > 0.9,
        "{name}: the mode is there {share:.2} of the last second"
    );
}

#[test]
fn two_million_samples_of_a_tone() {
    endures("tone", signal::tone(F, FS).map(|x| 0.5 * x as f32));
}

#[test]
fn two_million_samples_of_a_hardly_damped_mode() {
    let mode = signal::modes(&[(F, 0.0007)], FS, 2);
    endures("ζ = 0.07 %", mode.map(|x| 0.3 * x as f32));
}

#[test]
fn two_million_samples_of_silence_and_full_scale() {
    let signal = (0u64..).map(|n| {
        let loud = (n / 20_000) % 2 == 1;
        let square = if (n as f64 * F / FS).fract() < 0.5 {
            1.0
        } else {
            -1.0
        };
        if loud { square } else { 0.0 }
    });
    endures("silence and full scale", signal);
}

#[test]
fn two_million_samples_of_two_tones_and_their_beat() {
    let signal = (0u64..).map(|n| {
        let t = n as f64 / FS;
        (0.4 * ((TAU * 900.0 * t).sin() + (TAU * 903.0 * t).sin())) as f32
    });
    endures("beat", signal);
}
