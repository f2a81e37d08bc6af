//! Promise: turning has the closed-form limit, by three methods, and grows beside it as
//! its root says.
//!
//! `cargo test --release -p host-tests --test turning_limits -- --nocapture`

use rarma_plants::cut::Process;
use rarma_plants::delay::{DepthSearch, limit, turning_delay, turning_roots};
use rarma_plants::process::{Contact, ForceNoise, Schedule};
use rarma_plants::stability::{turning_limit, turning_lobe_hz};
use rarma_plants::turning::{Turning, TurningConfig};
use rarma_scenarios::scenario;

/// Amplitude of the fourth quarter over that of the second, 0.8 s: own reference,
/// another program.
const GROWTH: [(f64, f64); 4] = [(0.90, 0.05), (0.97, 0.42), (1.03, 2.3), (1.10, 15.0)];
const SECONDS: f64 = 0.8;

fn lathe() -> TurningConfig {
    let shipped = scenario::load("turning-980", None)
        .expect("shipped")
        .scenario;
    let Process::Turning(config) = shipped.process else {
        panic!("a turning cut")
    };
    TurningConfig {
        spindle_hz: turning_lobe_hz(&config.modes[0], 5),
        variation: None,
        feed_m: 0.0,
        noise: ForceNoise::default(),
        contact: Contact::Linear,
        min_step_rate_hz: 400_000.0,
        ..*config
    }
}

fn rms(y: &[f64]) -> f64 {
    (y.iter().map(|v| v * v).sum::<f64>() / y.len() as f64).sqrt()
}

/// Fourth quarter over second, in time.
fn growth(width_m: f64) -> f64 {
    let mut machine = Turning::new(TurningConfig {
        width: Schedule::constant(width_m),
        ..lathe()
    })
    .expect("valid");
    machine.disturb(0, 1e-7, 0.0);
    let n = (SECONDS / machine.dt()) as usize;
    let q: Vec<f64> = (0..n).map(|_| machine.step().position_m).collect();
    rms(&q[3 * n / 4..]) / rms(&q[n / 4..n / 2])
}

#[test]
fn limit_frequency_and_growth() {
    let config = lathe();
    let closed = turning_limit(&config.modes[0], config.ks_n_per_m2);
    let search = DepthSearch::between(0.1e-3, 0.5e-3);
    let stepped = limit(&search, |b| turning_delay(&config, b, 100.0)).expect("a limit");
    let exact = turning_roots(&config, closed.depth_m, 1).expect("a root")[0];
    let (mut low, mut high) = (0.9 * closed.depth_m, 1.1 * closed.depth_m);
    while high - low > 1e-3 * high {
        let middle = 0.5 * (low + high);
        if growth(middle) < 1.0 {
            low = middle
        } else {
            high = middle
        }
    }
    println!(
        "speed of lobe 5: {:.1} 1/min (10 422.9)",
        60.0 * config.spindle_hz
    );
    println!(
        "limit mm: closed form {:.4} (0.2407), semi-discretisation {:.4}, in time {:.4}; at {:.1}, {:.1}, {:.1} Hz (999.4)",
        1e3 * closed.depth_m,
        1e3 * stepped.depth_m,
        5e2 * (low + high),
        closed.chatter_hz,
        stepped.root.f_hz,
        exact.f_hz
    );
    assert!((60.0 * config.spindle_hz - 10_422.9).abs() < 0.5);
    assert!(
        (closed.depth_m * 1e3 - 0.2407).abs() < 5e-5 && (closed.chatter_hz - 999.4).abs() < 0.1
    );
    assert!((stepped.depth_m / closed.depth_m - 1.0).abs() < 1e-3);
    assert!((stepped.root.f_hz - 999.4).abs() < 0.2 && exact.growth_per_s.abs() < 1e-3);
    assert!((0.5 * (low + high) / closed.depth_m - 1.0).abs() < 2e-3);
    println!("part of limit   reference   in time   by the root");
    for (part, want) in GROWTH {
        let width = part * closed.depth_m;
        let in_time = growth(width);
        let root = turning_roots(&config, width, 1).expect("a root")[0];
        let by_root = (0.5 * SECONDS * root.growth_per_s).exp();
        println!("     {part:.2}         {want:7.2}   {in_time:7.3}   {by_root:7.3}");
        assert!((in_time / want - 1.0).abs() < 0.12, "{part}: {in_time}");
        // The root alone: the start still holds others, and quarters are not points.
        assert!((by_root / want - 1.0).abs() < 0.15, "{part}: {by_root}");
    }
}
