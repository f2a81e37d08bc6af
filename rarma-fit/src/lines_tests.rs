//! Lines: exact without noise, at the bound in noise, refused by cause.

use super::bench::white;
use super::{FitError, Ml, MlConfig, ToneFit, esprit, likelihood, tones};
use proptest::prelude::*;

/// Σ amplitude·cos(ωt + phase).
fn lines(parts: &[(f64, f64, f64)], t: usize) -> f64 {
    let part =
        |&(w, amplitude, phase): &(f64, f64, f64)| amplitude * libm::cos(w * t as f64 + phase);
    parts.iter().map(part).sum()
}

const PARTS: [(f64, f64, f64); 2] = [(0.9425, 1.0, 0.3), (0.9739, 0.7, -1.1)];

#[test]
fn poles_are_exact_without_noise() {
    for (n, p) in [(128, 4), (40, 4), (500, 4)] {
        let mut y = [0.0; 500];
        for (t, y) in y[..n].iter_mut().enumerate() {
            *y = lines(&PARTS, t);
        }
        let fit = esprit::<f64, 4, 64>(&y[..n], p).expect("a model");
        let mut want = [1.0, 0.0, 0.0, 0.0, 0.0];
        for (w, _, _) in PARTS {
            for i in (1..5).rev() {
                let two = if i > 1 { want[i - 2] } else { 0.0 };
                want[i] += two - 2.0 * libm::cos(w) * want[i - 1];
            }
        }
        for (a, want) in fit.a().iter().zip(&want[1..]) {
            assert!((a - want).abs() < 1e-6, "{n}: {a} {want}");
        }
        assert!(fit.sigma2() < 1e-12);
    }
}

#[test]
fn tones_are_exact_without_noise() {
    let y: [f64; 128] = core::array::from_fn(|t| 1e3 * lines(&PARTS, t));
    let fit = tones::<f64, 6, 48>(&y, 2).expect("tones");
    assert!(fit.tones() == 2 && fit.samples() == 128 && fit.tone(2, 1.0).is_none());
    for (k, (w, amplitude, phase)) in PARTS.into_iter().enumerate() {
        let tone = fit.tone(k, core::f64::consts::TAU).expect("a tone");
        assert!((tone.frequency - w).abs() < 1e-9, "{tone:?}");
        assert!((tone.amplitude - 1e3 * amplitude).abs() < 1e-5, "{tone:?}");
        assert!((tone.phase - phase).abs() < 1e-7, "{tone:?}");
    }
}

fn noisy(seed: u32) -> [f64; 128] {
    let noise = white(seed, 128);
    core::array::from_fn(|t| {
        lines(&[(0.9425, 1.0, 0.3 * f64::from(seed)), (1.3, 0.7, 0.7)], t) + 0.3 * noise[t]
    })
}

#[test]
fn tones_reach_the_bound_and_state_it() {
    // Well apart: var ω = 24σ²/(A²n³), var A = 2σ²/n.
    let (mut by_w, mut by_a, mut stated, mut noise) = (0.0, 0.0, 0.0, 0.0);
    let seeds = 200;
    for seed in 0..seeds {
        let y = noisy(seed);
        let fit: ToneFit<f64, 6> = tones::<f64, 6, 20>(&y, 2).expect("tones");
        assert!(fit.converged());
        let tone = fit.tone(0, core::f64::consts::TAU).expect("a tone");
        by_w += (tone.frequency - 0.9425) * (tone.frequency - 0.9425);
        by_a += (tone.amplitude - 1.0) * (tone.amplitude - 1.0);
        stated += tone.frequency_sd * tone.frequency_sd;
        noise += fit.sigma2();
        let deviation = tone.amplitude_sd / libm::sqrt(2.0 * 0.09 / 128.0);
        assert!((0.75..1.3).contains(&deviation), "{deviation}");
    }
    let n = f64::from(seeds);
    let bound = 24.0 * 0.09 / (128.0 * 128.0 * 128.0);
    let ratios = [
        by_w / n / bound,
        by_a / n / (2.0 * 0.09 / 128.0),
        stated / n / bound,
    ];
    for ratio in ratios {
        assert!((0.75..1.3).contains(&ratio), "{ratios:?}");
    }
    // Six parameters of 128.
    let share = noise / n / (0.09 * 122.0 / 128.0);
    assert!((0.97..1.03).contains(&share), "{share}");
}

#[test]
fn single_precision_finds_the_same_lines() {
    let y = noisy(3);
    let short = y.map(|x| x as f32);
    let long = esprit::<f64, 4, 48>(&y, 4).expect("a model");
    let single = esprit::<f32, 4, 48>(&short, 4).expect("a model");
    for (x, y) in long.a().iter().zip(single.a()) {
        assert!((x - f64::from(*y)).abs() < 1e-4, "{x} {y}");
    }
    assert!((long.sigma2() / f64::from(single.sigma2()) - 1.0).abs() < 1e-3);
    let long = tones::<f64, 6, 48>(&y, 2).expect("tones");
    let single = tones::<f32, 6, 48>(&short, 2).expect("tones");
    for k in 0..2 {
        let (x, y) = (long.tone(k, 1000.0), single.tone(k, 1000.0));
        let (x, y) = (x.expect("a tone"), y.expect("a tone"));
        let off = (x.frequency - f64::from(y.frequency)).abs() / x.frequency_sd;
        assert!(off < 0.05, "{off}");
    }
}

#[test]
fn noise_power_is_that_of_the_noise() {
    let mut sum = 0.0;
    for seed in 0..20 {
        sum += esprit::<f64, 4, 24>(&noisy(seed), 4)
            .expect("a model")
            .sigma2();
    }
    // What is left out are the smaller eigenvalues of noise: a little below.
    assert!((0.8..1.0).contains(&(sum / 20.0 / 0.09)), "{}", sum / 20.0);
}

#[test]
fn refusals_name_their_cause() {
    let y = noisy(1);
    let fit = |y: &[f64], p| esprit::<f64, 6, 8>(y, p).map(|_| ()).unwrap_err();
    assert_eq!(fit(&y, 7), FitError::OrderAboveCapacity);
    assert_eq!(fit(&y, 0), FitError::NothingToEstimate);
    assert_eq!(fit(&y[..7], 4), FitError::TooFewSamples { needed: 8 });
    assert_eq!(fit(&[2.0; 60], 2), FitError::Constant);
    let one: [f64; 60] = core::array::from_fn(|t| libm::cos(t as f64));
    assert_eq!(fit(&one, 4), FitError::Singular);
    let mut bad = y;
    bad[9] = f64::INFINITY;
    assert_eq!(fit(&bad, 2), FitError::NotFinite { index: 9 });
    let fit = |y: &[f64], k| tones::<f64, 6, 8>(y, k).map(|_| ()).unwrap_err();
    assert_eq!(fit(&y, 0), FitError::NothingToEstimate);
    assert_eq!(fit(&y, 3), FitError::OrderAboveCapacity);
    assert_eq!(fit(&y[..19], 2), FitError::TooFewSamples { needed: 20 });
    assert_eq!(fit(&bad, 1), FitError::NotFinite { index: 9 });
}

#[test]
fn likelihood_starts_from_the_subspace_and_from_what_is_given() {
    // Poles on tones, zeros a little further inside: higher than the likelihood of
    // the truth pulled in, and the start that is given leads to the same.
    let (y, ml) = (noisy(4), Ml::new(MlConfig::default()).expect("settings"));
    let polynomial = |radius: f64| super::bench::pairs(&[(radius, 0.9425), (radius, 1.3)]);
    let (a, c) = (polynomial(0.999), polynomial(0.95));
    let near = likelihood::<f64, 5>(&y, &a, &c).expect("stable");
    let start: Vec<f64> = a.iter().chain(&c).copied().collect();
    let given = ml.fit_from::<8, 5>(&y, 4, 4, &start).expect("a model");
    let own = ml.fit::<8, 5>(&y, 4, 4).expect("a model");
    assert!(given.log_likelihood() > near.log_likelihood + 0.1);
    assert!(own.log_likelihood() > given.log_likelihood() - 0.5);
    let error = |start: &[f64]| {
        ml.fit_from::<8, 5>(&y, 4, 4, start)
            .map(|_| ())
            .unwrap_err()
    };
    assert_eq!(error(&start[1..]), FitError::OutOfRange);
    assert_eq!(error(&[f64::NAN; 8]), FitError::OutOfRange);
    let outside: Vec<f64> = polynomial(1.01).into_iter().chain(c).collect();
    assert_eq!(error(&outside), FitError::NotStable);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn any_series_is_refused_or_gives_finite_lines(
        y in prop::collection::vec(-1e6f32..1e6, 8..90), p in 1usize..8,
    ) {
        if let Ok(fit) = esprit::<f32, 8, 16>(&y, p) {
            prop_assert!(fit.a().iter().all(|a| a.is_finite()) && fit.sigma2().is_finite());
        }
        if let Ok(fit) = tones::<f32, 6, 16>(&y, 1 + p % 2) {
            for k in 0..fit.tones() {
                let tone = fit.tone(k, 1.0).expect("a tone");
                prop_assert!((0.0..=0.5).contains(&tone.frequency) && tone.amplitude.is_finite());
            }
        }
    }

    #[test]
    fn lines_scale_with_the_series(scale in -12i32..12, seed in 0u32..1000) {
        let y = noisy(seed);
        let factor = libm::pow(10.0, f64::from(scale));
        let scaled = y.map(|x| x * factor);
        let (x, z) = (tones::<f64, 6, 16>(&y, 2), tones::<f64, 6, 16>(&scaled, 2));
        let (x, z) = (x.expect("tones"), z.expect("tones"));
        for k in 0..2 {
            let (x, z) = (x.tone(k, 1.0).expect("a tone"), z.tone(k, 1.0).expect("a tone"));
            prop_assert!((x.frequency - z.frequency).abs() < 1e-3 * x.frequency_sd);
            prop_assert!((z.amplitude / factor - x.amplitude).abs() < 1e-3 * x.amplitude_sd);
        }
    }
}
