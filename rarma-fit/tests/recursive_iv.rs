//! Promise: instrumental variables over a whole series agree with the recursion of the listener.

use rarma_core::estimate::{IvConfig, RecursiveIv};
use rarma_fit::{ArFit, instrumental_variables};

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

#[test]
fn agrees_with_the_recursion() {
    for seed in [1, 2, 3] {
        let y = series(20_000, seed);
        let model = fitted(&y, 4, 3);
        let batch: ArFit<f64, 4> = instrumental_variables(&y, 4, 3, 4).expect("regular");
        for i in 0..4 {
            let off = (model.a()[i] - batch.a()[i]).abs();
            let error = (batch.a()[i] - truth()[i]).abs();
            std::println!("a{}: apart {off:.2e}, error {error:.2e}", i + 1);
            // Apart by the first samples and the last: a few in 20 000.
            assert!((1e-9..2e-3).contains(&off), "a{}: {off}", i + 1);
        }
    }
}
