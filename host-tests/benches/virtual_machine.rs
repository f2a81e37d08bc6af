//! How fast the virtual machine cuts on one core: simulated seconds per second, the
//! best of several runs (others may use the machine).
//!
//! `cargo bench -p host-tests --bench virtual_machine`

use rarma_plants::cut::{Process, Scenario, VirtualCut};
use rarma_plants::milling::MillingConfig;
use rarma_plants::modal::Mode;
use rarma_plants::process::{ForceNoise, Schedule};
use rarma_scenarios::scenario;
use std::time::Instant;

const RUNS: usize = 5;

/// Simulated seconds per second, and nanoseconds per step.
fn speed(scenario: &Scenario) -> (f64, f64) {
    let rate = match &scenario.process {
        Process::Milling(c) => c.min_step_rate_hz,
        Process::Turning(c) => c.min_step_rate_hz,
    };
    let best = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            let sum: i64 = VirtualCut::new(scenario)
                .expect("valid")
                .map(|r| i64::from(r.code))
                .sum();
            std::hint::black_box(sum);
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    (
        scenario.duration_s / best,
        1e9 * best / (scenario.duration_s * rate),
    )
}

fn milling(change: impl FnOnce(&mut MillingConfig)) -> Scenario {
    let base = scenario::load("three-mode-chatter", Some(1))
        .expect("shipped")
        .scenario;
    let Process::Milling(mut config) = base.process else {
        panic!("a milling cut")
    };
    config.depth = Schedule::constant(1e-3);
    change(&mut config);
    Scenario {
        process: Process::Milling(config),
        duration_s: 1.0,
        ..base
    }
}

fn main() {
    let show = |what: &str, scenario: &Scenario| {
        let (ratio, ns) = speed(scenario);
        println!("{what:44} {ratio:8.1}  {ns:8.0}");
    };
    println!(
        "{:44} {:>8}  {:>8}",
        "48 kHz output, one core", "s per s", "ns/step"
    );
    for (name, _) in scenario::SHIPPED {
        show(
            name,
            &scenario::load(name, Some(1)).expect("shipped").scenario,
        );
    }
    for rate in [49_000.0, 98_000.0, 196_000.0, 392_000.0] {
        let s = milling(|c| c.min_step_rate_hz = rate);
        show(&format!("three modes, three teeth, {rate:.0} steps/s"), &s);
    }
    for modes in [1, 3, 6, 12] {
        let s = milling(|c| {
            c.modes_other.clear();
            c.modes_y.clear();
            c.modes_x = (0..modes)
                .map(|i| Mode::from_stiffness(400.0 + 100.0 * f64::from(i), 0.02, 5e7))
                .collect();
        });
        show(&format!("{modes} modes, three teeth, 98000 steps/s"), &s);
    }
    for teeth in [1, 3, 6, 12] {
        let s = milling(|c| c.teeth = teeth);
        show(&format!("three modes, {teeth} teeth, 98000 steps/s"), &s);
    }
    for degrees in [0.0, 15.0, 30.0, 45.0] {
        let s = milling(|c| {
            c.depth = Schedule::constant(5e-3);
            c.helix_rad = f64::to_radians(degrees);
        });
        show(
            &format!("helix {degrees} degrees over 5 mm, 98000 steps/s"),
            &s,
        );
    }
    let s = milling(|c| c.noise = ForceNoise::default());
    show("three modes, three teeth, no force noise", &s);
}
