//! Promise: against the modes of the structure, what the process adds to the damping
//! or takes from it is read off the cut: as the delay equation has it.
//!
//! `cargo test --release -p host-tests --test process_damping -- --nocapture` prints
//! the table.

use hal_sim::plant::cut::Process;
use hal_sim::plant::process::Schedule;
use hal_sim::plant::truth::roots;
use host_tests::files::{FLOAT, Folder, wav};
use host_tests::rarma;
use host_tests::statistics::quantile;
use rarma_cli::ear::{self, Forced};
use rarma_cli::scenario::{self, Loaded};
use std::path::{Path, PathBuf};

/// Of the modes as the cut begins, left out, s.
const SETTLE_S: f64 = 1.0;
const SECONDS: f64 = 8.0;
/// The only mode of the machine.
const MODE: (f64, f64) = (980.0, 0.02);

/// A cut at a constant depth as a recording.
fn record(folder: &Folder, loaded: &Loaded, process: &Process, depth_m: f64, seed: u64) -> PathBuf {
    let cut = ear::held(loaded, process, depth_m, SECONDS, seed);
    let heard = ear::hear(&cut, ear::band(loaded), Forced::Kept).expect("a cut");
    let data: Vec<u8> = heard
        .samples
        .iter()
        .flat_map(|x| (*x as f32).to_le_bytes())
        .collect();
    folder.file("cut.wav", &wav(FLOAT, 1, heard.fs as u32, 32, &data))
}

/// ζ_process and its deviation, line by line, of the modes that have one.
fn read(file: &Path, structure: &Path, order: &str) -> Vec<(f64, f64)> {
    let options = format!(
        "--json --order {order} --band 600:1400 --structure {}",
        structure.display()
    );
    let (lines, _) = rarma!().on("monitor", file, &options).monitored();
    lines
        .iter()
        .filter(|l| l["t"].as_f64().is_some_and(|t| t > SETTLE_S))
        .filter_map(|l| {
            let modes = l["modes"].as_array().expect("modes");
            modes
                .iter()
                .filter_map(|m| Some((m["zeta_process"].as_f64()?, m["zeta_process_sd"].as_f64()?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
        })
        .collect()
}

#[test]
fn what_the_process_adds_is_read_off_the_cut() {
    let loaded = scenario::load("turning-980", None).expect("a shipped scenario");
    let folder = Folder::default();
    let structure = folder.file(
        "structure.json",
        format!(
            r#"{{"modes": [{{"f": {}, "f_sd": 0.5, "zeta": {}, "zeta_sd": 0.0002}}]}}"#,
            MODE.0, MODE.1
        )
        .as_bytes(),
    );
    println!("vibrations   depth   order   true      read     median sd");
    println!("a turn       mm              %         %        %");
    // A quarter turn of phase behind the last cut the process damps, three quarters
    // behind it feeds: Δζ ≈ Ks·b/(2k)·sin(ωτ). So few vibrations lie between two cuts
    // that no other root of the delay is in the band.
    for (vibrations, depths) in [(2.25, [0.06, 0.12, 0.20]), (2.75, [0.06, 0.12, 0.18])] {
        let process = loaded.scenario.process.at_spindle_hz(MODE.0 / vibrations);
        for depth_mm in depths {
            let depth = 1e-3 * depth_mm;
            let all = roots(&process, 0.0, depth, 40).expect("roots");
            let near = ear::dominant(&process.at_depth(Schedule::constant(depth)), &all);
            let [root] = near[..] else { panic!("{near:?}") };
            let truth = root.zeta - MODE.1;
            for order in ["2,1", "2,2", "4,3"] {
                let mut all = Vec::new();
                for seed in 1..=2 {
                    let file = record(&folder, &loaded, &process, depth, seed);
                    all.extend(read(&file, &structure, order));
                }
                let zeta: Vec<f64> = all.iter().map(|x| x.0).collect();
                let sd: Vec<f64> = all.iter().map(|x| x.1).collect();
                println!(
                    "{vibrations:<12} {depth_mm:.2}    {order}   {:+.3}    {:+.3}    {:.3} {}",
                    100.0 * truth,
                    100.0 * quantile(&zeta, 0.5),
                    100.0 * quantile(&sd, 0.5),
                    zeta.len()
                );
            }
        }
    }
}
