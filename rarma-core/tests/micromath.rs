//! How far functions in single precision are off, ours beside those of `libm` and `micromath`, and what becomes
//! of a pole's frequency and damping by them: the figures of decision 87.
//!
//! `cargo test --release -p rarma-core --test micromath -- --nocapture --test-threads 1`

use micromath::F32Ext;
use rarma_core::Real;
use rarma_core::spectrum::{Quadratic, modal};
use std::f64::consts::{PI, TAU};

/// Sampling rate behind the decimation, Hz.
const FS_HZ: f64 = 6000.0;
const STEPS: u32 = 20_000;

/// Largest errors of ours, of libm's, of micromath's, over `STEPS` places from `low` to `high`, evenly by ratio
/// or by difference.
fn worst(
    (low, high): (f64, f64),
    relative: bool,
    exact: fn(f64) -> f64,
    candidates: [&dyn Fn(f32) -> f32; 3],
) -> [f64; 3] {
    let mut worst = [0.0f64; 3];
    for n in 0..=STEPS {
        let part = f64::from(n) / f64::from(STEPS);
        let x = if low > 0.0 {
            low * (high / low).powf(part)
        } else {
            low + (high - low) * part
        };
        let x = x as f32;
        let exact = exact(f64::from(x));
        for (worst, candidate) in worst.iter_mut().zip(candidates) {
            let off = (f64::from(candidate(x)) - exact).abs();
            *worst = worst.max(if relative { off / exact.abs() } else { off });
        }
    }
    worst
}

/// Frequency (Hz) and damping of a pole pair by the textbook, from somebody's functions.
fn textbook(
    (u, v): (f32, f32),
    sqrt: impl Fn(f32) -> f32,
    ln: impl Fn(f32) -> f32,
    atan2: impl Fn(f32, f32) -> f32,
) -> (f32, f32) {
    let re = 0.5 * u;
    let (l, theta) = (0.5 * ln(v), atan2(sqrt(v - re * re), re));
    let r = sqrt(l * l + theta * theta);
    (FS_HZ as f32 * r / std::f32::consts::TAU, -l / r)
}

/// Who makes f and ζ of a pole pair.
const MAKERS: [&str; 6] = [
    "ours",
    "libm",
    "micromath",
    "micromath's sqrt, else libm",
    "micromath's ln, else libm",
    "micromath's atan2, else libm",
];

fn by(who: usize, (u, v): (f32, f32)) -> (f32, f32) {
    match who {
        0 => {
            let mode = modal(&Quadratic { u, v }, FS_HZ as f32).expect("a pair");
            (mode.frequency, mode.damping)
        }
        1 => textbook((u, v), libm::sqrtf, libm::logf, libm::atan2f),
        2 => textbook((u, v), F32Ext::sqrt, F32Ext::ln, F32Ext::atan2),
        3 => textbook((u, v), F32Ext::sqrt, libm::logf, libm::atan2f),
        4 => textbook((u, v), libm::sqrtf, F32Ext::ln, libm::atan2f),
        _ => textbook((u, v), libm::sqrtf, libm::logf, F32Ext::atan2),
    }
}

#[test]
fn functions() {
    println!("| function | range | ours | libm | micromath |");
    let line = |name: &str, range: &str, worst: [f64; 3]| {
        let [ours, libm, theirs] = worst;
        println!("| {name} | {range} | {ours:.1e} | {libm:.1e} | {theirs:.1e} |");
        assert!(ours < 5e-7 && libm < 5e-7, "{name}: {worst:?}");
        // The day it is better, the decision is to be looked at again.
        assert!((3e-5..0.2).contains(&theirs), "{name}: {worst:?}");
    };
    let (positive, turn) = ((1e-6, 1e6), (-3.1, 3.1));
    let roots: [&dyn Fn(f32) -> f32; 3] = [&|x| Real::sqrt(x), &libm::sqrtf, &F32Ext::sqrt];
    let root = worst(positive, true, f64::sqrt, roots);
    line("sqrt, relative", "1e-6 to 1e6", root);
    let logs: [&dyn Fn(f32) -> f32; 3] = [&|x| Real::ln(x), &libm::logf, &F32Ext::ln];
    line(
        "ln, relative",
        "2 to 1e6",
        worst((2.0, 1e6), true, f64::ln, logs),
    );
    let near = worst((0.5, 2.0), false, f64::ln, logs);
    line("ln, absolute", "0.5 to 2", near);
    let powers: [&dyn Fn(f32) -> f32; 3] = [&|x| Real::exp(x), &libm::expf, &F32Ext::exp];
    let power = worst((-20.0, 20.0), true, f64::exp, powers);
    line("exp, relative", "-20 to 20", power);
    // Of a point that is exactly what single precision holds.
    let point = |a: f32| (a.sin(), a.cos());
    let angles: [&dyn Fn(f32) -> f32; 3] = [
        &|a| Real::atan2(point(a).0, point(a).1),
        &|a| libm::atan2f(point(a).0, point(a).1),
        &|a| F32Ext::atan2(point(a).0, point(a).1),
    ];
    let exact = |a: f64| f64::from((a as f32).sin()).atan2(f64::from((a as f32).cos()));
    line("atan2, rad", "all round", worst(turn, false, exact, angles));
    let sines: [&dyn Fn(f32) -> f32; 3] = [&|x| Real::sin_cos(x).0, &libm::sinf, &|x| {
        F32Ext::sin_cos(x).0
    }];
    let sine = worst((0.0, PI), false, f64::sin, sines);
    line("sin, absolute", "0 to π", sine);
    let cosines: [&dyn Fn(f32) -> f32; 3] = [&|x| Real::sin_cos(x).1, &libm::cosf, &|x| {
        F32Ext::sin_cos(x).1
    }];
    let cosine = worst((0.0, PI), false, f64::cos, cosines);
    line("cos, absolute", "0 to π", cosine);
}

#[test]
fn frequency_and_damping_of_poles() {
    println!("| by | f off at most, Hz | ζ off at most, of 0.002 | of 0.01 | of 0.03 |");
    for (who, maker) in MAKERS.into_iter().enumerate() {
        let mut f_off = 0.0f64;
        let zeta_off = [0.002, 0.01, 0.03].map(|zeta| {
            let mut zeta_off = 0.0f64;
            for n in 0..=2000 {
                let f_hz = 60.0 + (2700.0 - 60.0) * f64::from(n) / 2000.0;
                let w = TAU * f_hz / FS_HZ;
                let radius = (-zeta * w).exp();
                let re = radius * (w * (1.0f64 - zeta * zeta).sqrt()).cos();
                let pair = ((2.0 * re) as f32, (radius * radius) as f32);
                // What the rounded coefficients mean, in double precision.
                let (u, v) = (f64::from(pair.0), f64::from(pair.1));
                let (l, theta) = (0.5 * v.ln(), (v - 0.25 * u * u).sqrt().atan2(0.5 * u));
                let (f_is, zeta_is) = (FS_HZ * l.hypot(theta) / TAU, -l / l.hypot(theta));
                let (f, zeta) = by(who, pair);
                f_off = f_off.max((f64::from(f) - f_is).abs());
                zeta_off = zeta_off.max((f64::from(zeta) - zeta_is).abs());
            }
            zeta_off
        });
        let [least, light, heavy] = zeta_off;
        println!("| {maker} | {f_off:.2} | {least:.1e} | {light:.1e} | {heavy:.1e} |");
        let exact = who < 2;
        assert_eq!(f_off < 0.01, exact, "{maker}: {f_off} Hz");
        assert_eq!(heavy < 1e-6, exact, "{maker}: {zeta_off:?}");
        assert!(
            f_off < 300.0 && heavy < 0.05,
            "{maker}: {f_off} Hz, {zeta_off:?}"
        );
    }
}
