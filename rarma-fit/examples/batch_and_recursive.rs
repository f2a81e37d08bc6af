//! The same series by a fit of the whole recording and by the recursion, beside the least deviation
//! that any estimator can have.
//!
//! ```sh
//! cargo run --release -p rarma-fit --example batch_and_recursive
//! ```

use rarma_core::prelude::*;
use rarma_fit::{Bound, FitError, Pem, PemConfig};

const FS_HZ: f64 = 6000.0;
const SAMPLES: usize = 6000;
/// Frequency, Hz, and damping ratio.
const MODE: (f64, f64) = (900.0, 0.02);
/// C = 1 + 0.5 q⁻¹.
const C: f64 = 0.5;

fn main() -> Result<(), FitError> {
    let w = core::f64::consts::TAU * MODE.0 / FS_HZ;
    let (radius, angle) = ((-MODE.1 * w).exp(), w * (1.0 - MODE.1 * MODE.1).sqrt());
    let a = [-2.0 * radius * angle.cos(), radius * radius];
    let bound = Bound::<f64, 3>::of(&a, &[C])?
        .mode(MODE.0, MODE.1, FS_HZ, SAMPLES)
        .ok_or(FitError::NotStable)?;
    println!(
        "one second of {} Hz, ζ {} %, seen by ARMA(2,1)\n",
        MODE.0,
        100.0 * MODE.1
    );
    println!("seed   batch: f, Hz   ζ, %          recursive: f, Hz   ζ, %");
    for seed in 1..=8 {
        let y = series(&a, seed);
        let fit = Pem::new(PemConfig::default())?.fit::<3>(&y, 2, 1)?;
        let batch = mode_of(fit.a());
        // No forgetting: all samples count alike, as in the batch fit.
        let mut model = Arma21::<f64>::new(RarmaConfig {
            forgetting: 1.0,
            ..RarmaConfig::default()
        });
        for y in y {
            model.update(y);
        }
        let recursive = mode_of(model.a());
        println!(
            "{seed:4} {:13.2} {:8.3} {:21.2} {:8.3}",
            batch.frequency,
            100.0 * batch.damping,
            recursive.frequency,
            100.0 * recursive.damping
        );
    }
    println!(
        "\nno estimator scatters by less than ± {:.2} Hz and ± {:.3} %",
        bound.frequency,
        100.0 * bound.damping
    );
    Ok(())
}

/// The mode of A with its leading 1 left out.
fn mode_of(a: &[f64]) -> Modal<f64> {
    let pole = Quadratic { u: -a[0], v: a[1] };
    modal(&pole, FS_HZ).expect("a vibration")
}

/// ARMA(2,1) of white normal noise.
fn series(a: &[f64; 2], seed: u32) -> Vec<f64> {
    let mut seed = seed.wrapping_mul(2_654_435_769);
    let mut uniform = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / 16_777_216.0
    };
    let (mut y1, mut y2, mut e1) = (0.0, 0.0, 0.0);
    (0..SAMPLES)
        .map(|_| {
            // Twelve uniform numbers are next to a normal one.
            let e = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
            let y = e + C * e1 - a[0] * y1 - a[1] * y2;
            (y2, y1, e1) = (y1, y, e);
            y
        })
        .collect()
}
