//! What every method of the autoregressive family must do.

use super::bench::{arma, pairs, white};
use super::*;
use proptest::prelude::*;
use rarma_core::estimate::{IvConfig, RecursiveIv};

type Method<T, const N: usize> = fn(&[T], usize) -> Result<ArFit<T, N>, FitError>;

/// By name, with whether the result is always stable.
fn family<T: rarma_core::Real, const N: usize>() -> [(&'static str, Method<T, N>, bool); 5] {
    [
        ("yule_walker", yule_walker, true),
        ("burg", burg, true),
        ("geometric_lattice", geometric_lattice, true),
        ("covariance", covariance, false),
        ("modified_covariance", modified_covariance, false),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn reflections_are_below_one_on_any_series(
        y in proptest::collection::vec(-1.0f64..1.0, 12..80),
        p in 1usize..10,
        drift in -1.0f64..1.0,
        tone in 0.0f64..3.0,
    ) {
        let y: Vec<f64> = y
            .iter()
            .enumerate()
            .map(|(t, e)| 1e-3 * e + drift * t as f64 + (tone * t as f64).sin())
            .collect();
        for (name, method, stable) in family::<f64, 10>() {
            let Ok(fit) = method(&y, p) else { continue };
            prop_assert!(fit.sigma2() >= 0.0 && fit.a().iter().all(|a| a.is_finite()), "{name}");
            if stable {
                let k = fit.reflections();
                prop_assert!(k.is_some_and(|k| k.iter().all(|k| k.abs() < 1.0)), "{name}");
            }
        }
    }

    #[test]
    fn units_of_the_input_only_scale_the_variance(
        y in proptest::collection::vec(-1.0f32..1.0, 40..60),
        exponent in -60i32..60,
    ) {
        let factor = 2f32.powi(exponent);
        let scaled: Vec<f32> = y.iter().map(|y| y * factor).collect();
        for (name, method, _) in family::<f32, 4>() {
            let (one, other) = (method(&y, 4), method(&scaled, 4));
            let (one, other) = (one.expect(name), other.expect(name));
            prop_assert_eq!(one.a(), other.a(), "{}", name);
            prop_assert_eq!(one.sigma2() * factor * factor, other.sigma2(), "{}", name);
        }
    }
}

#[test]
fn all_find_the_model_within_its_uncertainty() {
    let a = pairs(&[(0.97, 0.7), (0.95, 1.9)]);
    let n = 20_000;
    let y = arma(&a, &[], n, 1);
    let bound = Bound::<f64, 4>::of(&a, &[]).expect("stable");
    for (name, method, _) in family::<f64, 4>() {
        let fit = method(&y, 4).expect(name);
        for (i, (found, wanted)) in fit.a().iter().zip(&a).enumerate() {
            let off = (found - wanted).abs() / bound.deviation(i, n);
            assert!(off < 3.5, "{name} a{i}: off by {off} deviations");
        }
        assert!(
            (fit.sigma2() - 1.0).abs() < 0.04,
            "{name}: {}",
            fit.sigma2()
        );
        assert_eq!(fit.samples(), n);
    }
}

#[test]
fn single_precision_agrees_with_double() {
    let a = pairs(&[(0.98, 0.7), (0.97, 1.9)]);
    let y = arma(&a, &[], 5000, 2);
    let single: Vec<f32> = y.iter().map(|&y| y as f32).collect();
    for ((name, double, _), (_, float, _)) in family::<f64, 4>().into_iter().zip(family::<f32, 4>())
    {
        let (d, f) = (double(&y, 4).expect(name), float(&single, 4).expect(name));
        for (d, f) in d.a().iter().zip(f.a()) {
            let off = (d - f64::from(*f)).abs();
            assert!(off < 2e-4 && off > 0.0, "{name}: {off}");
        }
    }
}

#[test]
fn decay_is_exact_for_least_squares_and_windowed_by_yule_walker() {
    // A free decay: no noise, so the equations hold exactly.
    let (mut y1, mut y2) = (1.0, 0.3);
    let y: Vec<f64> = (0..60)
        .map(|_| {
            let y = 1.7 * y1 - 0.9 * y2;
            (y2, y1) = (y1, y);
            y
        })
        .collect();
    let fit = covariance::<f64, 2>(&y, 2).expect("a decay");
    assert!((fit.a()[0] + 1.7).abs() < 1e-9 && (fit.a()[1] - 0.9).abs() < 1e-9);
    let windowed = yule_walker::<f64, 2>(&y, 2).expect("a decay");
    assert!((windowed.a()[1] - 0.9).abs() > 1e-3);
}

#[test]
fn a_tone_is_exact_forward_and_backward_and_too_little_for_more() {
    let w = 0.7f64;
    let y: Vec<f64> = (0..50).map(|t| (w * f64::from(t) + 0.3).sin()).collect();
    let fit = modified_covariance::<f64, 4>(&y, 2).expect("a tone");
    assert!((fit.a()[0] + 2.0 * w.cos()).abs() < 1e-9 && (fit.a()[1] - 1.0).abs() < 1e-9);
    assert_eq!(
        modified_covariance::<f64, 4>(&y, 4).err(),
        Some(FitError::Singular)
    );
}

#[test]
fn instruments_see_through_a_moving_average() {
    let a = pairs(&[(0.95, 1.0)]);
    let y = arma(&a, &[0.9], 50_000, 3);
    let fit = instrumental_variables::<f64, 2>(&y, 2, 1, 6).expect("valid");
    let biased = covariance::<f64, 2>(&y, 2).expect("valid");
    for i in 0..2 {
        assert!((fit.a()[i] - a[i]).abs() < 0.01, "{:?}", fit.a());
    }
    assert!((biased.a()[0] - a[0]).abs() > 0.05);
    // The variance is that of the moving average.
    assert!((fit.sigma2() - 1.81).abs() < 0.05, "{}", fit.sigma2());
    assert_eq!(
        instrumental_variables::<f64, 2>(&y, 2, 1, 1).err(),
        Some(FitError::OutOfRange)
    );
}

/// ARMA(4,3), poles 0.97·e^(±0.8j) and 0.95·e^(±1.7j): the listener's recursion over the same samples.
#[test]
fn instruments_agree_with_the_recursion() {
    let truth = pairs(&[(0.97, 0.8), (0.95, 1.7)]);
    for seed in [1, 2, 3] {
        let y = arma(&truth, &[0.1, 0.1, 0.24], 20_000, seed);
        let mut recursion = RecursiveIv::<f64, 4>::new(4, 3, IvConfig::default()).expect("order");
        for &y in &y {
            recursion.update(y);
        }
        let batch: ArFit<f64, 4> = instrumental_variables(&y, 4, 3, 4).expect("regular");
        for i in 0..4 {
            let off = (recursion.a()[i] - batch.a()[i]).abs();
            let error = (batch.a()[i] - truth[i]).abs();
            std::println!("a{}: apart {off:.2e}, error {error:.2e}", i + 1);
            // Apart by the first samples and the last: a few in 20 000.
            assert!((1e-9..2e-3).contains(&off), "a{}: {off}", i + 1);
        }
    }
}

#[test]
fn refuse_by_cause() {
    for (name, method, _) in family::<f64, 4>() {
        let noise = white(1, 40);
        assert_eq!(
            method(&noise, 5),
            Err(FitError::OrderAboveCapacity),
            "{name}"
        );
        assert_eq!(
            method(&noise, 0),
            Err(FitError::NothingToEstimate),
            "{name}"
        );
        assert!(
            matches!(method(&noise[..4], 4), Err(FitError::TooFewSamples { needed }) if needed > 4),
            "{name}"
        );
        assert_eq!(method(&[3.0; 40], 2), Err(FitError::Constant), "{name}");
        let mut bad = noise.clone();
        bad[7] = f64::NAN;
        assert_eq!(
            method(&bad, 2),
            Err(FitError::NotFinite { index: 7 }),
            "{name}"
        );
        assert!(method(&noise, 4).is_ok(), "{name}");
    }
}
