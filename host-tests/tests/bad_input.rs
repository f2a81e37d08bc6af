//! Promise: bad input ends with exit code 3 and one clear line that names the file
//! and the reason: never a panic, never a silent guess, nothing on standard output.

use host_tests::files::{FLOAT, Folder, HEADER, PCM, pcm16, wav};
use host_tests::process::{Ended, Rarma};
use host_tests::refusal::assert_one_line;
use host_tests::{rarma, signal};
use std::path::Path;

const FS: u32 = 8000;

fn program() -> Rarma {
    rarma!()
}

/// Two seconds of a healthy vibration, ±1 at most.
fn healthy() -> Vec<f64> {
    signal::modes(&[(900.0, 0.05)], f64::from(FS), 1)
        .map(|x| 0.15 * x)
        .take(2 * FS as usize)
        .collect()
}

/// One line on standard error that names the file and says these words, exit code
/// 3, and nothing else anywhere.
fn assert_refused(ended: &Ended, file: &Path, words: &[&str]) {
    assert_one_line(ended, 3, &file.display().to_string(), words);
}

/// `monitor`, with and without `--json`, and `target` (which reads before it
/// emulates) all refuse alike.
fn monitor_refuses(file: &Path, options: &str, words: &[&str]) {
    let json = format!("{options} --json");
    for (command, options) in [("monitor", options), ("monitor", &json), ("target", &json)] {
        assert_refused(&program().on(command, file, options), file, words);
    }
}

fn identify_refuses(file: &Path, options: &str, words: &[&str]) {
    let options = format!("--order 2,1 {options}");
    assert_refused(&program().on("identify", file, &options), file, words);
}

#[test]
fn good_input_is_not_refused() {
    // What all the others are measured against.
    let folder = Folder::default();
    let file = folder.pcm16("good.wav", FS, &healthy());
    let ended = program().on("monitor", &file, "--json");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    assert_eq!(ended.monitored().1["samples"], 2 * FS);
}

#[test]
fn missing_file() {
    let folder = Folder::default();
    let file = folder.path().join("nowhere.wav");
    monitor_refuses(&file, "", &["no such file"]);
    identify_refuses(&file, "", &["no such file"]);
}

#[test]
fn empty_file() {
    let folder = Folder::default();
    monitor_refuses(&folder.file("empty.wav", b""), "", &["empty"]);
    identify_refuses(&folder.file("empty.csv", b""), "--fs 8000", &["empty"]);
}

#[test]
fn directory() {
    let folder = Folder::default();
    monitor_refuses(folder.path(), "", &["is a directory"]);
}

#[test]
fn not_a_wav() {
    let folder = Folder::default();
    let file = folder.file("song.wav", b"fLaC\0\0\0\x22 and more of it");
    monitor_refuses(&file, "", &["not a WAV", "FLAC"]);
    let file = folder.file("text.wav", b"It was a bright cold day in April");
    monitor_refuses(&file, "", &["not a WAV"]);
}

#[test]
fn truncated_header() {
    let folder = Folder::default();
    let whole = wav(PCM, 1, FS, 16, &pcm16(&healthy()));
    for length in 1..HEADER {
        let file = folder.file("cut.wav", &whole[..length]);
        let ended = program().on("monitor", &file, "--json");
        // Which part is missing differs from byte to byte; what to do does not.
        assert_refused(&ended, &file, &["copy it again"]);
    }
}

#[test]
fn truncated_data_are_analysed_and_the_cut_is_reported() {
    let folder = Folder::default();
    let whole = wav(PCM, 1, FS, 16, &pcm16(&healthy()));
    // Half of the samples and half a sample more.
    let file = folder.file("cut.wav", &whole[..HEADER + 2 * FS as usize + 1]);
    let ended = program().on("monitor", &file, "--json");
    assert!(matches!(ended.code, Some(0 | 1)), "{ended:?}");
    let (lines, summary) = ended.monitored();
    assert_eq!(summary["samples"], FS);
    assert!(lines.len() > 90, "{} lines in a second", lines.len());
    let notices: Vec<&str> = ended.stderr.lines().collect();
    assert_eq!(notices.len(), 1, "{ended:?}");
    assert!(notices[0].contains("cut.wav") && notices[0].contains("cut off"));
    assert!(notices[0].contains("8000"), "{}", notices[0]);
}

#[test]
fn no_channels() {
    let folder = Folder::default();
    let file = folder.file("none.wav", &wav(PCM, 0, FS, 16, &pcm16(&healthy())));
    monitor_refuses(&file, "", &["0 channels"]);
}

#[test]
fn channel_that_is_not_there() {
    let folder = Folder::default();
    let file = folder.pcm16("mono.wav", FS, &healthy());
    monitor_refuses(&file, "--channel 1", &["channel 1"]);
    let table = folder.file("one.csv", b"0.0,1\n0.1,2\n0.2,1\n");
    identify_refuses(&table, "--channel 3", &["channel 3"]);
}

#[test]
fn nan_and_inf_samples() {
    let folder = Folder::default();
    for (bad, word) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "infinite"),
        (f32::NEG_INFINITY, "infinite"),
    ] {
        let mut samples: Vec<f32> = healthy().iter().map(|&x| x as f32).collect();
        samples[4000] = bad;
        let file = folder.float("bad.wav", FS, &samples);
        monitor_refuses(&file, "", &[word, "sample 4000", "0.5 s"]);
    }
    let table = folder.file("bad.csv", b"# fs = 100\n1\n2\nNaN\n3\n");
    identify_refuses(&table, "", &["NaN"]);
}

#[test]
fn silence() {
    let folder = Folder::default();
    let file = folder.pcm16("silent.wav", FS, &[0.0; 16_000]);
    monitor_refuses(&file, "", &["silence"]);
    let file = folder.float("constant.wav", FS, &[0.25; 16_000]);
    monitor_refuses(&file, "", &["silence", "constant"]);
    identify_refuses(
        &folder.raw("silent.f64", &[0.0; 1000]),
        "--fs 100",
        &["silence"],
    );
}

#[test]
fn full_scale_clipping() {
    let folder = Folder::default();
    let loud: Vec<f64> = healthy().iter().map(|x| 8.0 * x).collect();
    let file = folder.pcm16("loud.wav", FS, &loud);
    monitor_refuses(&file, "", &["clipped", "% of the samples"]);
    // Clipped before it was stored as float.
    let flat: Vec<f32> = loud.iter().map(|x| x.clamp(-1.0, 1.0) as f32).collect();
    let file = folder.float("loud-float.wav", FS, &flat);
    monitor_refuses(&file, "", &["clipped"]);
    let data: Vec<u8> = flat.iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(wav(FLOAT, 1, FS, 32, &data).len(), HEADER + 4 * flat.len());
}

#[test]
fn rate_too_low_for_the_band() {
    let folder = Folder::default();
    let slow: Vec<f64> = healthy().into_iter().step_by(2).collect();
    let file = folder.pcm16("slow.wav", FS / 2, &slow);
    monitor_refuses(&file, "--band 300:2500", &["4000 Hz", "2500 Hz", "too low"]);
    // The same rate is enough for a lower band.
    let ended = program().on("monitor", &file, "--band 200:1600 --json");
    assert!(matches!(ended.code, Some(0 | 1)), "{ended:?}");
}

#[test]
fn order_the_box_does_not_have() {
    let folder = Folder::default();
    let file = folder.pcm16("good.wav", FS, &healthy());
    for order in ["3,2", "5,4", "10,9", "8,6"] {
        let ended = program().on("monitor", &file, &format!("--order {order} --json"));
        assert_eq!(ended.code, Some(3), "order {order}: {ended:?}");
        assert_eq!(ended.stdout, "");
        let lines: Vec<&str> = ended.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "order {order}: {ended:?}");
        assert!(lines[0].starts_with("rarma: "), "{}", lines[0]);
        // Which order, and which ones there are.
        assert!(
            lines[0].contains(order) && lines[0].contains("8,7"),
            "{}",
            lines[0]
        );
    }
}

#[test]
fn csv_with_a_hole() {
    let folder = Folder::default();
    let file = folder.file("hole.csv", b"time,x\n0.0,1\n0.1,2\n0.2,\n0.3,1\n0.4,2\n");
    identify_refuses(&file, "", &["line 4"]);
    monitor_refuses(&file, "", &["line 4"]);
    let file = folder.file("line.csv", b"# fs = 100\n1\n2\n\n3\n");
    identify_refuses(&file, "", &["line 4", "empty line"]);
    let file = folder.file("time.csv", b"0.0,1\n0.1,2\n0.2,1\n0.7,2\n0.8,1\n");
    identify_refuses(&file, "", &["line 4", "4 samples are missing"]);
}

#[test]
fn text_in_a_csv() {
    let folder = Folder::default();
    let file = folder.file("text.csv", b"# fs = 100\n1\n2\nERROR\n3\n");
    identify_refuses(&file, "", &["line 4", "ERROR"]);
}

#[test]
fn too_short_to_say_anything() {
    let folder = Folder::default();
    let file = folder.pcm16("short.wav", FS, &healthy()[..400]);
    monitor_refuses(&file, "", &["too short"]);
    identify_refuses(
        &folder.raw("short.f64", &healthy()[..10]),
        "--fs 100",
        &["too few"],
    );
}

#[test]
fn raw_file_without_a_rate() {
    let folder = Folder::default();
    monitor_refuses(&folder.raw("raw.f64", &healthy()), "", &["--fs"]);
}

#[test]
fn name_that_would_break_the_line() {
    let folder = Folder::default();
    let ended = program().on("monitor", &folder.path().join("two\nlines.wav"), "");
    assert_eq!(ended.code, Some(3));
    assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
}

#[test]
fn second_channel_that_is_not_there() {
    let folder = Folder::default();
    let file = folder.pcm16("mono.wav", FS, &healthy());
    for options in ["--second 1", "--second 1 --json"] {
        let words = ["channel 1", "one channel, number 0", "--second"];
        assert_refused(&program().on("monitor", &file, options), &file, &words);
    }
    let both: Vec<f64> = healthy().iter().flat_map(|x| [*x, -x]).collect();
    let file = folder.file("stereo.wav", &wav(PCM, 2, FS, 16, &pcm16(&both)));
    let ended = program().on("monitor", &file, "--second 2");
    assert_refused(&ended, &file, &["channel 2", "2 channels, numbered 0 to 1"]);
    let file = folder.file("silent.wav", &wav(PCM, 2, FS, 16, &pcm16(&[0.0; 32_000])));
    let ended = program().on("monitor", &file, "--second 1");
    assert_refused(&ended, &file, &["silence", "channel 0"]);
    // The box has one channel in a job; two times the same is no pair.
    let file = folder.file("stereo.wav", &wav(PCM, 2, FS, 16, &pcm16(&both)));
    for (command, options) in [
        ("target", "--second 1"),
        ("monitor", "--second 0"),
        ("monitor", "--second 1 --channel 1"),
    ] {
        let ended = program().on(command, &file, options);
        assert_eq!(
            (ended.code, ended.stdout.as_str()),
            (Some(2), ""),
            "{options}: {ended:?}"
        );
        assert!(ended.stderr.contains("--second"), "{ended:?}");
    }
}

#[test]
fn structure_that_is_none() {
    let folder = Folder::default();
    let recording = folder.pcm16("good.wav", FS, &healthy());
    let mode = r#"{"f": 900, "f_sd": 1, "zeta": 0.05, "zeta_sd": 0.001}"#;
    let cases: [(&str, String, &[&str]); 16] = [
        ("empty.json", String::new(), &["line 1", "not JSON"]),
        (
            "broken.json",
            "{\"modes\": [".into(),
            &["line 1 column", "not JSON"],
        ),
        (
            "other.json",
            "{\"f\": [1]}".into(),
            &["modes", "no such list"],
        ),
        (
            "none.json",
            "{\"modes\": []}".into(),
            &["modes", "there is none"],
        ),
        (
            "nine.json",
            format!("{{\"modes\": [{}]}}", [mode; 9].join(",")),
            &["9 modes", "8"],
        ),
        (
            "hole.json",
            format!("{{\"modes\": [{mode}, {{\"f\": 1}}]}}"),
            &["modes[1].f_sd", "missing"],
        ),
        (
            "null.json",
            format!("{{\"modes\": [{}]}}", mode.replace("0.001", "null")),
            &["modes[0].zeta_sd", "null"],
        ),
        (
            "negative.json",
            format!("{{\"modes\": [{}]}}", mode.replace("900", "-900")),
            &["modes[0]", "-900"],
        ),
        ("empty.csv", "# nothing\n".into(), &["holds nothing"]),
        (
            "names.csv",
            "f,zeta\n900,0.05\n".into(),
            &["line 1", "no column f_sd"],
        ),
        (
            "text.csv",
            "f,f_sd,zeta,zeta_sd\n900,1,ERROR,0.001\n".into(),
            &["line 2", "ERROR", "column 3"],
        ),
        (
            "hole.csv",
            "f,f_sd,zeta,zeta_sd\n\n900,1,,0.001\n".into(),
            &["line 3", "column 3"],
        ),
        (
            "damping.csv",
            "f,f_sd,zeta,zeta_sd\n900,1,5,0.001\n".into(),
            &["line 2", "zeta is 5"],
        ),
        (
            "deviation.csv",
            "f,f_sd,zeta,zeta_sd\n900,1,0.05,-0.001\n".into(),
            &["line 2", "-0.001"],
        ),
        (
            "header.csv",
            "f,f_sd,zeta,zeta_sd\n".into(),
            &["there is none"],
        ),
        ("structure.xlsx", mode.into(), &["name", ".json or .csv"]),
    ];
    let refuses = |file: &Path, words: &[&str]| {
        let options = format!("--json --structure {}", file.display());
        for command in ["monitor", "target"] {
            assert_refused(&program().on(command, &recording, &options), file, words);
        }
    };
    for (name, text, words) in cases {
        refuses(&folder.file(name, text.as_bytes()), words);
    }
    refuses(&folder.path().join("nowhere.json"), &["no such file"]);
    refuses(folder.path(), &["is a directory"]);
    refuses(
        &folder.file("binary.json", b"{\"modes\xff"),
        &["byte 7", "not plain text"],
    );
}

#[test]
fn wrong_usage_is_code_2() {
    let folder = Folder::default();
    let file = folder.pcm16("good.wav", FS, &healthy());
    for options in [
        "--threshold 3",
        "--band 500",
        "--rpm -5",
        "--every 0",
        "--nonsense",
    ] {
        let ended = program().on("monitor", &file, options);
        assert_eq!(ended.code, Some(2), "{options}: {ended:?}");
        assert_eq!(ended.stdout, "", "{options}");
    }
}
