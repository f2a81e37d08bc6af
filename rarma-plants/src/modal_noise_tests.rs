use super::*;

fn one(quantity: Quantity, seed: u64) -> ModalNoiseConfig {
    ModalNoiseConfig {
        fs_hz: 5000.0,
        modes: vec![NoiseMode {
            f_hz: 980.0,
            zeta: 0.02,
            rms: 3.0,
        }],
        drive: Drive::Independent,
        quantity,
        snr_db: None,
        seed,
    }
}

fn three(drive: Drive) -> ModalNoiseConfig {
    let m = |f_hz, zeta, rms| NoiseMode { f_hz, zeta, rms };
    ModalNoiseConfig {
        modes: vec![
            m(540.0, 0.03, 1.0),
            m(980.0, 0.02, 2.0),
            m(1710.0, 0.05, 0.7),
        ],
        drive,
        ..one(Quantity::Displacement, 5)
    }
}

#[test]
fn autocovariance_matches_closed_form() {
    // R(τ) = rms²·e^(-ζωτ)(cos ωdτ ± ζ/√(1-ζ²)·sin ωdτ), + for displacement.
    for (quantity, sign) in [(Quantity::Displacement, 1.0), (Quantity::Velocity, -1.0)] {
        let noise = ModalNoise::new(one(quantity, 1)).expect("valid");
        let (w, z) = (TAU * 980.0, 0.02_f64);
        let root = (1.0 - z * z).sqrt();
        for (k, got) in noise.autocovariance(200).iter().enumerate() {
            let t = k as f64 / 5000.0;
            let (s, c) = (w * root * t).sin_cos();
            let want = 9.0 * (-z * w * t).exp() * (c + sign * z / root * s);
            assert!((got - want).abs() < 1e-10, "lag {k}: {got} {want}");
        }
    }
}

#[test]
fn poles_annihilate_the_autocovariance() {
    // For ARMA(p, p-1) the sum of a_i·R(k-i) vanishes from lag p on, not at p-1.
    for drive in [Drive::Independent, Drive::Common] {
        let noise = ModalNoise::new(three(drive)).expect("valid");
        let mut a = vec![1.0];
        for pole in noise.true_poles() {
            let factor = [1.0, -2.0 * pole.re, pole.re * pole.re + pole.im * pole.im];
            let mut next = vec![0.0; a.len() + 2];
            for (i, x) in a.iter().enumerate() {
                for (j, y) in factor.iter().enumerate() {
                    next[i + j] += x * y;
                }
            }
            a = next;
        }
        let r = noise.autocovariance(40);
        let sum = |k: usize| -> f64 {
            a.iter()
                .enumerate()
                .map(|(i, ai)| ai * r[k.abs_diff(i)])
                .sum()
        };
        assert_eq!(noise.arma_order(), (6, 5));
        for k in 6..=40 {
            assert!(sum(k).abs() < 1e-10, "lag {k}: {}", sum(k));
        }
        assert!(sum(5).abs() > 1e-3);
    }
}

#[test]
fn samples_have_the_variance_and_correlation_of_theory() {
    for config in [three(Drive::Independent), three(Drive::Common)] {
        let mut noise = ModalNoise::new(config).expect("valid");
        let want = noise.autocovariance(20);
        let n = 400_000;
        let y: Vec<f64> = noise.by_ref().take(n).collect();
        for k in [0, 1, 3, 7, 20] {
            let got = y.iter().zip(&y[k..]).map(|(a, b)| a * b).sum::<f64>() / (n - k) as f64;
            // The correlation time of about 8 ms leaves 5000 independent
            // samples: a standard deviation near 2 % of R(0) at most.
            assert!(
                (got - want[k]).abs() < 0.06 * want[0],
                "lag {k}: {got} {}",
                want[k]
            );
        }
    }
}

#[test]
fn measurement_noise_has_the_asked_level() {
    let mut config = one(Quantity::Displacement, 2);
    config.snr_db = Some(10.0);
    let noise = ModalNoise::new(config).expect("valid");
    assert!((noise.autocovariance(0)[0] - 9.0 * 1.1).abs() < 1e-9);
    assert_eq!(noise.arma_order(), (2, 2));
}

#[test]
fn seeds_repeat_to_the_bit_and_differ() {
    let run = |seed| -> Vec<u64> {
        let noise = ModalNoise::new(one(Quantity::Velocity, seed)).expect("valid");
        noise.take(2000).map(f64::to_bits).collect()
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn retuning_moves_the_poles_and_keeps_the_state() {
    let mut noise = ModalNoise::new(one(Quantity::Displacement, 3)).expect("valid");
    noise.next_sample();
    let before = noise.state.clone();
    let softer = [NoiseMode {
        f_hz: 980.0,
        zeta: 0.001,
        rms: 3.0,
    }];
    noise.retune(&softer).expect("valid");
    assert_eq!(before, noise.state);
    assert_eq!(noise.true_poles()[0].zeta, 0.001);
    assert!(noise.retune(&[]).is_err());
}
