//! Whole ball bar tests on simulated machines, evaluated as the commands do it.

use rarma_plants::ldbb::drive::{Recorded, Test, Trouble, circles};
use rarma_plants::ldbb::{AirConfig, Around, BenchConfig, GaugeConfig, Geometry, MachineConfig};
use rarma_recordings::input::RunData;
use rarma_rigs::ldbb::{ForceLaw, ProcedureConfig, Schedule, ValveConfig};
use rarma_scenarios::ldbb::{Findings, Options, evaluate, from_recorded};

/// The eight pressures of the thesis, Pa.
pub const PRESSURES_PA: [f32; 8] = [4e4, 1e5, 2e5, 3e5, 4e5, 5e5, 6e5, 7e5];

/// Machine M3 of the thesis: 10.3 N/µm at 207° to 13.4 N/µm at 120.2°, mean 11.8, with
/// geometric errors.
pub fn m3() -> BenchConfig {
    let deg = f64::to_radians;
    let stiffness = Around::through(11.8e6, (13.4e6, deg(120.2)), (10.3e6, deg(207.0)))
        .expect("the figures of the thesis belong together");
    BenchConfig {
        machine: MachineConfig {
            geometry: Geometry {
                centre_m: [12e-6, -9e-6],
                scale: [20e-6, -10e-6],
                squareness_rad: 20e-6,
                bow_m: [2e-6, -1e-6],
                backlash_m: [1e-6, 1.5e-6],
                ..Geometry::default()
            },
            stiffness_n_per_m: stiffness,
            ..MachineConfig::ideal(11.8e6)
        },
        air: AirConfig::default(),
        gauge: GaugeConfig::default(),
        inclination_rad: 0.0,
        seed: 1,
    }
}

/// A circle at this feed, mm/min.
pub fn at_feed(mm_min: f32) -> ProcedureConfig {
    let feed_m_s = mm_min / 6e4;
    let config = ProcedureConfig::default();
    ProcedureConfig {
        feed_m_s,
        lead_s: config.trigger_m / feed_m_s + 0.5,
        ..config
    }
}

/// A whole test.
pub fn test(bench: BenchConfig, config: ProcedureConfig, both: bool, down: bool) -> Test {
    let schedule = Schedule::new(&PRESSURES_PA, both, down).expect("rising");
    circles(
        bench,
        config,
        ValveConfig::default(),
        schedule,
        &Trouble::default(),
    )
    .expect("sound settings")
}

/// Runs cut to their captures, forces by the standard law.
pub fn runs(recorded: &[Recorded], config: &ProcedureConfig, inclination_rad: f64) -> Vec<RunData> {
    recorded
        .iter()
        .map(|r| {
            from_recorded(
                r,
                &ForceLaw::standard(),
                f64::from(config.overshoot_rad),
                inclination_rad,
            )
        })
        .collect()
}

/// A whole test and its findings.
pub fn found(bench: BenchConfig, config: ProcedureConfig, both: bool, down: bool) -> Findings {
    let test = test(bench, config, both, down);
    assert_eq!(test.fault, None);
    let runs = runs(&test.runs, &config, bench.inclination_rad);
    let options = Options {
        radius_m: f64::from(config.radius_m),
        feed_m_s: f64::from(config.feed_m_s),
        bar_m_per_n: bench.gauge.bar_m_per_n,
        ..Options::default()
    };
    evaluate(&runs, &[], &options).expect("a whole test")
}
