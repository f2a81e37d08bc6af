//! What the batch ARMA estimators must do.

use super::bench::{arma, pairs, white};
use super::*;
use proptest::prelude::*;

fn pem<T: rarma_core::Real>() -> Pem<T> {
    Pem::new(PemConfig::default()).expect("valid")
}

fn ml(with_mean: bool) -> Ml<f64> {
    let config = MlConfig {
        with_mean,
        ..MlConfig::default()
    };
    Ml::new(config).expect("valid")
}

#[test]
fn found_within_the_uncertainty_that_is_the_bound() {
    for (poles, c) in [
        (vec![(0.97, 1.0)], vec![0.5]),
        (vec![(0.97, 0.6), (0.95, 1.8)], vec![0.4, 0.5, 0.2]),
    ] {
        let a = pairs(&poles);
        let (p, q, n) = (a.len(), c.len(), 8000);
        let bound = Bound::<f64, 8>::of(&a, &c).expect("stable");
        let y = arma(&a, &c, n, 4);
        let fit = pem().fit::<8>(&y, p, q).expect("valid");
        assert!(fit.converged());
        for (i, (found, wanted)) in fit
            .a()
            .iter()
            .chain(fit.c())
            .zip(a.iter().chain(&c))
            .enumerate()
        {
            let sd = fit.deviation(i);
            assert!(
                (found - wanted).abs() < 3.5 * sd,
                "θ{i}: {found} for {wanted} ± {sd}"
            );
            let ratio = sd / bound.deviation(i, n);
            assert!((0.9..1.1).contains(&ratio), "θ{i}: sd over bound {ratio}");
        }
        assert!((fit.sigma2() - 1.0).abs() < 0.06);
        // Exact likelihood agrees to a fraction of a deviation on a long series.
        let exact = ml(false).fit::<8, 8>(&y, p, q).expect("valid");
        for i in 0..p + q {
            let theta = |f: &ArmaFit<f64, 8>| *f.a().iter().chain(f.c()).nth(i).expect("in range");
            assert!((theta(&exact) - theta(&fit)).abs() < 0.2 * fit.deviation(i));
            assert!((exact.deviation(i) / fit.deviation(i) - 1.0).abs() < 0.05);
        }
    }
}

#[test]
fn scatter_of_a_mode_is_the_bound() {
    let (r, theta, fs, n) = (0.96f64, 1.1f64, 1000.0, 1500);
    let (a, c) = (pairs(&[(r, theta)]), [0.6]);
    let (re, im) = (r * theta.cos(), r * theta.sin());
    let want = Bound::<f64, 3>::of(&a, &c)
        .expect("stable")
        .pole(re, im, fs, n)
        .expect("a pair");
    let damping = |a: &[f64]| {
        let l = 0.5 * a[1].ln();
        let angle = (-0.5 * a[0] / a[1].sqrt()).acos();
        -l / l.hypot(angle)
    };
    let truth = damping(&a);
    let runs = 150;
    let (mut sum, mut inside) = (0.0, 0);
    for seed in 0..runs {
        let y = arma(&a, &c, n, 50 + seed);
        let fit = pem().fit::<3>(&y, 2, 1).expect("valid");
        let off = damping(fit.a()) - truth;
        let v = fit.a()[1];
        let re = -0.5 * fit.a()[0];
        let stated = fit.pole(re, (v - re * re).sqrt(), fs).expect("a pair");
        sum += off * off;
        inside += u32::from(off.abs() < 1.96 * stated.damping);
    }
    let ratio = (sum / f64::from(runs)).sqrt() / want.damping;
    assert!((0.85..1.2).contains(&ratio), "rms over bound {ratio}");
    assert!((135..=149).contains(&inside), "{inside} of {runs} covered");
}

#[test]
fn likelihood_is_that_of_the_covariance_matrix() {
    let (a, c) = (pairs(&[(0.9, 1.0)]), [0.5, 0.3]);
    let n = 24;
    let y = arma(&a, &c, n, 9);
    // Autocovariance by a long impulse response.
    let mut h = vec![0.0; 600];
    for t in 0..h.len() {
        h[t] = match t {
            0 => 1.0,
            t => c.get(t - 1).copied().unwrap_or(0.0),
        };
        for i in 0..a.len().min(t) {
            h[t] -= a[i] * h[t - 1 - i];
        }
    }
    let r: Vec<f64> = (0..n)
        .map(|k| (k..600).map(|t| h[t] * h[t - k]).sum())
        .collect();
    // Cholesky of the Toeplitz matrix, and forward substitution.
    let mut l = vec![vec![0.0; n]; n];
    let (mut squares, mut log_det) = (0.0, 0.0);
    let mut z = vec![0.0; n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = r[i - j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { sum.sqrt() } else { sum / l[j][j] };
        }
        z[i] = (y[i] - (0..i).map(|k| l[i][k] * z[k]).sum::<f64>()) / l[i][i];
        squares += z[i] * z[i];
        log_det += 2.0 * l[i][i].ln();
    }
    let sigma2 = squares / n as f64;
    let want = -0.5 * (n as f64 * ((2.0 * core::f64::consts::PI * sigma2).ln() + 1.0) + log_det);
    let got = likelihood::<f64, 4>(&y, &a, &c).expect("stable");
    assert!(
        (got.log_likelihood - want).abs() < 1e-8,
        "{got:?} for {want}"
    );
    assert!((got.sigma2 - sigma2).abs() < 1e-9);
}

#[test]
fn exact_fit_is_a_maximum_and_finds_the_mean() {
    let (a, c) = (pairs(&[(0.9, 0.8)]), [-0.4]);
    let y: Vec<f64> = arma(&a, &c, 80, 11).iter().map(|y| y + 7.0).collect();
    let fit = ml(true).fit::<3, 2>(&y, 2, 1).expect("valid");
    assert!(
        fit.converged() && (fit.mean() - 7.0).abs() < 0.6,
        "{}",
        fit.mean()
    );
    let about: Vec<f64> = y.iter().map(|y| y - fit.mean()).collect();
    let at = |a: &[f64], c: &[f64]| {
        likelihood::<f64, 2>(&about, a, c)
            .expect("stable")
            .log_likelihood
    };
    let best = at(fit.a(), fit.c());
    assert!((best - fit.log_likelihood()).abs() < 1e-8);
    for i in 0..3 {
        for step in [-1e-2, 1e-2] {
            let (mut a, mut c) = (fit.a().to_vec(), fit.c().to_vec());
            if i < 2 {
                a[i] += step
            } else {
                c[0] += step
            }
            assert!(at(&a, &c) < best, "θ{i} by {step}");
        }
    }
}

#[test]
fn overdifferenced_noise_ends_at_the_edge_without_harm() {
    let e = white(5, 400);
    let y: Vec<f64> = e.windows(2).map(|w| w[1] - w[0]).collect();
    let fit = pem().fit::<1>(&y, 0, 1).expect("valid");
    // Taking e = 0 before the first sample pulls the root inwards.
    assert!((-1.0..-0.9).contains(&fit.c()[0]), "{:?}", fit.c());
    let exact = ml(false).fit::<1, 2>(&y, 0, 1).expect("valid");
    assert!((-1.0..-0.97).contains(&exact.c()[0]), "{:?}", exact.c());
}

#[test]
fn residuals_are_white_at_the_right_order_and_not_below() {
    let (a, c) = (pairs(&[(0.97, 0.6), (0.95, 1.8)]), [0.4, 0.5, 0.2]);
    let y = arma(&a, &c, 4000, 21);
    let right = pem().fit::<7>(&y, 4, 3).expect("valid");
    let low = pem().fit::<7>(&y, 2, 1).expect("valid");
    let test = |fit: &ArmaFit<f64, 7>, k| {
        Whiteness::of::<30>(fit.residuals(&y), 30, k)
            .expect("valid")
            .probability
    };
    assert!(test(&right, 7) > 0.01 && test(&low, 3) < 1e-6);
    let power: f64 = right.residuals(&y).map(|e| e * e).sum();
    assert!((power / right.samples() as f64 / right.sigma2() - 1.0).abs() < 1e-9);
    let bic = |fit: &ArmaFit<f64, 7>, k| {
        Criteria::of(fit.sigma2(), fit.samples(), k)
            .expect("valid")
            .bic
    };
    let high = pem().fit::<12>(&y, 6, 5).expect("valid");
    let high_bic = Criteria::of(high.sigma2(), high.samples(), 11)
        .expect("valid")
        .bic;
    assert!(bic(&right, 7) < bic(&low, 3) && bic(&right, 7) < high_bic);
}

#[test]
fn single_precision_agrees_within_the_uncertainty() {
    let (a, c) = (pairs(&[(0.97, 1.0)]), [0.5, 0.2]);
    let y = arma(&a, &c, 5000, 31);
    let single: Vec<f32> = y.iter().map(|&y| y as f32).collect();
    let double = pem::<f64>().fit::<4>(&y, 2, 2).expect("valid");
    let float = pem::<f32>().fit::<4>(&single, 2, 2).expect("valid");
    for i in 0..4 {
        let (d, f) = if i < 2 {
            (double.a()[i], float.a()[i])
        } else {
            (double.c()[i - 2], float.c()[i - 2])
        };
        let off = (d - f64::from(f)).abs() / double.deviation(i);
        assert!(off < 0.1, "θ{i}: {off} deviations");
        assert!((f64::from(float.deviation(i)) / double.deviation(i) - 1.0).abs() < 0.02);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn units_of_the_input_only_scale_the_variance(seed in 0u32..1000, exponent in -200i32..200) {
        let y = arma(&[-0.5, 0.7], &[0.4], 120, seed);
        let factor = 2f64.powi(exponent);
        let scaled: Vec<f64> = y.iter().map(|y| y * factor).collect();
        let (one, other) = (
            pem().fit::<3>(&y, 2, 1).expect("valid"),
            pem().fit::<3>(&scaled, 2, 1).expect("valid"),
        );
        prop_assert_eq!(one.a(), other.a());
        prop_assert_eq!(one.c(), other.c());
        let ratio = other.sigma2() / factor / factor / one.sigma2();
        prop_assert!((ratio - 1.0).abs() < 1e-12);
        let shift = other.log_likelihood() + one.samples() as f64 * factor.ln();
        prop_assert!((shift - one.log_likelihood()).abs() < 1e-7);
    }

    #[test]
    fn any_series_gives_a_usable_model_or_a_cause(
        y in proptest::collection::vec(-1.0f64..1.0, 60..90),
        p in 0usize..4,
        q in 0usize..4,
        spike in 0usize..60,
        power in 0i32..12,
    ) {
        let mut y = y;
        y[spike] *= 10f64.powi(power);
        if let Ok(fit) = pem().fit::<6>(&y, p, q) {
            prop_assert!(fit.a().iter().chain(fit.c()).all(|x| x.is_finite()));
            prop_assert!(fit.sigma2() > 0.0 && fit.residuals(&y).all(|e| e.is_finite()));
            prop_assert!(rarma_core::estimate::schur::inside::<f64, 6>(fit.c(), 1.0));
        }
        if let Ok(fit) = ml(true).fit::<6, 4>(&y, p, q) {
            prop_assert!(fit.a().iter().chain(fit.c()).all(|x| x.is_finite()));
            prop_assert!(fit.log_likelihood().is_finite() && fit.mean().is_finite());
        }
    }
}

#[test]
fn starts_of_ones_own_are_checked() {
    let y = arma(&[-0.5], &[0.4], 300, 2);
    let free = pem().fit::<2>(&y, 1, 1).expect("valid");
    let from = pem().fit_from::<2>(&y, 1, 1, &[0.0, 0.0]).expect("valid");
    assert!((free.sigma2() / from.sigma2() - 1.0).abs() < 1e-6);
    let refused = |start: &[f64]| pem().fit_from::<2>(&y, 1, 1, start).err();
    assert_eq!(refused(&[0.0, 1.2]), Some(FitError::NotStable));
    assert_eq!(refused(&[0.0]), Some(FitError::OutOfRange));
    let long = pem().hannan_rissanen::<2>(&y, 1, 1, 20).expect("valid");
    assert!((long.a()[0] - free.a()[0]).abs() < 2.0 * free.deviation(0));
}

#[test]
fn refuse_by_cause() {
    let y = white(3, 200);
    let error = |y: &[f64], p, q| {
        let (one, other) = (
            pem().fit::<4>(y, p, q).err(),
            ml(false).fit::<4, 4>(y, p, q).err(),
        );
        assert_eq!(one, other);
        one
    };
    assert_eq!(error(&y, 3, 2), Some(FitError::OrderAboveCapacity));
    assert_eq!(error(&y, 0, 0), Some(FitError::NothingToEstimate));
    assert_eq!(
        error(&y[..20], 2, 1),
        Some(FitError::TooFewSamples { needed: 22 })
    );
    assert_eq!(error(&[1.0; 100], 2, 1), Some(FitError::Constant));
    assert_eq!(
        error(&[&y[..50], &[f64::INFINITY]].concat(), 2, 1),
        Some(FitError::NotFinite { index: 50 })
    );
    assert_eq!(
        ml(false).fit::<4, 2>(&y, 1, 2).err(),
        Some(FitError::OrderAboveCapacity)
    );
    for config in [
        PemConfig {
            tolerance: 0.0,
            ..PemConfig::default()
        },
        PemConfig {
            iterations: 0,
            ..PemConfig::default()
        },
        PemConfig {
            c_radius: 1.5,
            ..PemConfig::default()
        },
        PemConfig {
            tolerance: f64::NAN,
            ..PemConfig::default()
        },
    ] {
        assert_eq!(Pem::new(config).err(), Some(FitError::OutOfRange));
        let config = MlConfig {
            pem: config,
            with_mean: false,
        };
        assert_eq!(Ml::new(config).err(), Some(FitError::OutOfRange));
    }
}

/// Σ e² from sample p on and of the q errors before it, which are chosen so that this is the least:
/// by the normal equations over the whole series, which share nothing with the fit's own.
fn least_sum(y: &[f64], a: &[f64], c: &[f64]) -> f64 {
    let (p, q) = (a.len(), c.len());
    // Errors of the series, of 0 for its samples, with these before them.
    let errors = |of_series: f64, before: &[f64]| -> Vec<f64> {
        let mut e = before.to_vec();
        for t in p..y.len() {
            let past = a.iter().zip(y[..t].iter().rev()).map(|(a, y)| a * y);
            let own = of_series * (y[t] + past.sum::<f64>());
            let ma: f64 = c.iter().zip(e.iter().rev()).map(|(c, e)| c * e).sum();
            e.push(own - ma);
        }
        e
    };
    let rest = errors(1.0, &vec![0.0; q]);
    let units: Vec<Vec<f64>> = (0..q)
        .map(|k| {
            errors(
                0.0,
                &(0..q)
                    .map(|j| f64::from(u8::from(j == k)))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
    // Gauss without pivots: the matrix is positive definite, the identity and more.
    let mut m: Vec<Vec<f64>> = units
        .iter()
        .map(|u| {
            let row = units.iter().map(|v| dot(u, v));
            row.chain([-dot(u, &rest)]).collect()
        })
        .collect();
    for k in 0..q {
        for i in k + 1..q {
            let factor = m[i][k] / m[k][k];
            for j in k..=q {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    let mut x = vec![0.0; q];
    for k in (0..q).rev() {
        let known: f64 = (k + 1..q).map(|j| m[k][j] * x[j]).sum();
        x[k] = (m[k][q] - known) / m[k][k];
    }
    let all = errors(1.0, &x);
    dot(&all, &all)
}

/// Whatever becomes of the other starts: the sum that the fit makes small is not above that of the
/// recursion's own model, not even after a single linearisation, and whatever circle C is kept in.
#[test]
fn never_above_the_recursion() {
    use rarma_core::estimate::{BoundedArma, RarmaConfig};
    let poles = [(0.98, 0.57), (0.98, 0.88), (0.975, 1.23), (0.97, 2.0)];
    let zeros = [(0.9, 0.6), (0.86, 0.92), (0.9, 1.25), (0.74, 2.0)];
    let (a, c) = (pairs(&poles), pairs(&zeros));
    // The zeros lie outside the second circle: there is much to bring inside.
    for (c_radius, seeds) in [(PemConfig::default().c_radius, 24), (0.85, 8)] {
        for seed in 0..seeds {
            let y = arma(&a, &c, 3000, 70 + seed);
            let default = RarmaConfig::<f64>::default();
            let config = RarmaConfig {
                forgetting: 1.0,
                c_radius: default.c_radius.min(c_radius),
                ..default
            };
            let mut recursion = BoundedArma::new(8, 8, config).expect("an order");
            for y in &y {
                recursion.update(*y);
            }
            recursion.finish_start();
            let config = PemConfig {
                iterations: 1,
                restarts: 0,
                c_radius,
                ..PemConfig::default()
            };
            let one = Pem::new(config).expect("valid");
            let found = one.fit::<16>(&y, 8, 8).expect("a model");
            let sum = least_sum(&y, found.a(), found.c());
            let of_recursion = least_sum(&y, recursion.a(), recursion.c());
            assert!(
                sum <= of_recursion * (1.0 + 1e-6),
                "radius {c_radius}, seed {seed}: {sum} above {of_recursion}"
            );
        }
    }
}
