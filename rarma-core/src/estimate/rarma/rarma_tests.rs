use super::*;

/// Uniform noise of −1 to 1.
fn noise(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*seed >> 8) / 8_388_608.0 - 1.0
}

/// ARMA(2,1) with poles at 0.98·e^(±j) and a zero at −0.7.
fn series(n: usize) -> Vec<f64> {
    let (mut seed, mut y1, mut y2, mut e1) = (3, 0.0, 0.0, 0.0);
    (0..n)
        .map(|_| {
            let e = noise(&mut seed);
            let y = 1.96 * 1f64.cos() * y1 - 0.9604 * y2 + e + 0.7 * e1;
            (y2, y1, e1) = (y1, y, e);
            y
        })
        .collect()
}

#[test]
fn finds_both_parts_and_states_its_uncertainty() {
    let mut model = Arma21::<f64>::new(RarmaConfig::default());
    for y in series(20_000) {
        model.update(y);
    }
    let truth = [-1.96 * 1f64.cos(), 0.9604, 0.7];
    for (i, (found, wanted)) in model.theta().iter().zip(truth).enumerate() {
        let variance = model.covariance().element(3, i, i) * model.covariance_factor();
        let off = (found - wanted).abs();
        assert!(off < 4.0 * variance.sqrt(), "θ{i}: off by {off}");
        assert!((1e-4..0.02).contains(&variance.sqrt()), "sd of θ{i}");
    }
    assert!((model.sigma2() * 3.0 - 1.0).abs() < 0.05);
}

#[test]
fn single_precision_agrees_with_double() {
    let mut single = Arma21::<f32>::new(RarmaConfig::default());
    let mut double = Arma21::<f64>::new(RarmaConfig::default());
    let mut largest = 0.0f64;
    for y in series(20_000) {
        single.update(y as f32);
        double.update(y);
        if double.ready() {
            for (s, d) in single.theta().iter().zip(double.theta()) {
                largest = largest.max((f64::from(*s) - d).abs());
            }
        }
    }
    assert!(
        (1e-9..1e-3).contains(&largest),
        "largest difference {largest}"
    );
}

#[test]
fn noise_model_stays_stable_at_every_step() {
    // An overfitted tone drives C towards the unit circle.
    let config = RarmaConfig {
        forgetting: 0.99,
        ..RarmaConfig::default()
    };
    let mut model = Arma87::<f32>::new(config);
    let (mut seed, mut limited) = (1, 0);
    for n in 0..60_000 {
        let y = (f64::from(n) * 0.9).sin() + 1e-3 * noise(&mut seed);
        let step = model.update(y as f32);
        limited += u32::from(step.status == Status::Limiting(Limit::NoiseModel));
        assert!(schur::inside::<f32, 15>(model.c(), 1.0), "sample {n}");
        assert!(step.innovation.is_finite());
    }
    assert!(
        limited > 0,
        "the limit was never needed: the test shows nothing"
    );
    assert!(model.covariance().is_definite(15));
}

#[test]
fn bad_samples_change_nothing() {
    let mut model = Arma43::<f32>::new(RarmaConfig::default());
    for y in series(3000) {
        model.update(y as f32);
    }
    let before = *model.theta();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(model.update(bad).status, Status::Rejected);
    }
    assert_eq!(*model.theta(), before);
}

#[test]
fn run_time_order_is_the_same_estimator() {
    let mut sized = Arma43::<f64>::new(RarmaConfig::default());
    let mut bounded =
        crate::estimate::BoundedArma::<f64>::new(4, 3, RarmaConfig::default()).expect("order");
    for y in series(3000) {
        sized.update(y);
        bounded.update(y);
    }
    for (x, y) in sized.a().iter().zip(bounded.a()) {
        assert!((x - y).abs() < 1e-9, "{x} {y}");
    }
    for (x, y) in sized.c().iter().zip(bounded.c()) {
        assert!((x - y).abs() < 1e-9, "{x} {y}");
    }
    assert!(crate::estimate::BoundedArma::<f64>::new(31, 0, RarmaConfig::default()).is_none());
}

#[test]
fn moving_average_alone_is_found() {
    let mut seed = 5;
    let mut model =
        crate::estimate::BoundedArma::<f64>::new(0, 2, RarmaConfig::default()).expect("order");
    let (mut e1, mut e2) = (0.0, 0.0);
    for _ in 0..20_000 {
        let e = noise(&mut seed);
        model.update(e + 0.5 * e1 - 0.3 * e2);
        (e2, e1) = (e1, e);
    }
    assert!((model.c()[0] - 0.5).abs() < 0.03 && (model.c()[1] + 0.3).abs() < 0.03);
}

#[test]
fn a_memory_that_silence_has_emptied_starts_anew() {
    // Without excitation forgetting alone would pass the range of f32 within 60 000
    // samples. A step of one turn is let through before a factor is held again.
    let config = RarmaConfig {
        forgetting: 0.998,
        ..RarmaConfig::default()
    };
    let mut model = Arma87::<f32>::new(config);
    for y in series(3000) {
        model.update(y as f32);
    }
    let most = config.d_ceiling * config.forgetting.powi(-16);
    let mut held = 0;
    let samples = (0..200_000).position(|_| {
        let step = model.update(0.0);
        held += u32::from(step.status == Status::Limiting(Limit::Covariance));
        assert!(model.covariance().is_definite(15));
        assert!(!model.ready() || model.covariance().d().iter().all(|d| *d <= most));
        step.status == Status::Starting
    });
    let samples = samples.expect("a new start");
    assert!((1000..20_000).contains(&samples), "after {samples}");
    assert!((15..2000).contains(&held), "held for {held}");
    // Silence does not end the start-up; a signal does, however long it took.
    for _ in 0..10_000 {
        assert_eq!(model.update(0.0).status, Status::Starting);
    }
    let ready = series(3000)
        .iter()
        .position(|y| model.update(*y as f32).status != Status::Starting);
    assert!((900..1500).contains(&ready.expect("ready")), "{ready:?}");
}
