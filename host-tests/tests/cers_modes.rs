//! Modes of the thesis' table 3 by the exciter, against the plant's truth: at rest and
//! turning, twenty seeds.
//!
//! `cargo test --release -p host-tests --test cers_modes -- --nocapture`

use hal_sim::exciter::calibrated;
use hal_sim::plant::cers::ExciterPlant;
use host_tests::exciter::{Line, drawing, drive, lag, plant, record, response};
use rarma_core::cers::LineSet;
use rarma_core::els::{AgreedMode, Complex, Reading, agreed, fit_modes};
use rayon::prelude::*;

const SEEDS: u64 = 20;
const BAND_HZ: (f64, f64) = (250.0, 3000.0);
/// Room for ten modes, 4n + 3.
const ROOM: usize = 44;

/// Modes on which rational functions of so many modes agree.
fn modes(lines: &[Line], tried: std::ops::RangeInclusive<usize>) -> Vec<AgreedMode<f64>> {
    let inside = |l: &&Line| (BAND_HZ.0..=BAND_HZ.1).contains(&l.f_hz);
    let f: Vec<f64> = lines.iter().filter(inside).map(|l| l.f_hz).collect();
    let g: Vec<Complex<f64>> = lines.iter().filter(inside).map(|l| l.receptance).collect();
    let mut readings = Vec::new();
    let mut fits = 0;
    for n in tried {
        if let Ok(fit) = fit_modes::<f64, ROOM>(&f, &g, n) {
            let sane = fit.modes().iter().filter(|m| m.zeta < 0.2);
            readings.extend(sane.map(|m| Reading {
                f_hz: m.f_hz,
                zeta: m.zeta,
                fit: fits,
            }));
            fits += 1;
        }
    }
    let mut out = Vec::new();
    agreed(&mut readings, fits, 0.01, |m| out.push(m));
    out
}

/// Errors of f and ζ in per cent, for every mode of the axis, one seed.
fn errors(axis: usize, spindle_hz: f64, seed: u64) -> Vec<Option<(f64, f64)>> {
    let config = plant();
    let drives = [
        drive(LineSet::Odd, spindle_hz),
        drive(LineSet::Even, spindle_hz),
    ];
    let r = record(&config, &drives, 0.2, 16, spindle_hz, seed);
    assert_eq!(r.limited, 0);
    let (laws, _) = calibrated(&config, &drawing(), 100 * seed).expect("calibrated");
    let bench = ExciterPlant::new(config.clone(), 0).expect("valid");
    let lines = response(
        &r,
        &laws[axis],
        &drives[axis],
        (axis, axis),
        |f| bench.sensors().displacement_response(f),
        Some(lag(&config)),
    );
    let truth = config.structure.at(spindle_hz);
    let (mine, tried) = if axis == 0 {
        (&truth[..7], 7..=9)
    } else {
        (&truth[7..], 5..=8)
    };
    let found = modes(&lines, tried);
    mine.iter()
        .map(|m| {
            found
                .iter()
                .map(|a| {
                    (
                        100.0 * (a.f_hz / m.mode.f_hz - 1.0),
                        100.0 * (a.zeta / m.mode.zeta - 1.0),
                    )
                })
                .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
                .filter(|e| e.0.abs() < 2.0)
        })
        .collect()
}

fn table(axis: usize, spindle_hz: f64) -> (f64, f64, usize) {
    let all: Vec<_> = (0..SEEDS)
        .into_par_iter()
        .map(|seed| errors(axis, spindle_hz, seed))
        .collect();
    let truth = plant().structure.at(spindle_hz);
    let (mut f_worst, mut z_worst, mut missing) = (0.0f64, 0.0f64, 0);
    for k in 0..all[0].len() {
        let m = truth[k + 7 * axis].mode;
        let seen: Vec<(f64, f64)> = all.iter().filter_map(|e| e[k]).collect();
        let rms = |of: fn(&(f64, f64)) -> f64| {
            (seen.iter().map(|e| of(e).powi(2)).sum::<f64>() / seen.len().max(1) as f64).sqrt()
        };
        let worst =
            |of: fn(&(f64, f64)) -> f64| seen.iter().map(|e| of(e).abs()).fold(0.0, f64::max);
        println!(
            "  {:7.1} Hz {:5.2} %: seen {:2}/{SEEDS}, f rms {:.3} % worst {:.3} %, ζ rms {:.2} % worst {:.2} %",
            m.f_hz,
            100.0 * m.zeta,
            seen.len(),
            rms(|e| e.0),
            worst(|e| e.0),
            rms(|e| e.1),
            worst(|e| e.1)
        );
        f_worst = f_worst.max(worst(|e| e.0));
        z_worst = z_worst.max(worst(|e| e.1));
        missing += SEEDS as usize - seen.len();
    }
    (f_worst, z_worst, missing)
}

#[test]
fn every_mode_is_found_at_rest_and_turning() {
    for (axis, spindle_hz) in [
        (0, 0.0),
        (1, 0.0),
        (0, 100.0),
        (1, 100.0),
        (0, 300.0),
        (1, 300.0),
    ] {
        let name = if axis == 0 { "X" } else { "Y" };
        println!("{name} at {:.0} rpm, 3.3 s:", 60.0 * spindle_hz);
        let (f, z, missing) = table(axis, spindle_hz);
        assert_eq!(missing, 0, "{name} {spindle_hz}");
        assert!(f < 0.3, "{name} {spindle_hz}: f off by {f} %");
        assert!(z < 5.0, "{name} {spindle_hz}: ζ off by {z} %");
        assert!(z > 0.01, "too good to be measured");
    }
}
