//! Promise: the firmware image on the emulated Cortex-M4F calls what the host calls,
//! within 20 ms, and its numbers are those of the host to the bit.
//!
//! The image is the one that `RARMA_TARGET_ELF` names.

use host_tests::resources::{Known, shared_or_skip, target_elf_or_skip};
use rarma_box::wire::MonitorJob;
use rarma_cli::collect::News;
use rarma_cli::commands;
use rarma_cli::record::{ModeRecord, Run};
use rarma_core::Order;
use rarma_core::monitor::MonitorConfig;
use rarma_plants::cut::VirtualCut;
use rarma_recordings::input::Recording;
use rarma_scenarios::scenario;
use std::path::{Path, PathBuf};

/// Longest difference of an alarm's time, s.
const ALARM_S: f64 = 0.02;

fn job(monitor: MonitorConfig) -> MonitorJob {
    MonitorJob {
        monitor,
        channel: 0,
        every_s: 0.01,
    }
}

fn demo_cut(seconds: f64) -> (Recording, MonitorConfig) {
    let scenario = scenario::load("chatter-onset", Some(1))
        .expect("a shipped scenario")
        .scenario;
    let cut = VirtualCut::new(&scenario).expect("a shipped scenario");
    let fs = cut.sample_rate_hz();
    let config = MonitorConfig {
        full_scale: Some(1.0),
        spindle_hz: Some(scenario.process.spindle_hz()),
        teeth: u32::try_from(scenario.process.teeth()).ok(),
        ..MonitorConfig::new(fs)
    };
    let length = (seconds * fs) as usize;
    let samples: Vec<f64> = cut.take(length).map(|r| f64::from(r.value)).collect();
    let recording = Recording {
        path: PathBuf::from("chatter-onset"),
        format: "simulated".to_owned(),
        fs,
        seconds,
        samples,
        unit: None,
        full_scale: Some(1.0),
        step: None,
        channel: 0,
        channels: 1,
        gaps: Vec::new(),
        notices: Vec::new(),
    };
    (recording, config)
}

/// Largest differences between host and chip.
#[derive(Debug, Default, Clone, Copy)]
struct Largest {
    modes: usize,
    frequency: f64,
    damping: f64,
    alarm_s: f64,
}

/// Both run: the same lines and the same alarms. How far the numbers are apart is
/// printed before anything is asserted, for the day on which they differ.
fn compare(name: &str, elf: &Path, recording: &Recording, job: &MonitorJob) -> Run {
    let (mut on_host, mut on_chip) = (Vec::new(), Vec::new());
    let host = commands::listen(job, recording.samples_f32(), |news| {
        on_host.push(news.clone())
    })
    .expect("a run on the host");
    let chip = commands::on_chip(elf, job, recording, |news| on_chip.push(news.clone()))
        .unwrap_or_else(|why| panic!("{name}: {why}"));
    let mut largest = Largest::default();
    for (c, h) in chip.lines.iter().zip(&host.lines) {
        for (c, h) in c.modes.iter().zip(&h.modes) {
            largest.modes += 1;
            let difference = |get: fn(&ModeRecord) -> f64| (get(c) - get(h)).abs();
            largest.frequency = largest.frequency.max(difference(|m| m.f));
            largest.damping = largest.damping.max(difference(|m| m.zeta));
        }
    }
    let (c, h) = (&chip.summary.alarms, &host.summary.alarms);
    for (c, h) in c.iter().zip(h) {
        let off = match (c.off, h.off) {
            (Some(c), Some(h)) => (c - h).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        largest.alarm_s = largest.alarm_s.max((c.on - h.on).abs()).max(off);
    }
    let pairs = chip.lines.iter().zip(&host.lines);
    let same = pairs.filter(|(c, h)| c == h).count();
    println!(
        "{name}: {same} of {} lines identical; {largest:?}",
        host.lines.len()
    );
    assert_eq!(
        c.len(),
        h.len(),
        "{name}: alarms {c:?} on the chip, {h:?} on the host"
    );
    assert!(largest.alarm_s <= ALARM_S, "{name}: {largest:?}");
    assert!(
        2 * largest.modes > host.lines.len(),
        "{name}: little to compare: {largest:?}"
    );
    // One source, one arithmetic: single precision rounds alike on both. If this
    // fails, image and host were built from different sources, or an operation has
    // been fused or widened on one side.
    assert_eq!(same, host.lines.len(), "{name}: {largest:?}");
    assert_eq!(chip.summary, host.summary, "{name}");
    // Alarms stand between the same lines: who hears them one by one advises alike.
    for said in [&mut on_host, &mut on_chip] {
        said.retain(|news| *news != News::None);
    }
    assert!(on_host == on_chip, "{name}: said in another order");
    chip
}

#[test]
fn start_of_the_demonstration() {
    let Some(elf) = target_elf_or_skip("start_of_the_demonstration") else {
        return;
    };
    let (recording, config) = demo_cut(3.0);
    let chip = compare("demonstration, 3 s", &elf, &recording, &job(config));
    assert_eq!(chip.lines.len(), 300);
    assert!(chip.summary.alarms.is_empty(), "{:?}", chip.summary.alarms);
}

#[test]
fn every_order_runs_on_the_chip() {
    let Some(elf) = target_elf_or_skip("every_order_runs_on_the_chip") else {
        return;
    };
    let (recording, config) = demo_cut(1.5);
    for order in Order::ALL {
        let name = format!("demonstration, 1.5 s, ({},{})", order.p(), order.q());
        let config = MonitorConfig { order, ..config };
        compare(&name, &elf, &recording, &job(config));
    }
}

#[test]
fn real_recordings() {
    let Some(elf) = target_elf_or_skip("emulated_chip: real_recordings") else {
        return;
    };
    let Some(shared) = shared_or_skip("emulated_chip: real_recordings") else {
        return;
    };
    for (name, alarms) in [("chatter", 1), ("stable", 0), ("idle_sound", 0)] {
        let known = Known::read(&shared, &format!("hafez_mill_sound/{name}"));
        let config = MonitorConfig {
            full_scale: known.recording.full_scale,
            spindle_hz: known.meta["spindle_rpm"].as_f64().map(|rpm| rpm / 60.0),
            teeth: known.meta["teeth"].as_u64().map(|z| z as u32),
            ..MonitorConfig::new(known.recording.fs)
        };
        let chip = compare(name, &elf, &known.recording, &job(config));
        assert_eq!(chip.summary.alarms.len(), alarms, "{name}");
    }
}
