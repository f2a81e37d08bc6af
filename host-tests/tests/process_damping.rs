//! Promise: against the modes of the structure, what the process adds to the damping
//! or takes from it is read off the cut.
//!
//! Two truths. The root of the delay equation, s² + 2ζωs + ω² + (Ks·b/m)(1 − e^(−sτ)) = 0,
//! tells how a disturbance dies away. A model of a few parameters fits the spectrum, and
//! that lies on the axis s = jω, where the delay adds Ks·b/(2k)·sin(ωτ) to ζ. The two
//! part as the damping grows, for e^(−sτ) grows with it: a reading holds to the second.
//!
//! `cargo test --release -p host-tests --test process_damping -- --nocapture` prints
//! the table.

use host_tests::files::{FLOAT, Folder, wav};
use host_tests::rarma;
use host_tests::statistics::{quantile, rms};
use rarma_plants::cut::Process;
use rarma_plants::process::Schedule;
use rarma_plants::truth::roots;
use rarma_scenarios::ear::{self, Forced};
use rarma_scenarios::scenario::{self, Loaded};
use std::path::{Path, PathBuf};

/// Of the modes as the cut begins, left out, s.
const SETTLE_S: f64 = 1.0;
const SECONDS: f64 = 8.0;
/// The only mode of the machine.
const MODE: (f64, f64) = (980.0, 0.02);

/// A cut at a constant depth as a recording.
fn record(folder: &Folder, loaded: &Loaded, process: &Process, depth_m: f64, seed: u64) -> PathBuf {
    let cut = ear::held(loaded, process, depth_m, SECONDS, seed);
    let heard = ear::hear(&cut, loaded.band(), Forced::Kept).expect("a cut");
    let data: Vec<u8> = heard
        .samples
        .iter()
        .flat_map(|x| (*x as f32).to_le_bytes())
        .collect();
    folder.file("cut.wav", &wav(FLOAT, 1, heard.fs as u32, 32, &data))
}

/// ζ_process and its deviation, line by line, of the modes that have one.
fn read(file: &Path, structure: &Path) -> Vec<(f64, f64)> {
    let options = format!(
        "--json --order 6,5 --band 600:1400 --structure {}",
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
    let Process::Turning(config) = &loaded.scenario.process else {
        panic!("a lathe")
    };
    let compliance = config.ks_n_per_m2 / config.modes[0].stiffness_n_per_m;
    println!("vibrations   depth   root      at jω     read      median   spread");
    println!("a turn       mm      %         %         %         sd, %    of (read − jω)/sd");
    // A quarter turn of phase behind the last cut the process damps, three quarters
    // behind it feeds. So few vibrations lie between two cuts that no other root of the
    // delay is lightly damped in the band.
    for (vibrations, phase, depths) in [
        (2.25, 1.0, [0.001, 0.06, 0.12]),
        (2.75, -1.0, [0.06, 0.12, 0.18]),
    ] {
        let process = loaded.scenario.process.at_spindle_hz(MODE.0 / vibrations);
        for depth_mm in depths {
            let depth = 1e-3 * depth_mm;
            let all = roots(&process, 0.0, depth, 40).expect("roots");
            let near = ear::dominant(&process.at_depth(Schedule::constant(depth)), &all);
            let [root] = near[..] else { panic!("{near:?}") };
            let root = root.zeta - MODE.1;
            let axis = 0.5 * compliance * depth * phase;
            let mut all = Vec::new();
            for seed in 1..=2 {
                let file = record(&folder, &loaded, &process, depth, seed);
                all.extend(read(&file, &structure));
            }
            assert!(all.len() > 1450, "read in {} lines of 1500", all.len());
            let zeta: Vec<f64> = all.iter().map(|x| x.0).collect();
            let sd: Vec<f64> = all.iter().map(|x| x.1).collect();
            let off: Vec<f64> = all.iter().map(|(z, sd)| (z - axis) / sd).collect();
            let (median, spread) = (quantile(&zeta, 0.5), rms(&off));
            println!(
                "{vibrations:<12} {depth_mm:.3}   {:+.3}    {:+.3}    {:+.3}    {:.3}    {spread:.2}",
                100.0 * root,
                100.0 * axis,
                100.0 * median,
                100.0 * quantile(&sd, 0.5),
            );
            // Against what a linear model of the signal can read, to 0.2 % of damping;
            // against the root, the sign and two thirds of the size.
            assert!((median - axis).abs() < 0.002, "{median} {axis}");
            if root.abs() > 0.002 {
                let ratio = median / root;
                assert!((0.6..1.1).contains(&ratio), "{median} of {root}");
            }
            assert!((0.6..1.7).contains(&spread), "{spread}");
        }
    }
}

/// What `rarma identify --json` writes is a structure as it is.
#[test]
fn an_identified_structure_is_taken_as_it_is() {
    let loaded = scenario::load("turning-980", None).expect("a shipped scenario");
    let folder = Folder::default();
    // Air: nothing but the background force on the bare mode.
    let process = &loaded.scenario.process;
    let file = record(&folder, &loaded, process, 0.0, 3);
    let at_rest = rarma!().on("identify", &file, "--order 4,4 --json");
    assert_eq!(at_rest.code, Some(0), "{at_rest:?}");
    let structure = folder.file("at-rest.json", at_rest.stdout.as_bytes());
    let modes = at_rest.json()["modes"].clone();
    println!("{modes}");
    // The first is the high-pass of the band, at half of critical damping.
    let of = |m: &serde_json::Value, key: &str| m[key].as_f64().expect("a number");
    let all = modes.as_array().expect("modes").iter();
    let nearest = all.min_by(|a, b| {
        let off = |m| (of(m, "f") - MODE.0).abs();
        off(a).total_cmp(&off(b))
    });
    let zeta = of(nearest.expect("a mode"), "zeta");
    // Three of its standard deviations of 0.06 %.
    assert!((zeta - MODE.1).abs() < 0.002, "{modes}");
    let depth = 1.2e-4;
    let process = process.at_spindle_hz(MODE.0 / 2.75);
    let cut = record(&folder, &loaded, &process, depth, 4);
    let read: Vec<f64> = read(&cut, &structure).iter().map(|x| x.0).collect();
    let median = quantile(&read, 0.5);
    println!("{:+.3} % in the cut", 100.0 * median);
    assert!((-0.015..-0.005).contains(&median), "{median}");
}
