//! Channels against what made them: rotating states seen through known shapes. Nothing here
//! shares a formula with the estimator.

use super::*;

/// A mode: frequency in Hz, damping ratio, what each channel shows of it (real, imaginary).
type Truth = (f64, f64, Vec<(f64, f64)>);

const FS: f64 = 1000.0;

/// Two uniform numbers to two normal ones.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        // xorshift64*.
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> (f64, f64) {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let angle = core::f64::consts::TAU * self.uniform();
        (radius * angle.cos(), radius * angle.sin())
    }
}

/// y(t) = Σ Re(ψ·z(t)) + noise, z(t+1) = λ·z(t) + complex white noise, of unit mean square.
fn record(truth: &[Truth], n: usize, noise: f64, seed: u64) -> Vec<Vec<f64>> {
    let channels = truth[0].2.len();
    let mut random = Noise(0x9E37_79B9_7F4A_7C15 ^ (seed + 1).wrapping_mul(0xD134_2543_DE82_EF95));
    for _ in 0..20 {
        random.uniform();
    }
    let mut y = vec![vec![0.0; n]; channels];
    for (f, zeta, shape) in truth {
        let omega = core::f64::consts::TAU * f / FS;
        let radius = (-zeta * omega).exp();
        let angle = omega * (1.0 - zeta * zeta).sqrt();
        let (re, im) = (radius * angle.cos(), radius * angle.sin());
        let drive = (1.0 - radius * radius).sqrt();
        let mut z = random.normal();
        for t in 0..n {
            for (y, (a, b)) in y.iter_mut().zip(shape) {
                y[t] += a * z.0 - b * z.1;
            }
            let e = random.normal();
            z = (
                re * z.0 - im * z.1 + drive * e.0,
                im * z.0 + re * z.1 + drive * e.1,
            );
        }
    }
    for y in &mut y {
        y.iter_mut().for_each(|y| *y += noise * random.normal().0);
    }
    y
}

/// A supported beam of five sensors: mode k bends as sin(kπx).
fn beam() -> Vec<Truth> {
    let at = |k: f64, x: f64| ((k * core::f64::consts::PI * x).sin(), 0.0);
    let places = [1.0, 2.0, 3.0, 4.0, 5.0].map(|i| i / 6.0);
    [(40.0, 0.02), (160.0, 0.01), (310.0, 0.015)]
        .iter()
        .zip([1.0, 2.0, 3.0])
        .map(|((f, zeta), k)| (*f, *zeta, places.iter().map(|x| at(k, *x)).collect()))
        .collect()
}

/// Shapes that do not stand still: three sensors, phases all round.
fn travelling() -> Vec<Truth> {
    vec![
        (90.0, 0.02, vec![(1.0, 0.0), (0.3, 0.6), (-0.5, 0.2)]),
        (140.0, 0.03, vec![(0.2, -0.4), (1.0, 0.0), (0.1, 0.7)]),
    ]
}

fn subspace(y: &[Vec<f64>], config: SubspaceConfig) -> Subspace {
    let channels: Vec<&[f64]> = y.iter().map(Vec::as_slice).collect();
    let references: Vec<usize> = (0..y.len()).collect();
    Subspace::of(&channels, &references, config).expect("decomposed")
}

/// The modes nearest to the true ones, in their order.
fn nearest(modes: &[ChannelMode], truth: &[Truth]) -> Vec<ChannelMode> {
    truth
        .iter()
        .map(|(f, ..)| {
            let off = |m: &&ChannelMode| (m.frequency - f).abs();
            let found = modes.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            found.expect("a mode").clone()
        })
        .collect()
}

#[test]
fn shapes_of_a_beam_are_found_in_noise() {
    let truth = beam();
    for seed in 0..5 {
        let y = record(&truth, 20_000, 0.2, seed);
        let modes = subspace(&y, SubspaceConfig::default())
            .modes(6, FS)
            .expect("modes");
        assert_eq!(modes.len(), 3);
        for (mode, (f, zeta, shape)) in modes.iter().zip(&truth) {
            assert!(
                (mode.frequency - f).abs() < 4.5 * mode.frequency_sd,
                "{mode:?}"
            );
            assert!(
                (mode.damping - zeta).abs() < 4.5 * mode.damping_sd,
                "{mode:?}"
            );
            assert!(mac(&mode.pairs(), shape) >= 0.99, "{mode:?}");
            // The nodes of the bent shape do not count for the others.
            for (a, _, other) in &truth {
                let same = (*a - f).abs() < 1.0;
                assert!(same || mac(&mode.pairs(), other) < 0.05, "{mode:?}");
            }
        }
    }
}

/// Two-sided: of 200 records the interval of ±1.96 deviations holds the truth in about 95 %, for
/// frequency, damping, and magnitude and phase of the channels that are not the reference.
#[test]
fn deviations_are_those_of_many_records() {
    let truth = travelling();
    const RECORDS: u64 = 200;
    let mut held = [0.0f64; 4];
    let mut all = [0.0f64; 4];
    for seed in 0..RECORDS {
        let y = record(&truth, 16_000, 0.1, 1000 + seed);
        let modes = subspace(&y, SubspaceConfig::default())
            .modes(4, FS)
            .expect("modes");
        for (mode, (f, zeta, shape)) in nearest(&modes, &truth).iter().zip(&truth) {
            let mut count = |k: usize, off: f64, sd: f64| {
                all[k] += 1.0;
                held[k] += f64::from(u8::from(off.abs() <= 1.96 * sd));
            };
            count(0, mode.frequency - f, mode.frequency_sd);
            count(1, mode.damping - zeta, mode.damping_sd);
            for (part, (re, im)) in mode.shape.iter().zip(shape) {
                if part.magnitude() < 1.0 - 1e-9 {
                    count(
                        2,
                        part.magnitude() - libm::hypot(*re, *im),
                        part.magnitude_sd,
                    );
                    let turn = part.phase() - libm::atan2(*im, *re);
                    count(
                        3,
                        libm::remainder(turn, core::f64::consts::TAU),
                        part.phase_sd,
                    );
                }
            }
        }
    }
    let share: Vec<f64> = held.iter().zip(&all).map(|(h, a)| h / a).collect();
    println!("f, ζ, magnitude, phase are held in {share:.3?} of {all:?}");
    for share in share {
        assert!((0.92..=0.98).contains(&share), "{share}");
    }
}
