//! Promise: what `rarma convert`, `psd --out` and `simulate --out` write is read by programs that are
//! not ours (pyuff, scipy), sample by sample, and by `rarma` itself; and `rarma` reads what pyuff
//! writes.

use host_tests::files::{FLOAT, Folder, wav};
use host_tests::resources::python_packages_or_skip;
use host_tests::{rarma, signal};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const FS: u32 = 44_100;
const SAMPLES: usize = 5000;

/// A number that single precision holds, the same whoever computes it.
fn sample(t: usize, channel: usize) -> f32 {
    ((t * 7919 + channel * 104_729) % 65_537) as f32 / 131_072.0 - 0.25
}

/// A recording of two channels.
fn two(folder: &Folder) -> PathBuf {
    let data: Vec<u8> = (0..SAMPLES)
        .flat_map(|t| [sample(t, 0), sample(t, 1)])
        .flat_map(f32::to_le_bytes)
        .collect();
    folder.file("two.wav", &wav(FLOAT, 2, FS, 32, &data))
}

fn run(words: &[&str]) {
    let ended = rarma!().run(words);
    assert_eq!(
        (ended.code, ended.stderr.as_str()),
        (Some(0), ""),
        "{words:?}"
    );
}

fn python(packages: &Path, script: &str, arguments: &[&Path]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(script);
    let read = Command::new("python3")
        .env("PYTHONPATH", packages)
        .arg(script)
        .args(arguments)
        .output()
        .expect("python3");
    assert!(read.status.success(), "{read:?}");
    serde_json::from_slice(&read.stdout).expect("JSON")
}

fn list(value: &Value) -> Vec<f64> {
    let items = value.as_array().expect("a list");
    items
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect()
}

fn near(found: &[f64], channel: usize, tolerance: f64) {
    assert_eq!(found.len(), SAMPLES);
    for (t, x) in found.iter().enumerate() {
        assert!(
            (x - f64::from(sample(t, channel))).abs() <= tolerance,
            "{t}: {x}"
        );
    }
}

#[test]
fn others_read_what_is_written() {
    let Some(packages) = python_packages_or_skip("formats") else {
        return;
    };
    let folder = Folder::default();
    let file = two(&folder);
    let at = |name: &str| folder.path().join(name);
    let text = |path: &Path| path.to_str().expect("a path").to_owned();
    let (mat, uff, psd) = (at("two.mat"), at("two.uff"), at("psd.uff"));
    let source = text(&file);
    run(&["convert", &source, "--unit", "m/s^2", "--out", &text(&mat)]);
    run(&["convert", &source, "--unit", "m/s^2", "--out", &text(&uff)]);
    run(&[
        "psd",
        &source,
        "--method=welch",
        "--band=full",
        "--unit=m/s^2",
        "--out",
        &text(&psd),
    ]);

    let found = python(&packages, "read_formats.py", &[&mat]);
    assert_eq!(found["fs"][0][0], f64::from(FS));
    assert_eq!(found["units"], "m/s^2; m/s^2");
    for channel in 0..2 {
        // What the JSON between the two programs loses: the last bit.
        near(&list(&found["x"][channel]), channel, 1e-15);
    }
    let sets = python(&packages, "read_formats.py", &[&uff]);
    for channel in 0..2 {
        let set = &sets[channel];
        assert_eq!([&set["func_type"], &set["abscissa"]], [1, 17]);
        assert_eq!(set["unit"], "m/s^2");
        near(&list(&set["data"]), channel, 1e-12);
        // The format gives six digits to the step.
        let last = list(&set["x"])[SAMPLES - 1];
        assert!((last * f64::from(FS) / (SAMPLES - 1) as f64 - 1.0).abs() < 5e-6);
    }
    let said = rarma!().on("psd", &file, "--method welch --band full --json");
    let said = &said.json_lines()[0];
    let set = &python(&packages, "read_formats.py", &[&psd])[0];
    assert_eq!([&set["func_type"], &set["abscissa"]], [9, 18]);
    assert_eq!(set["unit"], "(m/s^2)^2/Hz");
    for (a, b) in list(&set["data"]).iter().zip(list(&said["psd"])) {
        assert!((a / b - 1.0).abs() < 1e-11, "{a} {b}");
    }
}

/// What a recording says of its unit stands in what it is converted to, unless another is told.
#[test]
fn the_unit_of_a_recording_goes_with_it() {
    let folder = Folder::default();
    let file = folder.file(
        "a.csv",
        "time,x (m/s²),y\n0,1,2\n0.5,3,4\n1,5,7\n".as_bytes(),
    );
    let at = |name: &str| {
        let path = folder.path().join(name);
        path.to_str().expect("a path").to_owned()
    };
    let source = file.to_str().expect("a path").to_owned();
    let (uff, csv, psd) = (at("b.uff"), at("c.csv"), at("psd.csv"));
    let header = |path: &str| -> String {
        let text = std::fs::read_to_string(path).expect("written");
        let line = text.lines().find(|line| !line.starts_with('#'));
        line.expect("a header").to_owned()
    };
    run(&["convert", &source, "--out", &csv]);
    assert_eq!(header(&csv), "time_s,channel 0 (m/s²),channel 1 (1)");
    // What has no sign of its own there is spelled.
    run(&["convert", &csv, "--out", &uff]);
    run(&["convert", &uff, "--out", &csv]);
    assert_eq!(header(&csv), "time_s,channel 0 (m/s^2),channel 1 (1)");
    run(&["convert", &uff, "--unit", "g", "--out", &csv]);
    assert_eq!(header(&csv), "time_s,channel 0 (g),channel 1 (g)");
    let long: String = (0..100)
        .map(|t| format!("{},{}\n", t, (t * t) % 7))
        .collect();
    let long = folder.file("long.csv", format!("time,x (Pa)\n{long}").as_bytes());
    let long = long.to_str().expect("a path");
    for (unit, words) in [("Pa", &[][..]), ("g", &["--unit", "g"])] {
        let common = ["psd", long, "--method=welch", "--band=full", "--out", &psd];
        run(&[&common[..], words].concat());
        assert_eq!(header(&psd), format!("frequency_Hz,psd (({unit})^2/Hz)"));
    }
}

/// A density as a MATLAB file, and a virtual cut in every format.
#[test]
fn others_read_densities_and_virtual_cuts() {
    let Some(packages) = python_packages_or_skip("formats") else {
        return;
    };
    let folder = Folder::default();
    let file = two(&folder);
    let at = |name: &str| folder.path().join(name);
    let text = |path: &Path| path.to_str().expect("a path").to_owned();
    let psd = at("psd.mat");
    let options = "--method welch --band full --unit Pa";
    let ended = rarma!().on("psd", &file, &format!("{options} --out {}", text(&psd)));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let said = rarma!().on("psd", &file, "--method welch --band full --json");
    let said = &said.json_lines()[0];
    let found = python(&packages, "read_formats.py", &[&psd]);
    assert_eq!(found["units"], "(Pa)^2/Hz");
    for (name, of) in [("f_Hz", "f"), ("psd", "psd")] {
        let (read, told) = (list(&found[name][0]), list(&said[of]));
        assert!(read.len() == told.len() && read.len() > 1000, "{name}");
        for (a, b) in read.iter().zip(told) {
            assert!((a - b).abs() <= 1e-9 * b.abs(), "{name}: {a} {b}");
        }
    }

    let names = ["cut.csv", "cut.mat", "cut.uff"].map(at);
    for name in &names {
        run(&["simulate", "turning-980", "--out", &text(name)]);
    }
    // What our own reader finds in the lines of text.
    let options = rarma_recordings::input::ReadOptions::default();
    let own = rarma_recordings::input::read(&names[0], &options).expect("read");
    let loud = own.samples.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert!(own.samples.len() > 10_000 && loud > 1e-3, "{loud}");
    let mat = python(&packages, "read_formats.py", &[&names[1]]);
    assert_eq!(
        (&mat["fs"][0][0], &mat["units"]),
        (&own.fs.into(), &"1".into())
    );
    let uff = &python(&packages, "read_formats.py", &[&names[2]])[0];
    assert_eq!([&uff["func_type"], &uff["abscissa"]], [1, 17]);
    for (found, tolerance) in [(list(&mat["x"][0]), 1e-15), (list(&uff["data"]), 1e-12)] {
        assert_eq!(found.len(), own.samples.len());
        for (a, b) in found.iter().zip(&own.samples) {
            assert!((a - b).abs() <= tolerance, "{a} {b}");
        }
    }
}

/// Text and binary, as pyuff writes them.
#[test]
fn what_others_write_is_read() {
    let Some(packages) = python_packages_or_skip("formats") else {
        return;
    };
    let folder = Folder::default();
    let file = two(&folder);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/write_uff.py");
    let wrote = Command::new("python3")
        .env("PYTHONPATH", &packages)
        .arg(&script)
        .args([&file, folder.path()])
        .output()
        .expect("python3");
    assert!(wrote.status.success(), "{wrote:?}");
    for name in ["text.uff", "binary.uff"] {
        let path = folder.path().join(name);
        let options = rarma_recordings::input::ReadOptions::default();
        let read = rarma_recordings::input::read_channels(&path, &options, None, None);
        let read = read.unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(read.len(), 2, "{name}");
        for (channel, recording) in read.iter().enumerate() {
            assert_eq!(recording.fs, f64::from(FS), "{name}");
            // pyuff writes text with eleven decimals.
            near(&recording.samples, channel, 1e-10);
        }
    }
}

#[test]
fn a_universal_file_is_a_recording_like_any_other() {
    let folder = Folder::default();
    let waves = [1, 2].map(|seed| signal::modes(&[(4000.0, 0.02)], f64::from(FS), seed));
    let [first, second] = waves;
    let data: Vec<u8> = first
        .zip(second)
        .take(20_000)
        .flat_map(|(a, b)| [0.1 * (a + 0.3 * b), 0.1 * (b - 0.5 * a)])
        .flat_map(|x| (x as f32).to_le_bytes())
        .collect();
    let file = folder.file("two.wav", &wav(FLOAT, 2, FS, 32, &data));
    let uff = folder.path().join("two.uff");
    run(&[
        "convert",
        file.to_str().expect("a path"),
        "--out",
        uff.to_str().expect("a path"),
    ]);
    for options in [
        "--order 4,4 --band full",
        "--channels all --order 4,0 --band full",
    ] {
        let [a, b] = [&file, &uff].map(|path| rarma!().on("identify", path, options).stdout);
        assert!(a.contains("Hz"), "{a}");
        assert_eq!(a, b, "{options}");
    }
    let [a, b] = [&file, &uff].map(|path| rarma!().on("monitor", path, "--json").stdout);
    assert!(a.lines().count() > 20, "{a}");
    assert_eq!(a, b, "monitor");
}

#[test]
fn what_is_no_record_or_no_format_is_refused_in_a_line() {
    let folder = Folder::default();
    let file = two(&folder);
    let other = rarma!().on("convert", &file, "--out two.xlsx");
    assert_eq!(other.code, Some(2), "{other:?}");
    assert!(other.stderr.contains(".mat"), "{other:?}");
    for (name, bytes, word) in [
        ("a.uff", &b"hello\n"[..], "dataset"),
        ("b.uff", b"    -1\n    58\nshort\n", "ends inside"),
        (
            "c.uff",
            b"    -1\n   164\nx\n    -1\n",
            "no record over time",
        ),
    ] {
        let ended = rarma!().on("monitor", &folder.file(name, bytes), "");
        assert_eq!(ended.code, Some(3), "{ended:?}");
        assert!(ended.stderr.contains(word), "{ended:?}");
        assert_eq!(ended.stderr.trim_end().lines().count(), 1);
    }
}
