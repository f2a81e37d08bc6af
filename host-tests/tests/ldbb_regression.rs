//! Promise: the regression of deflection on force gives a stiffness without bias, and the
//! uncertainty it states is honest.
//!
//! `cargo test --release -p host-tests --test ldbb_regression -- --nocapture`

use host_tests::ldbb::m3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_rigs::ldbb::{Harmonics, StiffnessMap, Trace};

/// Gauge noise only, 400 tests: how often k ± 1.96·u(k) holds the truth.
#[test]
fn the_uncertainty_is_honest() {
    const BINS: usize = 180;
    let machine = m3().machine;
    let forces = [36.4, 112.0, 238.0, 364.0, 490.0, 616.0, 742.0, 868.0];
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let places = [0, 37, 60, 103, 150];
    let (mut raw, mut smooth) = ([0u32; 5], [0u32; 5]);
    let mut u = 0.0;
    for _ in 0..400 {
        let mut map = Box::new(StiffnessMap::<f64, BINS>::default());
        for f in forces {
            let mut trace = Trace::<f64, BINS>::default();
            for k in 0..BINS {
                let theta = Trace::<f64, BINS>::angle(k);
                let e: f64 = StandardNormal.sample(&mut rng);
                let dr = 3e-6 * theta.cos() + machine.compliance(theta, 0.0) * f + 0.5e-6 * e;
                assert!(trace.add(theta, dr));
            }
            map.add(&trace, f).expect("finite");
        }
        let all: Vec<_> = map.directions(0.0).expect("eight forces").collect();
        let pairs = all
            .iter()
            .map(|d| (d.angle_rad, d.compliance_m_per_n.value));
        let h = Harmonics::fit(pairs, 6).expect("whole circle");
        for (i, &k) in places.iter().enumerate() {
            let d = &all[k];
            let truth = machine.stiffness_n_per_m.at(d.angle_rad);
            let (v, sd) = (d.stiffness_n_per_m.value, d.stiffness_n_per_m.sd);
            raw[i] += u32::from((v - truth).abs() < 1.96 * sd);
            let c = h.at(d.angle_rad);
            let sd = h.sd_at(d.angle_rad, d.compliance_m_per_n.sd) / (c * c);
            smooth[i] += u32::from((1.0 / c - truth).abs() < 1.96 * sd);
            u = sd.max(u);
        }
    }
    // σ = 0.5 µm a bin: u(k) = 0.088 N/µm at 11.8 N/µm.
    println!(
        "held of 400: raw {raw:?}, smoothed {smooth:?}; largest smoothed u(k) {:.4} N/µm",
        1e-6 * u
    );
    for h in raw.iter().chain(&smooth) {
        assert!((368..=388).contains(h), "{raw:?} {smooth:?}");
    }
}

#[test]
fn regression_the_other_way_round_is_biased() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let forces = [36.4, 112.0, 238.0, 364.0, 490.0, 616.0, 742.0, 868.0];
    let mean_f = forces.iter().sum::<f64>() / 8.0;
    let (mut ours, mut other) = (0.0, 0.0);
    let n = 20_000;
    for _ in 0..n {
        let r = forces.map(|f| {
            let e: f64 = StandardNormal.sample(&mut rng);
            f / 11.8e6 + 1.5e-6 * e
        });
        let mean_r = r.iter().sum::<f64>() / 8.0;
        let (mut ff, mut fr, mut rr) = (0.0, 0.0, 0.0);
        for (f, r) in forces.iter().zip(&r) {
            ff += (f - mean_f) * (f - mean_f);
            fr += (f - mean_f) * (r - mean_r);
            rr += (r - mean_r) * (r - mean_r);
        }
        ours += fr / ff / f64::from(n);
        other += fr / rr / f64::from(n);
    }
    let (ours, other) = (1.0 / ours / 11.8e6 - 1.0, other / 11.8e6 - 1.0);
    println!(
        "bias: deflection on force {:.3} %, force on deflection {:.3} %",
        100.0 * ours,
        100.0 * other
    );
    assert!(ours.abs() < 3e-4);
    assert!((-0.0035..-0.0015).contains(&other));
}
