//! How fast: the whole of `rarma monitor` against real time.
//!
//! `cargo bench -p host-tests --bench monitor`. Figures are of the machine they are
//! run on.

use divan::Bencher;
use host_tests::files::Folder;
use host_tests::{rarma, signal};
use rarma_box::wire::MonitorJob;
use rarma_cli::commands;
use rarma_core::monitor::MonitorConfig;
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
