//! Promise: where nobody tells the speed, chatter is called by the speed that is heard, and the
//! lines of that speed are not; a comb that is heard before the cut does not stand against a told
//! speed.

use host_tests::watch::each;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_core::decide::AlarmEvent;
use rarma_core::monitor::{Monitor, MonitorConfig};
use std::f64::consts::TAU;

const FS_HZ: f64 = 8000.0;
const SECONDS: f64 = 8.0;
/// The tool enters; the vibration grows from then on, s.
const ENTRY_S: f64 = 1.5;
const GROWS_S: f64 = 4.0;
const SEEDS: u64 = 12;

/// Noise; from [`ENTRY_S`] on more of it, and the multiples of `spindle_hz`;
/// a vibration of `f_hz` from [`GROWS_S`] on, which grows within 0.2 s to `amplitude`.
struct Cut {
    spindle_hz: f64,
    f_hz: f64,
    amplitude: f64,
}

/// Alarms: when, s, and at which frequency, Hz.
fn alarms(cut: &Cut, seed: u64) -> Vec<(f64, f64)> {
    let mut monitor = Monitor::<f32>::new(&MonitorConfig::new(FS_HZ)).expect("in range");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let phases: Vec<f64> = (0..40).map(|_| rng.random_range(0.0..TAU)).collect();
    let mut called = Vec::new();
    for n in 0..(SECONDS * FS_HZ) as usize {
        let t_s = n as f64 / FS_HZ;
        let loud = if t_s < ENTRY_S { 0.005 } else { 0.02 };
        let mut x = loud * rng.random_range(-1.0..1.0);
        if t_s >= ENTRY_S {
            for (k, phase) in (1..).zip(&phases) {
                x += 0.02 * (TAU * f64::from(k) * cut.spindle_hz * t_s + phase).sin();
            }
        }
        let grown = ((t_s - GROWS_S) / 0.2).clamp(0.0, 1.0);
        x += grown * grown * cut.amplitude * (TAU * cut.f_hz * t_s).sin();
        let Some(report) = monitor.push(x as f32) else {
            continue;
        };
        if let AlarmEvent::On { frequency, .. } = report.event {
            called.push((t_s, f64::from(frequency)));
        }
    }
    called
}

#[test]
fn chatter_is_called_by_the_speed_that_is_heard() {
    let all = each((0..SEEDS).collect(), |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
        let spindle_hz = rng.random_range(30.0..90.0);
        // Off the multiples.
        let turns = f64::from(rng.random_range(10_u32..25)) + rng.random_range(0.3..0.7);
        let cut = Cut {
            spindle_hz,
            f_hz: spindle_hz * turns,
            amplitude: 0.3,
        };
        (cut.f_hz, alarms(&cut, seed))
    });
    for (f_hz, called) in &all {
        println!("{f_hz:.0} Hz: {called:?}");
        let [(called_s, called_hz), ..] = called[..] else {
            panic!("{f_hz} Hz is not called");
        };
        assert!((GROWS_S..GROWS_S + 1.0).contains(&called_s), "{called_s}");
        assert!((called_hz / f_hz - 1.0).abs() < 0.01, "{called_hz}, {f_hz}");
    }
}

#[test]
fn a_comb_alone_is_not_called() {
    let all = each((0..SEEDS).collect(), |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(2000 + seed);
        let cut = Cut {
            spindle_hz: rng.random_range(30.0..90.0),
            f_hz: 0.0,
            amplitude: 0.0,
        };
        alarms(&cut, seed)
    });
    for called in &all {
        assert!(called.is_empty(), "{called:?}");
    }
}

/// A pump turns 31 times a second before the tool enters, a spindle that was told with 60 cuts.
#[test]
fn what_was_heard_before_the_cut_does_not_stand_against_a_told_speed() {
    const PUMP_HZ: f64 = 31.0;
    const SPINDLE_HZ: f64 = 60.0;
    const ENTRY_S: f64 = 5.0;
    const CHATTER_S: f64 = 8.0;
    const CHATTER_HZ: f64 = 1230.0;
    let mut config = MonitorConfig::new(FS_HZ);
    config.spindle_hz = Some(SPINDLE_HZ);
    config.teeth = Some(4);
    for seed in 0..4 {
        let mut monitor = Monitor::<f32>::new(&config).expect("in range");
        let mut rng = ChaCha8Rng::seed_from_u64(3000 + seed);
        let phases: Vec<f64> = (0..40).map(|_| rng.random_range(0.0..TAU)).collect();
        let comb = |t_s: f64, hz: f64| -> f64 {
            let each = (1..).zip(&phases);
            each.map(|(k, phase)| (TAU * f64::from(k) * hz * t_s + phase).sin())
                .sum()
        };
        let (mut was_denied, mut called_s) = (false, None);
        for n in 0..(12.0 * FS_HZ) as usize {
            let t_s = n as f64 / FS_HZ;
            let mut x = 0.002 * rng.random_range(-1.0..1.0) + 0.001 * comb(t_s, PUMP_HZ);
            if t_s >= ENTRY_S {
                x += 0.02 * comb(t_s, SPINDLE_HZ) + 0.02 * rng.random_range(-1.0..1.0);
            }
            let grown = ((t_s - CHATTER_S) / 0.2).clamp(0.0, 1.0);
            x += grown * grown * 0.3 * (TAU * CHATTER_HZ * t_s).sin();
            let Some(report) = monitor.push(x as f32) else {
                continue;
            };
            if t_s < ENTRY_S {
                was_denied |= report.spindle.contradiction.is_some();
            } else if t_s > ENTRY_S + 1.0 {
                let spindle = report.spindle;
                assert!(spindle.contradiction.is_none(), "{t_s}: {spindle:?}");
            }
            if let AlarmEvent::On { .. } = report.event {
                called_s = called_s.or(Some(t_s));
            }
        }
        println!("denied before the cut: {was_denied}, called at {called_s:?} s");
        assert!(was_denied, "the pump was not heard: nothing was tried");
        let called_s = called_s.expect("the chatter is called");
        assert!(
            (CHATTER_S..CHATTER_S + 1.0).contains(&called_s),
            "{called_s}"
        );
    }
}
