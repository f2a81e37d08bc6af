use super::*;
use proptest::prelude::*;

/// Coefficients a₁…a_p of the product of factors.
fn expand(factors: &[(f64, f64)]) -> Vec<f64> {
    let mut p = vec![1.0];
    for &(u, v) in factors {
        let mut next = vec![0.0; p.len() + 2];
        for (i, x) in p.iter().enumerate() {
            next[i] += x;
            next[i + 1] -= u * x;
            next[i + 2] += v * x;
        }
        p = next;
    }
    p[1..].to_vec()
}

fn pair(radius: f64, angle: f64) -> (f64, f64) {
    (2.0 * radius * angle.cos(), radius * radius)
}

/// Largest distance of a wanted factor from the nearest found one.
fn miss(found: &[Quadratic<f64>], wanted: &[(f64, f64)]) -> f64 {
    wanted
        .iter()
        .map(|&(u, v)| {
            found
                .iter()
                .map(|q| (q.u - u).abs() + (q.v - v).abs())
                .fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn cold_start_finds_separate_pairs(
        radii in proptest::array::uniform4(0.5f64..1.02),
        jitter in proptest::array::uniform4(-0.2f64..0.2),
    ) {
        let wanted: Vec<(f64, f64)> = (0..4)
            .map(|k| pair(radii[k], 0.5 + 0.7 * k as f64 + jitter[k]))
            .collect();
        let mut tracker = FactorTracker::<f64, 8>::new();
        prop_assert!(tracker.solve(&expand(&wanted), 200).is_some());
        prop_assert!(miss(tracker.factors(8), &wanted) < 1e-7);
    }

    #[test]
    fn any_polynomial_leaves_finite_factors(
        a in proptest::collection::vec(-30.0f32..30.0, 8),
        b in proptest::collection::vec(-3.0f32..3.0, 8),
    ) {
        let mut tracker = FactorTracker::<f32, 8>::new();
        for k in 0..600 {
            tracker.track(if k % 200 < 100 { &a } else { &b });
            prop_assert!(tracker.factors(8).iter().all(|q| (q.u + q.v).is_finite()));
        }
    }
}

#[test]
fn follows_a_pair_that_becomes_real_and_comes_back() {
    let mut tracker = FactorTracker::<f32, 4>::new();
    let mut lost = 0;
    for k in 0..4000 {
        // Discriminant u²/4 − v swings through zero: complex, real, complex.
        let v = 0.81 - 0.06 * (k as f64 * 2e-3).sin();
        let wanted = [(1.8, v), pair(0.97, 2.0)];
        let a: Vec<f32> = expand(&wanted).iter().map(|&x| x as f32).collect();
        if tracker.track(&a) == Tracking::Searching && k > 100 {
            lost += 1;
        }
        if k > 100 {
            let found: Vec<Quadratic<f64>> = tracker
                .factors(4)
                .iter()
                .map(|q| Quadratic {
                    u: q.u.into(),
                    v: q.v.into(),
                })
                .collect();
            let d = miss(&found, &wanted);
            assert!(d < 2e-3, "step {k}: {d}");
        }
    }
    assert_eq!(lost, 0);
}

#[test]
fn modes_keep_their_place_while_they_cross_in_frequency() {
    let mut tracker = FactorTracker::<f64, 4>::new();
    let at = |x: f64| [pair(0.99, 1.0 + x), pair(0.9, 1.4 - x)];
    tracker.solve(&expand(&at(0.0)), 200).expect("found");
    let first_is_light = tracker.factors(4)[0].v > 0.9;
    for k in 0..4000 {
        tracker.track(&expand(&at(1e-4 * f64::from(k))));
    }
    assert_eq!(tracker.factors(4)[0].v > 0.9, first_is_light);
    assert!(miss(tracker.factors(4), &at(0.4)) < 1e-3);
}

#[test]
fn a_jump_is_found_again() {
    let mut tracker = FactorTracker::<f32, 8>::new();
    let one: Vec<(f64, f64)> = [0.4, 1.0, 1.7, 2.5].map(|t| pair(0.98, t)).to_vec();
    let two: Vec<(f64, f64)> = [0.6, 0.8, 2.0, 2.9].map(|t| pair(0.95, t)).to_vec();
    for (wanted, n) in [(&one, 400), (&two, 400)] {
        let a: Vec<f32> = expand(wanted).iter().map(|&x| x as f32).collect();
        let mut last = Tracking::Searching;
        for _ in 0..n {
            last = tracker.track(&a);
        }
        assert_eq!(last, Tracking::Converged);
    }
    let found: Vec<Quadratic<f64>> = tracker
        .factors(8)
        .iter()
        .map(|q| Quadratic {
            u: q.u.into(),
            v: q.v.into(),
        })
        .collect();
    assert!(miss(&found, &two) < 1e-2);
}

#[test]
fn odd_degrees_have_one_root_at_zero() {
    // (z² − 1.2 z + 0.9)(z − 0.5)
    let a = [-1.7, 1.5, -0.45];
    let mut tracker = FactorTracker::<f64, 3>::new();
    tracker.solve(&a, 200).expect("found");
    assert!(miss(tracker.factors(3), &[(1.2, 0.9), (0.5, 0.0)]) < 1e-9);
    assert!(tracker.solve(&[f64::NAN, 1.0], 10).is_none());
}
