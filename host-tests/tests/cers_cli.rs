//! Promise: `rarma cers` reads what it writes, finds the modes of its plant, and refuses
//! what the rig may not do in one line with exit code 3.
//!
//! `cargo test --release -p host-tests --test cers_cli -- --nocapture`

use host_tests::files::Folder;
use host_tests::process::{Ended, Rarma};
use host_tests::rarma;
use rarma_scenarios::scenario::{SHIPPED_CERS, cers_schema, parse_cers};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

fn program() -> Rarma {
    rarma!()
}

fn cers(words: &[&OsStr]) -> Ended {
    program().run(
        [OsStr::new("cers")]
            .into_iter()
            .chain(words.iter().copied()),
    )
}

fn refused(ended: &Ended, words: &[&str]) {
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert_eq!(ended.stdout, "", "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    let [line] = lines[..] else {
        panic!("not one line: {ended:?}")
    };
    println!("{line}");
    for word in words {
        assert!(line.contains(word), "no `{word}` in: {line}");
    }
}

const HEAD: &str = "name = \"T\"\nabout = \"a test\"\nseconds = 1\n";

#[test]
fn what_the_rig_may_not_do_is_refused() {
    let folder = Folder::default();
    let check = |name: &str, more: &str, words: &[&str]| {
        let file = folder.file(name, format!("{HEAD}{more}").as_bytes());
        refused(&cers(&[OsStr::new("run"), file.as_os_str()]), words);
    };
    check(
        "uncalibrated.toml",
        "[magnets]\ncalibration = \"none\"\n",
        &["uncalibrated.toml: line 5", "no calibration", "+x"],
    );
    check(
        "bias.toml",
        "bias_a = 13\n",
        &["line 4", "bias_a is 13", "52.0 V", "45.6 V"],
    );
    check(
        "iron.toml",
        "bias_a = 2.6\n",
        &["bias_a is 2.6", "knee", "0.9"],
    );
    check(
        "low.toml",
        "bias_a = 0.2\n",
        &["bias_a is 0.2", "rectified"],
    );
    check(
        "voltage.toml",
        "supply_v = 24\n",
        &["excitation needs", "22.8 V"],
    );
    check(
        "gap.toml",
        "[magnets]\ngap_sensors = \"x\"\n",
        &[
            "line 5",
            "magnets.gap_sensors leaves y without a gap sensor",
        ],
    );
    check(
        "speed.toml",
        "[spindle]\nrpm = 19000\n",
        &["line 5", "spindle.rpm is 19000", "most_rpm, 18000"],
    );
    check(
        "ramp.toml",
        "[spindle]\nto_rpm = 20000\nmost_rpm = 12000\n",
        &["spindle.to_rpm is 20000", "most_rpm, 12000"],
    );
    check(
        "misspelt.toml",
        "[magnets]\ncallibration = \"points\"\n",
        &["magnets.callibration", "no known name"],
    );
    check("bands.toml", "tracks_hz = [500]\n", &["tracks_hz"]);
}

#[test]
fn shipped_measurements_and_their_schema() {
    for (name, text) in SHIPPED_CERS {
        let s = parse_cers(name, text).unwrap_or_else(|e| panic!("{e}"));
        assert!(s.seconds > 3.0, "{name}");
    }
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../rarma-scenarios/scenarios/cers-schema.json"
    );
    let text = fs::read_to_string(path).expect("the schema beside the tests");
    let kept: Value = serde_json::from_str(&text).expect("JSON");
    assert!(
        kept == serde_json::from_str::<Value>(&cers_schema().to_string()).expect("JSON"),
        "write it again: rarma cers run --schema > {path}"
    );
}

fn modes(all: &Value) -> Vec<(f64, f64, f64, f64, Value)> {
    let number = |m: &Value, k: &str| m[k].as_f64().unwrap_or(f64::NAN);
    all["modes"]
        .as_array()
        .expect("modes")
        .iter()
        .map(|m| {
            (
                number(m, "f"),
                number(m, "f_sd"),
                number(m, "zeta"),
                number(m, "zeta_sd"),
                m["truth"].clone(),
            )
        })
        .collect()
}

/// Written, read again: the same modes; exports that others read.
#[test]
fn run_and_analyse_agree() {
    let folder = Folder::default();
    let (record, page) = (folder.path().join("record"), folder.path().join("page"));
    let words = ["run", "cers-rest", "--json", "--quick", "--out"].map(OsStr::new);
    let first = cers(&[&words[..], &[record.as_os_str()]].concat()).json();
    let (uff, csv, structure) = (
        folder.path().join("r.uff"),
        folder.path().join("r.csv"),
        folder.path().join("structure"),
    );
    let words = ["analyse", "--json", "--quick", "--report"].map(OsStr::new);
    let more = [
        page.as_os_str(),
        OsStr::new("--uff"),
        uff.as_os_str(),
        OsStr::new("--csv"),
        csv.as_os_str(),
        OsStr::new("--structure"),
        structure.as_os_str(),
        OsStr::new("--quantity"),
        OsStr::new("accelerance"),
        record.as_os_str(),
    ];
    let second = cers(&[&words[..], &more].concat()).json();
    let (a, b) = (modes(&first), modes(&second));
    assert_eq!(a.len(), 12, "seven in x and five in y");
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert!((a.0 / b.0 - 1.0).abs() < 1e-4, "{a:?} {b:?}");
        assert!((a.2 / b.2 - 1.0).abs() < 5e-3, "{a:?} {b:?}");
        let (f, z) = (
            a.4[0].as_f64().expect("truth"),
            a.4[1].as_f64().expect("truth"),
        );
        println!(
            "{:7.1} Hz: f {:+.3} % (sd {:.3}), damping {:+.2} % (sd {:.2})",
            f,
            100.0 * (a.0 / f - 1.0),
            100.0 * a.1 / f,
            100.0 * (a.2 / z - 1.0),
            100.0 * a.3 / z
        );
        assert!((a.0 / f - 1.0).abs() < 1e-3 && (a.2 / z - 1.0).abs() < 0.02);
        assert!(a.1 > 0.0 && a.3 > 0.0, "a deviation");
    }
    let angle = first["principal_deg"].as_f64().expect("an angle");
    // The plant's directions are turned by 0.1 rad.
    assert!((angle - 5.73).abs() < 0.1, "{angle}");
    // Our own reader takes the universal file: four functions, two lists of lines.
    let functions = rarma_recordings::input::read_receptances(&uff).expect("a universal file");
    assert_eq!(functions.len(), 4);
    let table = fs::read_to_string(&csv).expect("a table");
    assert!(table.starts_with("force,motion,sensor,freq_hz,re_m_per_s2_per_N"));
    assert!(table.lines().count() > 3900);
    let x = rarma_recordings::input::read_structure(&structure.join("structure-x.json"));
    assert_eq!(x.expect("a structure").modes().len(), 7);
    let html = fs::read_to_string(page.join("index.html")).expect("a page");
    for word in ["Accelerance, magnitude", "Coherence", "table 3, EMA"] {
        assert!(html.contains(word), "{word}");
    }
    bad_records(&folder, &record);
}

fn bad_records(folder: &Folder, good: &Path) {
    let (text, wav) = (
        fs::read_to_string(good.join("record.toml")).expect("text"),
        fs::read(good.join("signals.wav")).expect("bytes"),
    );
    let check = |name: &str, text: &str, wav: &[u8], words: &[&str]| {
        let dir = folder.path().join(name);
        fs::create_dir_all(&dir).expect("a folder");
        fs::write(dir.join("record.toml"), text).expect("written");
        fs::write(dir.join("signals.wav"), wav).expect("written");
        refused(&cers(&[OsStr::new("analyse"), dir.as_os_str()]), words);
    };
    check(
        "magnet",
        &text.replacen("side = \"-y\"", "side = \"+y\"", 1),
        &wav,
        &["record.toml", "magnet -y has no calibration"],
    );
    check(
        "rate",
        &text.replace("rate_hz = 20000.0", "rate_hz = 25000.0"),
        &wav,
        &["signals.wav: header", "20000 Hz", "25000"],
    );
    check(
        "word",
        &text.replace("bias_a = 0.8", "bias_a = \"much\""),
        &wav,
        &["record.toml: line", "bias_a"],
    );
    check("short", &text, &wav[..20_000], &["signals.wav"]);
    check("empty", &text, b"RIFF", &["signals.wav: header"]);
    // Sample 700 of the fourth channel.
    let data = wav.windows(4).position(|w| w == b"data").expect("data") + 8;
    let mut nan = wav.clone();
    let at = data + 4 * (700 * 11 + 3);
    nan[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    check("nan", &text, &nan, &["frame 700, current -x A", "NaN"]);
    let mut dead = wav.clone();
    for frame in 0..(wav.len() - data) / 44 {
        let at = data + 4 * (frame * 11 + 7);
        dead[at..at + 4].copy_from_slice(&0.0f32.to_le_bytes());
    }
    check(
        "dead",
        &text,
        &dead,
        &["displacement y m", "gap sensor", "absent"],
    );
    let nowhere = folder.path().join("nowhere");
    refused(
        &cers(&[OsStr::new("analyse"), nowhere.as_os_str()]),
        &["nowhere: open"],
    );
}
