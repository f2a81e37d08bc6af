//! Promise: two sensors call as soon as one, never twice, and one that fails is named
//! and left out, at no cost to the other.
//!
//! `cargo test --release -p host-tests --test two_sensors -- --nocapture` prints the
//! tables.

use host_tests::bars::{all_judged, holds};
use host_tests::files::{FLOAT, Folder, wav};
use host_tests::resources::{Known, shared_or_skip};
use host_tests::statistics::{quantile, rms};
use host_tests::{rarma, signal};
use rarma_core::Monitor;
use rarma_core::condition::Fault;
use rarma_core::decide::{AlarmEvent, ChannelFault};
use rarma_core::monitor::{MonitorConfig, PairConfig, PairMonitor};
use rarma_plants::modal_noise::{ModalNoise, ModalNoiseConfig, NoiseMode};
use rarma_plants::sound::Pickup;
use rarma_scenarios::ear::{self, Forced};
use rarma_scenarios::scenario;
use serde_json::Value;
use std::collections::BTreeMap;

const FS: f64 = 8000.0;
/// A mode loses its damping at this time, s.
const ONSET_S: f64 = 2.0;
const SECONDS: f64 = 4.0;

/// Modes at 900 and 1700 Hz; the lower one falls from `stable` to 0.1 % at the onset,
/// under forces that stay what they are. Unit variance before it.
fn machine(stable: f64, onset_s: f64, seconds: f64, seed: u64) -> Vec<f64> {
    let modes = |zeta: f64| {
        [(900.0, zeta, 0.8), (1700.0, 0.03, 0.6)].map(|(f_hz, z, share)| NoiseMode {
            f_hz,
            zeta: z,
            rms: share
                * (if f_hz < 1000.0 {
                    (stable / z).sqrt()
                } else {
                    1.0
                }),
        })
    };
    let mut plant = ModalNoise::new(ModalNoiseConfig {
        fs_hz: FS,
        modes: modes(stable).to_vec(),
        drive: Default::default(),
        quantity: Default::default(),
        snr_db: None,
        seed,
    })
    .expect("modes in range");
    (0..(seconds * FS) as usize)
        .map(|n| {
            if n == (onset_s * FS) as usize {
                plant.retune(&modes(0.001)).expect("modes in range");
            }
            plant.next_sample()
        })
        .collect()
}

/// `gain` times the vibration, and noise of its own `db` below the vibration.
fn sensor(vibration: &[f64], gain: f64, db: f64, seed: u64) -> Vec<f64> {
    let noise = gain.abs() * rms(vibration) * 10f64.powf(-db / 20.0);
    vibration
        .iter()
        .zip(signal::white(seed))
        .map(|(x, e)| gain * x + noise * e)
        .collect()
}

/// What a run said: calls and releases, s, and when each channel was left out, and why.
#[derive(Default, Debug)]
struct Said {
    on: Vec<f64>,
    off: Vec<f64>,
    dropped: [Vec<(f64, ChannelFault)>; 2],
}

fn monitor(fs: f64) -> MonitorConfig {
    MonitorConfig {
        full_scale: Some(1.0),
        ..MonitorConfig::new(fs)
    }
}

fn take(said: &mut Said, event: AlarmEvent<f32>, t: f64) {
    match event {
        AlarmEvent::None => {}
        AlarmEvent::On { .. } => said.on.push(t),
        AlarmEvent::Off { .. } => said.off.push(t),
    }
    let (on, off) = (said.on.len(), said.off.len());
    assert!(on == off || on == off + 1, "an alarm doubled: {said:?}");
}

fn alone(config: &MonitorConfig, x: &[f64]) -> Said {
    let mut said = Said::default();
    let mut monitor = Monitor::<f32>::new(config).expect("settings in range");
    for (n, x) in x.iter().enumerate() {
        if let Some(report) = monitor.push(*x as f32) {
            take(&mut said, report.event, n as f64 / config.fs_hz);
        }
    }
    said
}

fn pair(config: &MonitorConfig, a: &[f64], b: &[f64]) -> Said {
    let mut said = Said::default();
    let mut pair = PairMonitor::<f32>::new(&PairConfig::new(*config)).expect("in range");
    let mut before = [None; 2];
    for (n, (a, b)) in a.iter().zip(b).enumerate() {
        let Some(report) = pair.push([*a as f32, *b as f32]) else {
            continue;
        };
        let t = n as f64 / config.fs_hz;
        take(&mut said, report.report.event, t);
        for i in 0..2 {
            let fault = report.dropped[i].map(|d| d.fault);
            if let (Some(fault), true) = (fault, fault != before[i]) {
                said.dropped[i].push((t, fault));
            }
            before[i] = fault;
        }
    }
    said
}

/// The second channel, given the vibration.
type Second = fn(&[f64], u64) -> Vec<f64>;

/// What the second channel is, and what becomes of it.
const CASES: [(&str, Option<Second>, Option<ChannelFault>); 7] = [
    ("one channel", None, None),
    (
        "two good ones",
        Some(|x, s| sensor(x, -0.005, 20.0, s)),
        None,
    ),
    (
        "one noisy, 0 dB",
        Some(|x, s| sensor(x, -0.005, 0.0, s)),
        None,
    ),
    (
        "one dead",
        Some(|x, s| sensor(x, 1e-7, -10.0, s)),
        Some(ChannelFault::Silent),
    ),
    (
        "one stuck at 1.5 s",
        Some(|x, s| {
            let mut y = sensor(x, -0.005, 20.0, s);
            let last = y[12_000];
            y[12_000..].fill(last);
            y
        }),
        Some(ChannelFault::Samples(Fault::Stuck)),
    ),
    (
        "one that clips",
        Some(|x, s| {
            let y = sensor(x, -0.3, 20.0, s);
            y.iter().map(|x| x.clamp(-1.0, 1.0)).collect()
        }),
        Some(ChannelFault::Samples(Fault::Clipped)),
    ),
    (
        "one NaN from 1.5 s",
        Some(|x, s| {
            let mut y = sensor(x, -0.005, 20.0, s);
            y[12_000..].fill(f64::NAN);
            y
        }),
        Some(ChannelFault::Samples(Fault::NotFinite)),
    ),
];

const SEEDS: u64 = 16;
/// Seconds of a cut that is damped by 1.5 %, for each seed.
const DAMPED_S: f64 = 8.0;

/// What one case came to over all seeds.
#[derive(Default)]
struct Tally {
    /// Onset to the call, ms, for each seed.
    to_call: Vec<f64>,
    /// Calls before the onset.
    early: usize,
    /// Calls of a mode of 1.5 %.
    wrong: usize,
    /// When each channel was first left out, and why, for each seed.
    dropped: [Vec<Option<(f64, ChannelFault)>>; 2],
}

fn tally(config: &MonitorConfig, second: Option<Second>) -> Tally {
    let mut out = Tally::default();
    let hear = |x: &[f64], seed: u64| {
        let first = sensor(x, 0.01, 20.0, 100 + seed);
        match second {
            None => alone(config, &first),
            Some(second) => pair(config, &first, &second(x, 200 + seed)),
        }
    };
    for seed in 0..SEEDS {
        let said = hear(&machine(0.04, ONSET_S, SECONDS, seed), seed);
        out.early += said.on.iter().filter(|t| **t < ONSET_S).count();
        let call = said.on.iter().find(|t| **t >= ONSET_S);
        let call = call.unwrap_or_else(|| panic!("seed {seed} missed: {said:?}"));
        out.to_call.push(1e3 * (call - ONSET_S));
        for (all, one) in out.dropped.iter_mut().zip(&said.dropped) {
            all.push(one.first().copied());
        }
        // A mode of 1.5 % is not chatter.
        let damped = hear(&machine(0.015, 99.0, DAMPED_S, 50 + seed), 1000 + seed);
        out.wrong += damped.on.len();
    }
    out
}

#[test]
fn time_to_the_call_and_false_calls() {
    let config = monitor(FS);
    let minutes = SEEDS as f64 * DAMPED_S / 60.0;
    println!("{SEEDS} cuts; false calls in {minutes:.1} min of a mode of 1.5 %");
    println!("                    to the call, ms   false   left out");
    println!("                    median    worst");
    let worst = |t: &Tally| t.to_call.iter().copied().fold(0.0, f64::max);
    let median = |t: &Tally| quantile(&t.to_call, 0.5);
    let single = tally(&config, None);
    for (name, second, wanted) in CASES {
        let said = tally(&config, second);
        let named: Vec<_> = said.dropped[1].iter().flatten().collect();
        println!(
            "{name:20}{:>6.0} {:>8.0} {:>7}   {}",
            median(&said),
            worst(&said),
            said.wrong,
            named.first().map_or("-".to_owned(), |(t, why)| format!(
                "{why:?} at {t:.2} s, {} times",
                named.len()
            )),
        );
        assert_eq!(said.early, 0, "{name}: a mode of 4 % was called");
        // The good channel is never blamed, the bad one always, and for what it has.
        assert!(said.dropped[0].iter().all(Option::is_none), "{name}");
        let reasons: Vec<_> = said.dropped[1]
            .iter()
            .map(|d| d.map(|(_, why)| why))
            .collect();
        assert_eq!(reasons, vec![wanted; SEEDS as usize], "{name}");
        // A second sensor, whatever is wrong with it, makes no call that one alone does not.
        assert_eq!((single.wrong, said.wrong), (0, 0), "{name}: false calls");
        let later: Vec<f64> = said
            .to_call
            .iter()
            .zip(&single.to_call)
            .map(|(pair, one)| pair - one)
            .collect();
        let (least, most) = (quantile(&later, 0.0), quantile(&later, 1.0));
        match (name, wanted) {
            ("two good ones", _) => {
                assert!(quantile(&later, 0.5).abs() < 10.0, "{name}: {later:?}");
                // Where one is sure and the other is not yet, it waits.
                assert!(least > -60.0 && most < 65.0, "{name}: {later:?}");
            }
            // It waits for the other for one confirmation at most.
            ("one noisy, 0 dB" | "one that clips", _) => {
                assert!(least > -60.0 && most < 65.0, "{name}: {later:?}");
            }
            // The good one goes on as if it were alone.
            _ => assert!(least > -3.0 && most < 3.0, "{name}: {later:?}"),
        }
    }
}

#[test]
fn a_virtual_cut_heard_twice() {
    let loaded = scenario::load("chatter-onset", None).expect("a shipped scenario");
    let band = loaded.band();
    let onset = loaded
        .scenario
        .truth()
        .expect("a truth")
        .onset_s
        .expect("an onset");
    let microphone = ear::hear(&loaded.scenario, band, Forced::Kept).expect("a cut");
    let mut other = loaded.scenario.clone();
    other.microphone.pickup = Pickup::Velocity;
    other.microphone.gain = [10.0, 6.0];
    other.microphone.distance_m = 0.0;
    other.microphone.seed = 77;
    let probe = ear::hear(&other, band, Forced::Kept).expect("the same cut");
    let config = MonitorConfig {
        band: Some(band),
        order: loaded.hints.order,
        spindle_hz: Some(loaded.scenario.process.spindle_hz()),
        teeth: u32::try_from(loaded.scenario.process.teeth()).ok(),
        ..monitor(microphone.fs)
    };
    let (x, y) = (&microphone.samples, &probe.samples);
    let noisy = sensor(x, 1.0, 0.0, 5);
    println!("chatter from {onset:.3} s; called at, released at");
    let mut on = Vec::new();
    for (name, said) in [
        ("microphone", alone(&config, x)),
        ("probe", alone(&config, y)),
        ("microphone in noise, 0 dB", alone(&config, &noisy)),
        ("microphone and probe", pair(&config, x, y)),
        ("microphone and noisy one", pair(&config, x, &noisy)),
        ("noisy one and microphone", pair(&config, &noisy, x)),
    ] {
        println!("{name:26} {:?} {:?} {:?}", said.on, said.off, said.dropped);
        assert!(
            said.on.len() == 1 && said.off.len() == 1,
            "{name}: {said:?}"
        );
        assert!((onset - 0.7..onset + 0.7).contains(&said.on[0]), "{name}");
        let bar = format!("two sensors: released, s, {name}");
        holds(&bar, said.off[0], 8.1..=8.6);
        assert!(said.dropped.iter().all(Vec::is_empty), "{name}: {said:?}");
        on.push(said.on[0]);
    }
    let [microphone, probe, noisy, both, good_first, noisy_first] = on[..] else {
        unreachable!("six runs")
    };
    assert!(both < microphone.max(probe) + 0.01, "{both}");
    // The noise costs the pair one confirmation at most, not what it costs one alone.
    for pair in [good_first, noisy_first] {
        assert!(pair < microphone + 0.07 && pair < noisy, "{pair}");
    }
    all_judged("two sensors");
}

/// Two axes of one cut on a machining centre, as two channels of one file. Nobody has
/// labelled it: what is asked is that the pair invents nothing and doubts neither axis.
#[test]
fn two_axes_of_a_recorded_cut() {
    let Some(shared) = shared_or_skip("two_axes_of_a_recorded_cut") else {
        return;
    };
    let axes = ["X", "Y"].map(|axis| {
        Known::read(
            &shared,
            &format!("yang_hurco_accel/EBI_T50_0p25IN_6900RPM_{axis}"),
        )
    });
    let [x, y] = axes.each_ref().map(|a| &a.recording);
    let samples = x.samples.len().min(y.samples.len());
    let data: Vec<u8> = (0..samples)
        .flat_map(|n| [x.samples[n] as f32, y.samples[n] as f32])
        .flat_map(f32::to_le_bytes)
        .collect();
    let folder = Folder::default();
    let file = folder.file("xy.wav", &wav(FLOAT, 2, x.fs as u32, 32, &data));
    let hear = |options: &str| {
        let ended = rarma!().on("monitor", &file, &format!("--rpm 6900 --json {options}"));
        assert!(matches!(ended.code, Some(0 | 1)), "{ended:?}");
        ended.monitored()
    };
    let stretches = |summary: &Value| -> Vec<(f64, f64)> {
        let alarms = summary["alarms"].as_array().expect("alarms");
        let end = samples as f64 / x.fs;
        let edge = |a: &Value, key: &str| a[key].as_f64().unwrap_or(end);
        alarms
            .iter()
            .map(|a| (edge(a, "on"), edge(a, "off")))
            .collect()
    };
    let [one, two] = ["", "--channel 1"].map(|o| stretches(&hear(o).1));
    let (lines, summary) = hear("--second 1");
    let both = stretches(&summary);
    let mut words: BTreeMap<&str, usize> = BTreeMap::new();
    for line in &lines {
        let word = line["agreement"].as_str().expect("a word");
        *words.entry(word).or_default() += 1;
    }
    println!(
        "X {one:.2?}\nY {two:.2?}\nX and Y {both:.2?}\n{words:?}\n{}",
        summary["channels"]
    );
    for (on, off) in &both {
        let known = one
            .iter()
            .chain(&two)
            .any(|(a, b)| *on < *b && *a < *off + 0.1);
        assert!(known, "called by the pair alone: {on} to {off}");
    }
    for channel in summary["channels"].as_array().expect("channels") {
        assert!(
            channel["dropped_s"].as_f64().expect("seconds") < 0.5,
            "{channel}"
        );
    }
    assert!(words.contains_key("both"), "{words:?}");
}
