//! Response to an input: exact without noise, at the bound in noise, without bias by
//! instruments, refused by cause.

use super::bench::{pairs, white};
use super::{ArxFit, ArxOrder, FitError, arx, arx_instruments};
use proptest::prelude::*;
use rarma_core::spectrum::{FactorTracker, Roots, modal};

const FS: f64 = 5000.0;
const F: f64 = 980.0;
const ZETA: f64 = 0.02;
const ORDER: ArxOrder = ArxOrder {
    p: 2,
    b: 2,
    delay: 1,
};
const B: [f64; 2] = [0.5, 0.3];

fn denominator() -> Vec<f64> {
    let w = core::f64::consts::TAU * F / FS;
    pairs(&[(libm::exp(-ZETA * w), w * libm::sqrt(1.0 - ZETA * ZETA))])
}

/// B/A·u(t − delay) + 1/A·e.
fn respond(a: &[f64], b: &[f64], delay: usize, u: &[f64], e: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; u.len()];
    for t in 0..u.len() {
        y[t] = e.get(t).copied().unwrap_or(0.0);
        for (j, b) in b.iter().enumerate() {
            if t >= delay + j {
                y[t] += b * u[t - delay - j];
            }
        }
        for (i, a) in a.iter().enumerate().take(t) {
            y[t] -= a * y[t - 1 - i];
        }
    }
    y
}

/// ζ and its stated deviation.
fn damping(fit: &ArxFit<f64, 4>) -> (f64, f64) {
    let mut roots = FactorTracker::<f64, 4>::new();
    roots.solve(fit.a(), 1000).expect("roots");
    let factor = &roots.factors(2)[0];
    let Roots::Pair { re, im } = factor.roots() else {
        return (1.0, f64::NAN);
    };
    let sd = fit.pole(re, im, FS).expect("a pair");
    (modal(factor, FS).expect("a pair").damping, sd.damping)
}

#[test]
fn exact_without_noise() {
    let a = pairs(&[(0.98, 0.8), (0.95, 1.7)]);
    let b = [0.4, -0.3, 0.2];
    for delay in [0, 1, 7] {
        let u: Vec<f64> = white(1, 400).iter().map(|x| 1e-3 * x).collect();
        let y = respond(&a, &b, delay, &u, &[]);
        let order = ArxOrder { p: 4, b: 3, delay };
        for fit in [arx::<f64, 8>(&y, &u, order), arx_instruments(&y, &u, order)] {
            let fit = fit.expect("a model");
            let pairs = fit.a().iter().chain(fit.b()).zip(a.iter().chain(&b));
            for (x, want) in pairs {
                assert!((x - want).abs() < 1e-9, "{x} {want}");
            }
            assert!(fit.converged() && fit.order() == order);
            let response = fit.response(500.0, FS).expect("no root there");
            let w = core::f64::consts::TAU * 500.0 / FS;
            let sum = |c: &[f64], from: usize| {
                let term = |(k, c): (usize, &f64)| {
                    let phase = w * (k + from) as f64;
                    (c * libm::cos(phase), -c * libm::sin(phase))
                };
                let add = |x: (f64, f64), y: (f64, f64)| (x.0 + y.0, x.1 + y.1);
                c.iter().enumerate().map(term).fold((0.0, 0.0), add)
            };
            let (above, below) = (sum(&b, delay), sum(&a, 1));
            let below = (below.0 + 1.0, below.1);
            // G·A = B
            let re = response.re * below.0 - response.im * below.1 - above.0;
            let im = response.re * below.1 + response.im * below.0 - above.1;
            assert!(re.abs() < 1e-8 && im.abs() < 1e-8, "{re} {im}");
        }
    }
}

#[test]
fn least_squares_reaches_the_bound_in_equation_noise() {
    let (a, n, seeds, sigma) = (denominator(), 1000, 200, 0.7);
    // Bound: σ²·E[φφᵀ]⁻¹/n, the expectation from one long record.
    let u = white(999, 200_000);
    let e: Vec<f64> = white(998, u.len()).iter().map(|x| sigma * x).collect();
    let y = respond(&a, &B, 1, &u, &e);
    let mut normal = [[0.0; 4]; 4];
    for t in 3000..y.len() {
        let phi = [-y[t - 1], -y[t - 2], u[t - 1], u[t - 2]];
        for i in 0..4 {
            for j in 0..4 {
                normal[i][j] += phi[i] * phi[j] / (y.len() - 3000) as f64;
            }
        }
    }
    let bound = |i: usize| sigma * sigma * inverse(normal)[i][i] / n as f64;
    let (mut squares, mut stated, mut covered) = ([0.0; 4], [0.0; 4], 0.0);
    let mut noise = 0.0;
    for seed in 0..seeds {
        let u = white(2 * seed + 1, n + 1000);
        let e: Vec<f64> = white(2 * seed + 2, u.len())
            .iter()
            .map(|x| sigma * x)
            .collect();
        let y = respond(&a, &B, 1, &u, &e);
        let fit = arx::<f64, 4>(&y[1000..], &u[1000..], ORDER).expect("a model");
        let truth = [a[0], a[1], B[0], B[1]];
        for i in 0..4 {
            squares[i] += (fit.theta[i] - truth[i]).powi(2) / f64::from(seeds);
            stated[i] += fit.covariance(i, i) / f64::from(seeds);
        }
        let (zeta, sd) = damping(&fit);
        covered += f64::from(u8::from((zeta - ZETA).abs() < 1.96 * sd)) / f64::from(seeds);
        noise += fit.sigma2() / f64::from(seeds);
    }
    for i in 0..4 {
        let ratios = [squares[i] / bound(i), stated[i] / bound(i)].map(f64::sqrt);
        assert!((0.85..1.18).contains(&ratios[0]), "{i}: {ratios:?}");
        assert!((0.93..1.07).contains(&ratios[1]), "{i}: {ratios:?}");
    }
    assert!((0.9..0.99).contains(&covered), "{covered}");
    assert!((noise / (sigma * sigma) - 1.0).abs() < 0.02, "{noise}");
}

fn inverse(m: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let mut work = m;
    let mut out = [[0.0; 4]; 4];
    for (i, row) in out.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for k in 0..4 {
        let pivot = work[k][k];
        for j in 0..4 {
            work[k][j] /= pivot;
            out[k][j] /= pivot;
        }
        for i in (0..4).filter(|i| *i != k) {
            let factor = work[i][k];
            for j in 0..4 {
                work[i][j] -= factor * work[k][j];
                out[i][j] -= factor * out[k][j];
            }
        }
    }
    out
}

/// Output with white noise on it so that the coherence of the whole is `coherence`.
fn noisy_output(seed: u32, n: usize, coherence: f64) -> (Vec<f64>, Vec<f64>, f64) {
    let u = white(3 * seed + 7, n + 1000);
    let mut y = respond(&denominator(), &B, 1, &u, &[]);
    let power: f64 = y[1000..].iter().map(|x| x * x).sum::<f64>() / n as f64;
    let sigma = libm::sqrt(power * (1.0 - coherence) / coherence);
    for (y, v) in y.iter_mut().zip(white(3 * seed + 8, n + 1000)) {
        *y += sigma * v;
    }
    (y.split_off(1000), u[1000..].to_vec(), sigma)
}

#[test]
fn instruments_remove_the_bias_of_output_noise() {
    let (n, seeds, coherence) = (4000, 100, 0.4);
    let (mut least, mut refined, mut squares, mut stated) = (0.0, 0.0, 0.0, 0.0);
    let (mut covered, mut response) = (0.0, [0.0; 2]);
    let share = 1.0 / f64::from(seeds);
    let u = white(5, 40);
    let clean = respond(&denominator(), &B, 1, &u, &[]);
    let truth = arx::<f64, 4>(&clean, &u, ORDER).expect("a model");
    let truth = truth.response(F, FS).expect("finite");
    for seed in 0..seeds {
        let (y, u, sigma) = noisy_output(seed, n, coherence);
        let fit = arx::<f64, 4>(&y, &u, ORDER).expect("a model");
        least += damping(&fit).0 * share;
        let fit = arx_instruments::<f64, 4>(&y, &u, ORDER).expect("a model");
        assert!(fit.converged() && fit.rounds() > 1);
        let (zeta, sd) = damping(&fit);
        refined += zeta * share;
        squares += (zeta - ZETA).powi(2) * share;
        stated += sd * sd * share;
        covered += f64::from(u8::from((zeta - ZETA).abs() < 1.96 * sd)) * share;
        assert!((fit.sigma2().sqrt() / sigma - 1.0).abs() < 0.06);
        let g = fit.response(F, FS).expect("finite");
        response[0] += ((g.re - truth.re) / g.re_sd).powi(2) * share;
        response[1] += ((g.im - truth.im) / g.im_sd).powi(2) * share;
    }
    let (rms, stated) = (libm::sqrt(squares), libm::sqrt(stated));
    println!(
        "ζ {ZETA}: least squares {least:.4}, instruments {refined:.5}, rms {rms:.5}, stated {stated:.5}, covered {covered:.2}, response {response:.2?}"
    );
    assert!(least > 2.0 * ZETA, "least squares is not biased: {least}");
    assert!((refined - ZETA).abs() < 3.0 * rms / 10.0, "{refined}");
    assert!((0.8..1.25).contains(&(rms / stated)), "{rms} {stated}");
    assert!((0.88..=1.0).contains(&covered), "{covered}");
    assert!(
        response.iter().all(|x| (0.6..1.5).contains(x)),
        "{response:?}"
    );
}

#[test]
fn single_precision_gives_the_same_model() {
    let (y, u, _) = noisy_output(1, 4000, 0.5);
    let (short_y, short_u): (Vec<f32>, Vec<f32>) = y
        .iter()
        .zip(&u)
        .map(|(y, u)| (*y as f32, *u as f32))
        .unzip();
    let long = arx_instruments::<f64, 4>(&y, &u, ORDER).expect("a model");
    let single = arx_instruments::<f32, 4>(&short_y, &short_u, ORDER).expect("a model");
    for i in 0..4 {
        let off = (long.theta[i] - f64::from(single.theta[i])).abs() / long.deviation(i);
        assert!(off < 0.02, "{i}: {off}");
    }
    let (long, single) = (long.response(F, FS), single.response(F as f32, FS as f32));
    let (long, single) = (long.expect("finite"), single.expect("finite"));
    assert!((long.re - f64::from(single.re)).abs() < 0.05 * long.re_sd);
    assert!((long.phase_sd / f64::from(single.phase_sd) - 1.0).abs() < 1e-2);
}

#[test]
fn refusals_name_their_cause() {
    let (y, u, _) = noisy_output(1, 60, 0.5);
    let fit = |y: &[f64], u: &[f64], order| arx::<f64, 4>(y, u, order).map(|_| ()).unwrap_err();
    assert_eq!(fit(&y, &u[1..], ORDER), FitError::DifferentLengths);
    let large = ArxOrder { p: 3, ..ORDER };
    assert_eq!(fit(&y, &u, large), FitError::OrderAboveCapacity);
    let none = ArxOrder { b: 0, ..ORDER };
    assert_eq!(fit(&y, &u, none), FitError::NothingToEstimate);
    let late = ArxOrder { delay: 59, ..ORDER };
    assert_eq!(fit(&y, &u, late), FitError::TooFewSamples { needed: 68 });
    let never = ArxOrder {
        delay: usize::MAX,
        ..ORDER
    };
    assert!(matches!(fit(&y, &u, never), FitError::TooFewSamples { .. }));
    assert_eq!(fit(&y, &[1.0; 60], ORDER), FitError::NoExcitation);
    assert_eq!(fit(&[1.0; 60], &u, ORDER), FitError::Constant);
    // One tone determines two coefficients of B, not three.
    let tone: Vec<f64> = (0..60).map(|t| libm::sin(0.3 * f64::from(t))).collect();
    assert_eq!(
        fit(
            &y,
            &tone,
            ArxOrder {
                p: 1,
                b: 3,
                delay: 1
            }
        ),
        FitError::NoExcitation
    );
    let (mut bad_y, mut bad_u) = (y.clone(), u.clone());
    bad_y[7] = f64::NAN;
    bad_u[8] = f64::INFINITY;
    assert_eq!(fit(&bad_y, &u, ORDER), FitError::NotFinite { index: 7 });
    assert_eq!(
        fit(&y, &bad_u, ORDER),
        FitError::InputNotFinite { index: 8 }
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn units_change_only_the_gain(y_unit in -6i32..6, u_unit in -6i32..6, seed in 0u32..100) {
        let (y, u, _) = noisy_output(seed, 400, 0.5);
        let (ky, ku) = (libm::pow(10.0, f64::from(y_unit)), libm::pow(10.0, f64::from(u_unit)));
        let scaled_y: Vec<f64> = y.iter().map(|x| ky * x).collect();
        let scaled_u: Vec<f64> = u.iter().map(|x| ku * x).collect();
        let one = arx::<f64, 4>(&y, &u, ORDER).expect("a model");
        let other = arx::<f64, 4>(&scaled_y, &scaled_u, ORDER).expect("a model");
        for i in 0..4 {
            let unit = if i < 2 { 1.0 } else { ky / ku };
            prop_assert!((other.theta[i] / unit - one.theta[i]).abs() < 1e-8);
            prop_assert!((other.deviation(i) / unit / one.deviation(i) - 1.0).abs() < 1e-6);
        }
        prop_assert!((other.sigma2() / (ky * ky) / one.sigma2() - 1.0).abs() < 1e-8);
    }

    #[test]
    fn any_records_are_refused_or_give_finite_models(
        y in prop::collection::vec(-1e9f32..1e9, 30), u in prop::collection::vec(-1e9f32..1e9, 30),
        p in 0usize..4, b in 1usize..4, delay in 0usize..5,
    ) {
        let order = ArxOrder { p, b, delay };
        for fit in [arx::<f32, 6>(&y, &u, order), arx_instruments(&y, &u, order)].into_iter().flatten() {
            prop_assert!(fit.a().iter().chain(fit.b()).all(|x| x.is_finite()));
            prop_assert!(fit.sigma2() >= 0.0);
        }
    }
}
