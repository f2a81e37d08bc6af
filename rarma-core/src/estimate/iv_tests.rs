use super::*;

/// Uniform noise of −1 to 1.
fn noise(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*seed >> 8) / 8_388_608.0 - 1.0
}

/// Two modes: poles 0.97·e^(±0.8j) and 0.95·e^(±1.7j).
fn truth() -> [f64; 4] {
    let (b, c) = (-1.94 * 0.8f64.cos(), 0.97 * 0.97);
    let (d, e) = (-1.9 * 1.7f64.cos(), 0.95 * 0.95);
    [b + d, c + e + b * d, b * e + c * d, c * e]
}

/// ARMA(4,3) of [`truth`] with C = (1 + 0.6 q⁻¹)(1 − 0.5 q⁻¹ + 0.4 q⁻²).
fn series(n: usize, mut seed: u32) -> Vec<f64> {
    let (a, c) = (truth(), [0.1, 0.1, 0.24]);
    let (mut past, mut errors) = ([0.0; 4], [0.0; 3]);
    (0..n)
        .map(|_| {
            let e = noise(&mut seed);
            let y = e + (0..3).map(|j| c[j] * errors[j]).sum::<f64>()
                - (0..4).map(|i| a[i] * past[i]).sum::<f64>();
            past.rotate_right(1);
            past[0] = y;
            errors.rotate_right(1);
            errors[0] = e;
            y
        })
        .collect()
}

fn fitted(y: &[f64], p: usize, q: usize) -> RecursiveIv<f64, 4> {
    let mut model = RecursiveIv::new(p, q, IvConfig::default()).expect("order");
    for &y in y {
        model.update(y);
    }
    model
}

/// Largest component of the mean error over the seeds, and rms error of all components.
fn errors(n: usize, q: usize) -> (f64, f64) {
    const SEEDS: u32 = 40;
    let (mut mean, mut square) = ([0.0; 4], 0.0);
    for seed in 0..SEEDS {
        let model = fitted(&series(n, 7 * seed + 1), 4, q);
        for i in 0..4 {
            let off = model.a()[i] - truth()[i];
            mean[i] += off / f64::from(SEEDS);
            square += off * off / f64::from(4 * SEEDS);
        }
    }
    (mean.iter().fold(0.0, |m, x| m.max(x.abs())), square.sqrt())
}

#[test]
fn finds_a_without_bias_whatever_c_is() {
    let (_, short) = errors(4_000, 3);
    let (bias, long) = errors(64_000, 3);
    let (least_squares, _) = errors(64_000, 0);
    std::println!("rms {short:.5} {long:.5}, bias {bias:.6}, least squares {least_squares:.5}");
    // 16 times the samples, a quarter of the scatter; the mean of 40 within 4 of its
    // standard deviations.
    assert!((2.8..5.7).contains(&(short / long)), "{short} {long}");
    assert!((1e-4..2e-2).contains(&long), "{long}");
    assert!(bias < 4.0 * 2.0 * long / 40f64.sqrt(), "{bias}");
    // The same data without instruments: the bias stays.
    assert!(least_squares > 10.0 * bias, "{least_squares} {bias}");
}

#[test]
fn single_precision_stays_healthy_for_a_million_samples() {
    type Signal = fn(u32, f64) -> f64;
    let signals: [(&str, Signal); 4] = [
        ("white noise", |_, e| e),
        ("tone", |k, _| (f64::from(k) * 0.7).sin()),
        ("noise, then silence", |k, e| if k < 5000 { e } else { 0.0 }),
        (
            "full scale",
            |k, _| if k % 2 == 0 { 32768.0 } else { -32768.0 },
        ),
    ];
    for (name, signal) in signals {
        for forgetting in [1.0, 0.998] {
            let config = IvConfig {
                forgetting,
                ..IvConfig::default()
            };
            let mut model = RecursiveIv::<f32, 8>::new(8, 7, config).expect("order");
            let (mut seed, mut limited) = (1, 0u32);
            for k in 0..1_000_000 {
                let step = model.update(signal(k, noise(&mut seed)) as f32);
                limited += u32::from(step.status == Status::Limiting(Limit::Instruments));
                let sum: f32 = model.a().iter().sum();
                assert!(step.innovation.is_finite() && sum.is_finite(), "{name} {k}");
                assert!(model.gain.iter().flatten().all(|x| x.is_finite()));
            }
            std::println!("{name}, λ {forgetting}: held back {limited} times");
            // It still learns: two modes are read after what came before.
            for y in series(40_000, 5) {
                model.update(y as f32);
            }
            assert!(model.a().iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn forgetting_reads_a_signal_after_silence() {
    let config = IvConfig {
        forgetting: 0.9995,
        ..IvConfig::default()
    };
    let mut model = RecursiveIv::<f32, 4>::new(4, 3, config).expect("order");
    let mut seed = 9;
    for k in 0..60_000 {
        model.update(if k < 10_000 {
            100.0 * noise(&mut seed) as f32
        } else {
            0.0
        });
    }
    for y in series(20_000, 3) {
        model.update(y as f32);
    }
    for (found, wanted) in model.a().iter().zip(truth()) {
        assert!((f64::from(*found) - wanted).abs() < 0.1, "{found} {wanted}");
    }
}

#[test]
fn refuses_what_is_out_of_range() {
    let config = IvConfig::<f32>::default();
    assert!(RecursiveIv::<f32, 4>::new(0, 1, config).is_none());
    assert!(RecursiveIv::<f32, 4>::new(5, 1, config).is_none());
    assert!(RecursiveIv::<f32, 4>::new(4, 5, config).is_none());
    let bad = IvConfig {
        forgetting: f32::NAN,
        ..config
    };
    assert!(RecursiveIv::<f32, 4>::new(4, 3, bad).is_none());
    let mut model = RecursiveIv::<f32, 4>::new(2, 4, config).expect("order");
    for bad in [f32::NAN, f32::INFINITY, 1e15] {
        assert_eq!(model.update(bad).status, Status::Rejected);
    }
    assert_eq!(model.count(), 0);
}
