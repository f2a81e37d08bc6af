//! How fast: the whole of `rarma monitor` against real time, and the estimator's
//! nanoseconds per sample.
//!
//! `cargo bench -p host-tests`. Figures are of the machine they are run on.

use divan::{Bencher, black_box};
use host_tests::files::Folder;
use host_tests::{rarma, signal};
use rarma_cli::commands;
use rarma_core::estimate::{RarmaConfig, RecursiveArma};
use rarma_core::monitor::MonitorConfig;
use rarma_core::spectrum::FactorTracker;
use rarma_core::wire::MonitorJob;
use std::sync::LazyLock;
use std::time::Instant;

const FS: u32 = 48_000;
const SECONDS: usize = 60;

/// A minute of three modes, as a microphone hears them.
static SOUND: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let modes = [(600.0, 0.03), (900.0, 0.01), (1900.0, 0.02)];
    signal::modes(&modes, f64::from(FS), 1)
        .map(|x| (0.1 * x) as f32)
        .take(SECONDS * FS as usize)
        .collect()
});

fn main() {
    whole_program();
    divan::main();
}

/// From the file to the last line of JSON, as a user runs it; best of five.
fn whole_program() {
    let folder = Folder::default();
    let samples: Vec<f64> = SOUND.iter().map(|&x| f64::from(x)).collect();
    let file = folder.pcm16("minute.wav", FS, &samples);
    for options in ["--json", "--order 2,1 --json"] {
        let best = (0..5)
            .map(|_| {
                let begun = Instant::now();
                let ended = rarma!().on("monitor", &file, options);
                assert!(matches!(ended.code, Some(0 | 1)), "{ended:?}");
                begun.elapsed().as_secs_f64()
            })
            .fold(f64::INFINITY, f64::min);
        println!(
            "rarma monitor {options} on {SECONDS} s at {FS} Hz: {best:.3} s, {:.0} times faster than real time",
            SECONDS as f64 / best
        );
    }
}

/// The monitor alone at order (8,7), a minute of sound.
#[divan::bench(sample_count = 10)]
fn listen_to_a_minute(bencher: Bencher<'_, '_>) {
    let job = MonitorJob {
        monitor: MonitorConfig::new(f64::from(FS)),
        channel: 0,
        every_s: 0.01,
    };
    bencher
        .counter(divan::counter::ItemsCount::new(SOUND.len()))
        .bench(|| commands::listen(&job, SOUND.iter().copied(), |_| {}).map(|run| run.summary));
}

macro_rules! orders {
    ($($update:ident $roots:ident $p:literal $q:literal $n:literal;)*) => {$(
        #[divan::bench]
        fn $update(bencher: Bencher<'_, '_>) {
            one::<$p, $q, $n>(bencher, false);
        }

        #[divan::bench]
        fn $roots(bencher: Bencher<'_, '_>) {
            one::<$p, $q, $n>(bencher, true);
        }
    )*};
}

orders! {
    update_21 update_and_roots_21 2 1 3;
    update_22 update_and_roots_22 2 2 4;
    update_43 update_and_roots_43 4 3 7;
    update_44 update_and_roots_44 4 4 8;
    update_65 update_and_roots_65 6 5 11;
    update_66 update_and_roots_66 6 6 12;
    update_87 update_and_roots_87 8 7 15;
    update_88 update_and_roots_88 8 8 16;
}

/// One block of samples through a model that is past its start-up; items are
/// samples, so that the reciprocal of the rate is the time per sample.
fn one<const P: usize, const Q: usize, const N: usize>(bencher: Bencher<'_, '_>, roots: bool) {
    const BLOCK: usize = 1000;
    let modes = [(600.0, 0.03), (900.0, 0.01), (1900.0, 0.02)];
    let mut sound = signal::modes(&modes, 6000.0, 2).map(|x| x as f32);
    let config = RarmaConfig {
        forgetting: 0.998,
        ..RarmaConfig::default()
    };
    let mut model = RecursiveArma::<f32, P, Q, N>::new(config);
    let mut tracker = FactorTracker::<f32, P>::new();
    for y in sound.by_ref().take(5000) {
        model.update(y);
        tracker.track(model.a());
    }
    let block: Vec<f32> = sound.take(BLOCK).collect();
    bencher
        .counter(divan::counter::ItemsCount::new(BLOCK))
        .bench_local(|| {
            for &y in &block {
                model.update(black_box(y));
                if roots {
                    tracker.track(model.a());
                }
            }
            black_box(tracker.factors(P)[0].u + model.a()[0])
        });
}
