//! Promise: over rising orders the modes of the structure are marked stable, and what
//! a model of too high an order makes up is not.
//!
//! Three modes, 4000 samples, `Pem` from (6,5) to (9,8), each against the order below.
//! Print the shares with
//! `cargo test --release -p host-tests --test stabilisation -- --nocapture`.

use host_tests::signal;
use rarma_core::spectrum::{FactorTracker, Modal, modal};
use rarma_fit::{Pem, PemConfig};
use rarma_fit::{StabilisationConfig, Stability, stabilise};

const FS: f64 = 5000.0;
const MODES: [(f64, f64); 3] = [(450.0, 0.03), (980.0, 0.02), (1500.0, 0.025)];
const SEEDS: u64 = 30;
const N: usize = 17;

fn modes_of(x: &[f64], p: usize) -> Vec<Modal<f64>> {
    let pem = Pem::new(PemConfig::default()).expect("settings");
    let fit = pem.fit::<N>(x, p, p - 1).expect("a model");
    let mut roots = FactorTracker::<f64, N>::new();
    roots.solve(fit.a(), 4000).expect("roots");
    let factors = roots.factors(p).iter();
    factors.filter_map(|factor| modal(factor, FS)).collect()
}

/// How the modes near a true one, and those that are not, were marked.
#[derive(Default)]
struct Count {
    seen: f64,
    in_f: f64,
    stable: f64,
}

#[test]
fn true_modes_stabilise_and_made_up_ones_do_not() {
    let mut counts = [Count::default(), Count::default()];
    for seed in 0..SEEDS {
        let x: Vec<f64> = signal::modes(&MODES, FS, 40 + seed).take(4000).collect();
        let mut below = modes_of(&x, 6);
        for p in 7..10 {
            let modes = modes_of(&x, p);
            let mut marks = vec![Stability::New; modes.len()];
            let config = StabilisationConfig::default();
            stabilise(&config, &below, &modes, &mut marks).expect("modes");
            for (mode, mark) in modes.iter().zip(marks) {
                let near = |(f, _): &(f64, f64)| (mode.frequency / f - 1.0).abs() < 0.03;
                let count = &mut counts[usize::from(!MODES.iter().any(near))];
                count.seen += 1.0;
                count.in_f += f64::from(u8::from(mark != Stability::New));
                count.stable += f64::from(u8::from(mark == Stability::Stable));
            }
            below = modes;
        }
    }
    let shares = |c: &Count| (c.stable / c.seen, c.in_f / c.seen);
    let [(stable, in_f), (made_up, made_up_f)] = [&counts[0], &counts[1]].map(shares);
    println!(
        "{SEEDS} seeds; true: {} seen, stable {stable:.3}, in f {in_f:.3}; made up: {} seen, stable {made_up:.3}, in f {made_up_f:.3}",
        counts[0].seen, counts[1].seen
    );
    // 0.897 and 0.996, of 271; 0.077 and 0.173, of 52: two sampling errors either way.
    assert!(
        (0.86..0.94).contains(&stable) && (0.985..=1.0).contains(&in_f),
        "{stable} {in_f}"
    );
    assert!(
        (0.01..0.15).contains(&made_up) && (0.07..0.28).contains(&made_up_f),
        "{made_up} {made_up_f}"
    );
    assert!(counts[1].seen > 20.0, "nothing made up to be told apart");
    // Three true ones at each of three orders, neither lost nor doubled often.
    let each = counts[0].seen / (9.0 * SEEDS as f64);
    assert!((0.97..1.05).contains(&each), "{each}");
}
