//! A monitor on samples: a cut that begins to chatter after three seconds, at a told speed.
//!
//! ```sh
//! cargo run --release -p rarma-core --example monitor
//! ```

use rarma_core::prelude::*;

const FS_HZ: f64 = 48_000.0;
const TURN_HZ: f64 = 27.6; // 1656 1/min
const TEETH: u32 = 6;
const CHATTER_HZ: f64 = 898.0;

fn main() {
    let config = MonitorConfig {
        order: Order::O43,
        spindle_hz: Some(TURN_HZ),
        teeth: Some(TEETH),
        full_scale: Some(1.0),
        ..MonitorConfig::new(FS_HZ)
    };
    let mut monitor = Monitor::<f32>::new(&config).expect("settings within their ranges");
    let mut seed = 1u32;
    let mut state = None;
    for n in 0..(6.0 * FS_HZ) as u64 {
        let t = n as f64 / FS_HZ;
        let Some(report) = monitor.push(sound(t, &mut seed) as f32) else {
            continue; // between two decisions
        };
        if state != Some(report.state) {
            println!("{t:6.3} s  {:?} ({:?})", report.state, report.reason);
            state = Some(report.state);
        }
        if let AlarmEvent::On { frequency, damping } = report.event {
            println!("{t:6.3} s  chatter at {frequency:.1} Hz, ζ {damping:.4}");
        }
    }
}

/// A second of idle, then a cut: noise, the teeth's line with its multiples, and from 3 s on a
/// vibration of its own that grows until the tool leaves the cut at each swing.
fn sound(t: f64, seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let noise = f64::from(*seed >> 8) / 8_388_608.0 - 1.0;
    if t < 1.0 {
        return 1e-4 * noise;
    }
    let angle = core::f64::consts::TAU * TURN_HZ * f64::from(TEETH) * t;
    let teeth: f64 = (1..=4)
        .map(|k| (f64::from(k) * angle).sin() / f64::from(k))
        .sum();
    let grown = if t < 3.0 {
        0.0
    } else {
        (3e-4 * (20.0 * (t - 3.0)).exp()).min(0.2)
    };
    0.002 * noise + 0.02 * teeth + grown * (core::f64::consts::TAU * CHATTER_HZ * t).sin()
}
