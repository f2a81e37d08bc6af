//! Promise: a mode that loses its damping is called, one that keeps it is not, and
//! how long each takes is known. Run with `--nocapture` for the table.

use hal_sim::plant::modal_noise::{Drive, ModalNoise, ModalNoiseConfig, NoiseMode, Quantity};
use host_tests::statistics::quantile;
use rarma_core::decide::AlarmEvent;
use rarma_core::monitor::MonitorConfig;
use rarma_core::{AnyMonitor, Order};

const FS: f64 = 8000.0;
const SEEDS: u64 = 30;
/// The damping steps down at this time and back up at the next, s.
const DOWN_S: f64 = 5.0;
const UP_S: f64 = 8.0;
const END_S: f64 = 12.0;

/// A mode at 980 Hz with this damping beside one at 450 Hz, at 30 dB.
fn modes(zeta: f64) -> Vec<NoiseMode> {
    let mode = |f_hz, zeta, rms| NoiseMode { f_hz, zeta, rms };
    vec![mode(980.0, zeta, 1.0), mode(450.0, 0.04, 0.5)]
}

fn signal(zeta: f64, seed: u64) -> ModalNoise {
    ModalNoise::new(ModalNoiseConfig {
        fs_hz: FS,
        modes: modes(zeta),
        drive: Drive::Independent,
        quantity: Quantity::Displacement,
        snr_db: Some(30.0),
        seed,
    })
    .expect("valid")
}

fn monitor(order: Order) -> AnyMonitor<f32> {
    let config = MonitorConfig {
        order,
        ..MonitorConfig::new(FS)
    };
    AnyMonitor::new(&config).expect("settings in range")
}

/// Times of calls and releases while the damping goes 5 %, 0.1 %, 5 %.
fn step(order: Order, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let (mut signal, mut monitor) = (signal(0.05, seed), monitor(order));
    let (mut on, mut off) = (Vec::new(), Vec::new());
    for n in 0..(END_S * FS) as usize {
        let t = n as f64 / FS;
        if t == DOWN_S || t == UP_S {
            let zeta = if t == DOWN_S { 0.001 } else { 0.05 };
            signal.retune(&modes(zeta)).expect("valid");
        }
        if let Some(report) = monitor.push((0.05 * signal.next_sample()) as f32) {
            match report.event {
                AlarmEvent::On { .. } => on.push(t),
                AlarmEvent::Off { .. } => off.push(t),
                AlarmEvent::None => {}
            }
        }
    }
    (on, off)
}

#[test]
fn a_mode_that_loses_its_damping_is_called() {
    println!("| order | call, ms, median | 90 % | missed | release, ms, median | false calls |");
    println!("|---|---|---|---|---|---|");
    for order in [Order::O43, Order::O65, Order::O87] {
        let (mut lags, mut recoveries, mut missed, mut wrong) = (vec![], vec![], 0, 0);
        for seed in 0..SEEDS {
            let (on, off) = step(order, seed);
            match on.iter().find(|t| (DOWN_S..UP_S).contains(*t)) {
                Some(t) => lags.push(1e3 * (t - DOWN_S)),
                None => missed += 1,
            }
            if let Some(t) = off.iter().find(|t| **t > UP_S) {
                recoveries.push(1e3 * (t - UP_S));
            }
            // A third of a second after the step back the old vibration still rings.
            wrong += on
                .iter()
                .filter(|t| **t < DOWN_S || **t > UP_S + 0.33)
                .count();
        }
        let (median, most) = (quantile(&lags, 0.5), quantile(&lags, 0.9));
        println!(
            "| ({},{}) | {median:.0} | {most:.0} | {missed} of {SEEDS} | {:.0} | {wrong} |",
            order.p(),
            order.q(),
            quantile(&recoveries, 0.5)
        );
        assert_eq!((missed, wrong), (0, 0));
        assert!((50.0..350.0).contains(&median), "{median}");
        assert!((100.0..1000.0).contains(&most), "{most}");
    }
}

#[test]
fn a_mode_that_keeps_two_percent_is_not_called_in_ten_minutes() {
    for order in [Order::O43, Order::O65, Order::O87] {
        for seed in 100..110 {
            let (mut signal, mut monitor) = (signal(0.02, seed), monitor(order));
            for _ in 0..(60.0 * FS) as usize {
                let report = monitor.push((0.05 * signal.next_sample()) as f32);
                let called = report.is_some_and(|r| matches!(r.event, AlarmEvent::On { .. }));
                assert!(!called, "{order:?}, seed {seed}");
            }
        }
    }
}
