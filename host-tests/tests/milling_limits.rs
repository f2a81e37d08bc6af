//! Promise: the limits of the published two-tooth benchmark come out of three
//! methods that share nothing but the equation: semi-discretisation, the time
//! simulation, and (where it is valid) the zero-order solution.
//!
//! `cargo test --release -p host-tests --test milling_limits -- --nocapture` prints
//! the table.

use core::f64::consts::TAU;
use rarma_plants::delay::{Border, Crossing, DepthSearch, limit, milling_delay};
use rarma_plants::growth::milling_limit_in_time;
use rarma_plants::milling::{Engagement, MillingConfig};
use rarma_plants::modal::Mode;
use rarma_plants::stability::milling_limit;

const RPM: [f64; 4] = [6e3, 10e3, 15e3, 20e3];

/// Lowest limit in mm at the speeds of [`RPM`], and how stability is lost there:
/// own semi-discretisation of the same data by another program, extrapolated.
const REFERENCE: [(&str, [(f64, char); 4]); 8] = [
    (
        "x, slot",
        [(0.353, 'H'), (0.322, 'H'), (0.387, 'H'), (1.418, 'F')],
    ),
    (
        "x, a=0.5 down",
        [(1.139, 'H'), (2.103, 'F'), (2.596, 'F'), (0.719, 'H')],
    ),
    (
        "x, a=0.5 up",
        [(0.228, 'H'), (0.2135, 'H'), (0.259, 'H'), (1.185, 'H')],
    ),
    (
        "x, a=0.05 down",
        [(3.074, 'H'), (4.091, 'F'), (8.215, 'F'), (2.301, 'H')],
    ),
    (
        "x, a=0.05 up",
        [(1.832, 'H'), (1.658, 'H'), (1.888, 'H'), (3.763, 'F')],
    ),
    (
        "xy, slot",
        [(0.0483, 'H'), (0.0714, 'H'), (0.1144, 'H'), (0.0632, 'H')],
    ),
    (
        "xy, a=0.5",
        [(0.1274, 'H'), (0.1810, 'H'), (0.2818, 'H'), (0.1762, 'H')],
    ),
    (
        "xy, a=0.05",
        [(1.536, 'H'), (1.487, 'H'), (1.651, 'H'), (3.248, 'F')],
    ),
];

fn machine(row: usize, rpm: f64) -> MillingConfig {
    let mode = Mode::from_mass(922.0, 0.011, 0.03993);
    let engagement = match row {
        0 | 5 => Engagement::SLOT,
        1 => Engagement::down(0.5),
        2 | 6 => Engagement::up(0.5),
        3 => Engagement::down(0.05),
        _ => Engagement::up(0.05),
    };
    MillingConfig {
        engagement,
        spindle_hz: rpm / 60.0,
        modes_x: vec![mode],
        modes_y: if row < 5 { Vec::new() } else { vec![mode] },
        ..MillingConfig::default()
    }
}

fn border(config: &MillingConfig, around_m: f64, steps: f64) -> Border {
    let search = DepthSearch::between(0.3 * around_m, 2.0 * around_m);
    limit(&search, |b| milling_delay(config, b, steps)).expect("a limit in the range")
}

/// The error falls with the square of the step.
fn extrapolated(coarse: f64, fine: f64) -> f64 {
    fine + (fine - coarse) / 3.0
}

#[test]
fn thirty_two_limits() {
    println!(
        "case             rpm   reference  50 steps  100 steps  extrap.  diff    time sim. diff   chatter"
    );
    let (mut worst, mut worst_time) = (0.0_f64, 0.0_f64);
    for (row, (name, references)) in REFERENCE.iter().enumerate() {
        for (rpm, (reference, letter)) in RPM.iter().zip(references) {
            let config = machine(row, *rpm);
            let around = reference * 1e-3;
            let (coarse, fine) = (
                border(&config, around, 50.0),
                border(&config, around, 100.0),
            );
            let ours = extrapolated(coarse.depth_m, fine.depth_m) * 1e3;
            let in_time = milling_limit_in_time(&config, 0.85 * around, 1.15 * around, 0.6, 2e-3)
                .expect("a limit in the bracket")
                * 1e3;
            let (error, error_time) = (ours / reference - 1.0, in_time / reference - 1.0);
            println!(
                "{name:15} {rpm:6} {reference:8.4} {letter} {:9.4} {:9.4} {ours:9.4} {} {:+5.2} % {in_time:9.4} {:+5.2} % {:7.1} Hz",
                coarse.depth_m * 1e3,
                fine.depth_m * 1e3,
                fine.crossing.letter(),
                100.0 * error,
                100.0 * error_time,
                fine.root.f_hz,
            );
            assert_eq!(fine.crossing.letter(), *letter, "{name} {rpm}");
            assert!(
                (fine.depth_m / coarse.depth_m - 1.0).abs() < 0.012,
                "{name} {rpm}: not converged"
            );
            worst = worst.max(error.abs());
            worst_time = worst_time.max(error_time.abs());
        }
    }
    println!(
        "worst: {:.2} % and {:.2} %",
        100.0 * worst,
        100.0 * worst_time
    );
    assert!(worst < 0.01, "semi-discretisation: {worst}");
    assert!(worst_time < 0.05, "time simulation: {worst_time}");
    assert!(worst > 1e-6, "too good to be an independent computation");
}

/// A helix that lags by a whole pitch over the depth makes the cutting force
/// constant in time: the delay equation then *is* the zero-order one, and its limit
/// must be the zero-order limit without any of the zero-order formulas.
#[test]
fn zero_order_limits_of_the_slot() {
    println!("rpm     zero-order  by the delay equation of the mean force   printed elsewhere");
    for (rpm, elsewhere) in RPM.iter().zip([0.0491, 0.0720, 0.1143, 0.0620]) {
        let config = machine(5, *rpm);
        let zero_order = milling_limit(&config).expect("limit").depth_m;
        let helical = |b: f64| MillingConfig {
            // The lag over b is 2b·tan β/D = π, one pitch of two teeth.
            diameter_m: 4.0 * b,
            helix_rad: TAU.atan(),
            ..config.clone()
        };
        let at = |steps: f64| {
            let search = DepthSearch::between(0.5 * zero_order, 2.0 * zero_order);
            limit(&search, |b| milling_delay(&helical(b), b, steps)).expect("limit")
        };
        let (coarse, fine) = (at(50.0), at(100.0));
        let mean = extrapolated(coarse.depth_m, fine.depth_m);
        println!(
            "{rpm:6}  {:.5} mm  {:.5} mm at {:.1} Hz (with {} steps {:.5})   {elsewhere} mm",
            zero_order * 1e3,
            mean * 1e3,
            fine.root.f_hz,
            50,
            coarse.depth_m * 1e3
        );
        assert_eq!(fine.crossing, Crossing::Hopf);
        assert!(
            (mean / zero_order - 1.0).abs() < 1e-3,
            "{rpm}: {mean} {zero_order}"
        );
        // The figures printed elsewhere are up to 2.4 % lower, and not reproduced.
        let gap = zero_order * 1e3 / elsewhere - 1.0;
        assert!((0.005..0.03).contains(&gap), "{rpm}: {gap}");
    }
}
