//! Promise: `--second` and `--structure` add their fields to the JSON of `rarma
//! monitor`, and only they do; a sick channel is named there.

use host_tests::files::{FLOAT, Folder, wav};
use host_tests::forced::{Forced, ForcedConfig};
use host_tests::json::keys;
use host_tests::{rarma, signal};
use serde_json::Value;
use std::path::PathBuf;

const FS: u32 = 8000;
const SAMPLES: usize = 4 * FS as usize;

/// A mode of 4 % in two channels; the second sticks from 1 to 2 s.
fn stereo(folder: &Folder) -> PathBuf {
    let modes = signal::modes(&[(900.0, 0.04)], f64::from(FS), 7);
    let mut held = 0.0;
    let frames = modes.take(SAMPLES).enumerate().flat_map(|(n, x)| {
        let stuck = (FS as usize..2 * FS as usize).contains(&n);
        held = if stuck { held } else { -0.02 * x };
        [(0.1 * x) as f32, held as f32]
    });
    let data: Vec<u8> = frames.flat_map(f32::to_le_bytes).collect();
    folder.file("stereo.wav", &wav(FLOAT, 2, FS, 32, &data))
}

#[test]
fn two_channels_add_agreement_and_channels() {
    let folder = Folder::default();
    let file = stereo(&folder);
    let ended = rarma!().on("monitor", &file, "--second 1 --json");
    assert_eq!(
        (ended.code, ended.stderr.as_str()),
        (Some(0), ""),
        "{ended:?}"
    );
    let (lines, summary) = ended.monitored();
    assert!((395..=400).contains(&lines.len()), "{}", lines.len());
    for line in &lines {
        assert_eq!(
            keys(line),
            [
                "agreement",
                "amplitude",
                "modes",
                "reason",
                "spindle",
                "state",
                "t"
            ]
        );
        let (t, word) = (line["t"].as_f64().expect("a time"), &line["agreement"]);
        if (1.06..2.9).contains(&t) {
            assert_eq!(word, "single", "{line}");
        } else if t > 3.2 || (0.5..0.9).contains(&t) {
            // Both hear the mode, but for a moment of disagreement here and there.
            assert!(word != "single", "{line}");
        }
    }
    let both = lines.iter().filter(|l| l["agreement"] == "both").count();
    assert!((100..230).contains(&both), "{both} lines of 400");
    let wanted = [
        "alarms",
        "channels",
        "fs",
        "notices",
        "order",
        "removed_db",
        "samples",
        "spindle",
        "state_seconds",
    ];
    assert_eq!(keys(&summary), wanted);
    assert_eq!(summary["samples"], SAMPLES);
    let channels = summary["channels"].as_array().expect("channels");
    assert_eq!(channels.len(), 2);
    for (i, channel) in channels.iter().enumerate() {
        assert_eq!(keys(channel), ["channel", "dropped_s", "faults"]);
        assert_eq!(channel["channel"], i);
    }
    assert_eq!(channels[0]["faults"], serde_json::json!([]));
    assert_eq!(channels[0]["dropped_s"].to_string(), "0.0");
    let [fault] = &channels[1]["faults"].as_array().expect("faults")[..] else {
        panic!("{summary}");
    };
    assert_eq!(keys(fault), ["fault", "off", "on"]);
    assert_eq!(fault["fault"], "stuck");
    // Stuck for 50 ms to be called so, well for a second to be taken back.
    let (on, off) = (fault["on"].as_f64(), fault["off"].as_f64());
    assert!(on.is_some_and(|t| (1.05..1.056).contains(&t)), "{fault}");
    assert!(off.is_some_and(|t| (3.0..3.01).contains(&t)), "{fault}");
    let dropped = channels[1]["dropped_s"].as_f64().expect("seconds");
    assert!((dropped - (off.unwrap_or(0.0) - on.unwrap_or(0.0))).abs() < 1e-9);
    // In words, for people.
    let told = rarma!().on("monitor", &file, "--second 1");
    assert!(told.stdout.contains("Channel 1 was left out"), "{told:?}");
    assert!(told.stdout.contains("stuck from 1.05"), "{told:?}");
    // The order of the channels does not matter, only their names do.
    let swapped = rarma!().on("monitor", &file, "--channel 1 --second 0 --json");
    let (_, swapped) = swapped.monitored();
    assert_eq!(swapped["channels"][0], channels[1]);
    assert_eq!(swapped["channels"][1], channels[0]);
}

#[test]
fn a_channel_that_is_no_signal_at_all_is_left_out_with_a_notice() {
    let folder = Folder::default();
    let modes = signal::modes(&[(900.0, 0.04)], f64::from(FS), 7);
    let frames = modes
        .take(SAMPLES)
        .flat_map(|x| [(0.1 * x) as f32, f32::NAN]);
    let data: Vec<u8> = frames.flat_map(f32::to_le_bytes).collect();
    let file = folder.file("half.wav", &wav(FLOAT, 2, FS, 32, &data));
    let ended = rarma!().on("monitor", &file, "--second 1 --json");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
    assert!(ended.stderr.contains("NaN") && ended.stderr.contains("channel 1"));
    let (lines, summary) = ended.monitored();
    assert!(lines.iter().all(|l| l["agreement"] == "single"));
    assert_eq!(lines[lines.len() - 1]["state"], "stable");
    assert_eq!(summary["channels"][1]["faults"][0]["fault"], "not-finite");
    assert_eq!(summary["channels"][1]["faults"][0]["off"], Value::Null);
    // Alone it is refused, as ever.
    let ended = rarma!().on("monitor", &file, "--channel 1 --json");
    assert_eq!(ended.code, Some(3), "{ended:?}");
}

#[test]
fn structure_adds_the_part_of_the_process_and_nothing_else() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::modes(&[(900.0, 0.04), (1700.0, 0.03)], f64::from(FS), 7)
        .map(|x| 0.1 * x)
        .take(SAMPLES)
        .collect();
    let file = folder.pcm16("damped.wav", FS, &x);
    let table = b"# at rest\nzeta;f;zeta_sd;f_sd;note\n0,05;905;0,001;1;tool\n";
    let structure = folder.file("structure.csv", table);
    let options = format!("--json --structure {}", structure.display());
    let plain = rarma!().on("monitor", &file, "--json");
    let ended = rarma!().on("monitor", &file, &options);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let (mut lines, summary) = ended.monitored();
    let (mut there, mut elsewhere) = (0, 0);
    for line in &mut lines {
        for mode in line["modes"].as_array_mut().expect("modes") {
            let number = |key: &str| mode[key].as_f64();
            let (f, f_sd) = (number("f").expect("f"), number("f_sd").expect("f_sd"));
            let (zeta, sd) = (number("zeta").expect("ζ"), number("zeta_sd").expect("sd"));
            let width = (3.0 * (f_sd * f_sd + 1.0).sqrt()).max(0.05 * 905.0);
            let (process, process_sd) = (number("zeta_process"), number("zeta_process_sd"));
            if (f - 905.0).abs() <= width {
                there += 1;
                assert!((process.expect("ζ") - (zeta - 0.05)).abs() < 1e-7, "{mode}");
                let joint = (sd * sd + 1e-6).sqrt();
                assert!(
                    (process_sd.expect("sd") / joint - 1.0).abs() < 1e-6,
                    "{mode}"
                );
            } else {
                elsewhere += 1;
                assert_eq!((process, process_sd), (None, None), "{mode}");
            }
            let mode = mode.as_object_mut().expect("a mode");
            assert_eq!(mode.len(), 11, "{mode:?}");
            assert!(mode.remove("zeta_process").is_some());
            assert!(mode.remove("zeta_process_sd").is_some());
        }
    }
    assert!(there > 300 && elsewhere > 300, "{there} {elsewhere}");
    // All the rest is what it was.
    assert_eq!((lines, summary), plain.monitored());
    let told = rarma!().on("monitor", &file, &options.replace("--json", ""));
    assert!(
        told.stdout.contains("Mode at 905.0 Hz (5.00 % at rest)"),
        "{told:?}"
    );
}

/// Eight seconds of a stable cut at 70 Hz, its forced lines 20 dB above its modes.
fn forced(folder: &Folder) -> PathBuf {
    let config = ForcedConfig {
        fs_hz: f64::from(FS),
        modes: vec![(980.0, 0.03)],
        spindle_hz: 70.0,
        teeth: 5,
        ..ForcedConfig::drawn(4)
    };
    let x: Vec<f32> = Forced::new(config)
        .take(2 * SAMPLES)
        .map(|x| x as f32)
        .collect();
    folder.float("forced.wav", FS, &x)
}

#[test]
fn the_spindle_is_told_as_it_was_heard() {
    let folder = Folder::default();
    let ended = rarma!().on("monitor", &forced(&folder), "--rpm 4200 --teeth 5 --json");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    let (lines, summary) = ended.monitored();
    let number = |key: &str| summary["spindle"][key].as_f64().expect("a number");
    println!("{summary}");
    for key in ["rpm_first", "rpm_last"] {
        assert!((number(key) / 4200.0 - 1.0).abs() < 1e-3, "{summary}");
    }
    let locked = lines.iter().filter(|l| l["spindle"]["locked"] == true);
    let locked_s = 0.01 * locked.count() as f64;
    assert!((number("locked_s") - locked_s).abs() < 0.05, "{summary}");
    assert!((5.0..8.0).contains(&locked_s), "{locked_s}");
    assert!((0.1..5.0).contains(&number("notch_hz")), "{summary}");
    // 100 of 101 parts are lines, but not while they are sought.
    let removed_db = summary["removed_db"].as_f64().expect("a number");
    assert!((-1.5..0.05).contains(&removed_db), "{summary}");
}

#[test]
fn a_wrong_speed_is_contradicted_with_both_speeds() {
    let folder = Folder::default();
    let file = forced(&folder);
    // Not one whose multiples are the tooth's, as 3000 1/min would be: 7·50 Hz = 5·70 Hz.
    let ended = rarma!().on("monitor", &file, "--rpm 3100 --teeth 5 --json");
    let (_, summary) = ended.monitored();
    let [notice] = &summary["notices"].as_array().expect("notices")[..] else {
        panic!("{summary}");
    };
    assert_eq!(keys(notice), ["found_rpm", "notice", "t", "told_rpm"]);
    assert_eq!(notice["notice"], "contradiction");
    assert_eq!(notice["told_rpm"].as_f64(), Some(3100.0));
    let found = notice["found_rpm"].as_f64().expect("a speed");
    assert!((found / 4200.0 - 1.0).abs() < 1e-2, "{notice}");
    let both = |text: &str| text.contains("Warning") && text.contains("3100 1/min");
    assert!(both(&ended.stderr), "{}", ended.stderr);
    assert!(ended.stderr.contains(&format!("{found:.0} 1/min")));
    let words = rarma!().on("monitor", &file, "--rpm 3100 --teeth 5");
    assert_eq!(words.stderr, "");
    assert!(words.stdout.contains(ended.stderr.trim()), "{words:?}");
}
