//! Promise: a recording says the same as WAV, FLAC, MP3 and AAC, but for what the page says,
//! and what a codec leaves of a weak mode beside a loud line is known.
//!
//! The tables of docs/bench.md are made here and compared: `RARMA_WRITE_TABLE=1 cargo test
//! --release -p host-tests --test compressed_table` writes them. They belong to one version
//! of the encoder: with another the bars hold, and the table is not compared.

use host_tests::encoder::Encoder;
use host_tests::files::Folder;
use host_tests::resources::{Known, shared_or_skip};
use host_tests::watch::each;
use host_tests::{page, rarma, signal};
use rarma_recordings::input::{self, ReadOptions, Recording};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Ten recordings: seven of sound as they are, three of a slow accelerometer written at the
/// lowest rate that every codec has.
const FILES: [(&str, Option<u32>); 10] = [
    ("hafez_mill_sound/chatter", None),
    ("hafez_mill_sound/stable", None),
    ("hafez_mill_sound/idle_sound", None),
    ("purdue_mt_cutting_video_audio/Exp0-1_video_audio", None),
    ("rahimi_mill_sound/combined_chatter6567", None),
    ("shamaseen_tool_sound/RPM635BASE0001", None),
    ("shamaseen_tool_sound/RPM635BASE0013", None),
    ("yang_hurco_accel/EBI_T50_0p25IN_6900RPM_X", Some(8000)),
    ("yang_hurco_accel/EBI_T50_0p25IN_6900RPM_Y", Some(8000)),
    (
        "yang_hurco_accel/EBI_F18IN_T50_D0p125_3000RPM_5A_ON_VICE_X",
        Some(8000),
    ),
];

/// Extension, options of the encoder, and what it is called in the table.
const CODECS: [(&str, &str, &str); 3] = [
    ("flac", "-c:a flac", "FLAC"),
    ("mp3", "-c:a libmp3lame -b:a 128k", "MP3"),
    ("m4a", "-c:a aac -b:a 128k", "AAC"),
];

/// What the monitor said.
struct Heard {
    /// On, off (s), f (Hz), lowest ζ.
    alarms: Vec<[Option<f64>; 4]>,
    states: Vec<String>,
}

fn hear(path: &Path, options: &str) -> Heard {
    let ended = rarma!().on("monitor", path, &format!("{options} --json"));
    let (lines, summary) = ended.monitored();
    let alarm = |a: &Value| ["on", "off", "f", "zeta"].map(|key| a[key].as_f64());
    let alarms = summary["alarms"].as_array().expect("alarms");
    let state = |line: &Value| line["state"].as_str().expect("a state").to_owned();
    Heard {
        alarms: alarms.iter().map(alarm).collect(),
        states: lines.iter().map(state).collect(),
    }
}

impl Heard {
    fn words(&self) -> String {
        if self.alarms.is_empty() {
            return "no alarm".to_owned();
        }
        let of = self.alarms.iter().map(|[on, off, f, zeta]| {
            let off = off.map_or("the end".to_owned(), |t| format!("{t:.2} s"));
            let [on, f] = [on, f].map(|x| x.expect("a number"));
            let zeta = 100.0 * zeta.unwrap_or(f64::NAN);
            format!("{f:.1} Hz from {on:.2} to {off}, ζ {zeta:.2} %")
        });
        of.collect::<Vec<_>>().join("; ")
    }

    /// The same alarms, but for their damping.
    fn holds_to(&self, other: &Self, of: &str) {
        let told = format!("{of}: {} for {}", self.words(), other.words());
        assert_eq!(self.alarms.len(), other.alarms.len(), "{told}");
        for (a, b) in self.alarms.iter().zip(&other.alarms) {
            let apart = |k: usize| match (a[k], b[k]) {
                (Some(x), Some(y)) => (x - y).abs(),
                (None, None) => 0.0,
                _ => f64::INFINITY,
            };
            let [on, off, f] = [0, 1, 2].map(apart);
            assert!(on < 0.8 && off < 0.5 && f < 1.0, "{told}");
        }
    }

    /// Part of the lines that tell the same state.
    fn same(&self, other: &Self) -> f64 {
        let both = self.states.iter().zip(&other.states);
        both.filter(|(a, b)| a == b).count() as f64 / self.states.len() as f64
    }
}

fn read(path: &Path) -> Recording {
    input::read(path, &ReadOptions::default()).unwrap_or_else(|why| panic!("{why}"))
}

/// How a decoded recording differs from the sound.
struct Difference {
    /// Its loudness, dB.
    gain_db: f64,
    /// What was added besides, dB beside the sound.
    added_db: f64,
    /// By how many samples it lies later.
    late: i64,
}

fn difference(sound: &Recording, decoded: &Recording) -> Difference {
    let (x, y) = (&sound.samples, &decoded.samples);
    assert_eq!(sound.fs, decoded.fs);
    let at = |late: i64| {
        let pairs = (2000..x.len() as i64 - 2000)
            .filter_map(|n| Some((x[n as usize], y.get(usize::try_from(n + late).ok()?)?)));
        let [xx, xy, yy] = pairs.fold([0.0; 3], |[xx, xy, yy], (x, y)| {
            [xx + x * x, xy + x * y, yy + y * y]
        });
        let gain = xy / xx;
        let rest = (yy - gain * xy).max(0.0) / yy;
        Difference {
            // To a tenth, without the sign of zero.
            gain_db: (200.0 * gain.abs().log10()).round() / 10.0 + 0.0,
            added_db: 10.0 * rest.log10(),
            late,
        }
    };
    // Delays of encoders and decoders by themselves, and their neighbours.
    let lags = (-2i64..=2).chain([-1105, -1024, -529, 529, 576, 1024, 1105, 1152, 2112]);
    let best = lags
        .map(at)
        .min_by(|a, b| a.added_db.total_cmp(&b.added_db));
    best.expect("lags")
}

/// Holds the part of the page where it was made with this encoder.
fn hold(name: &'static str, text: &str, encoder: &Encoder) {
    let writing = std::env::var_os("RARMA_WRITE_TABLE").is_some();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/bench.md");
    let document = std::fs::read_to_string(page).expect("the page");
    let table = format!("{text}\nEncoder: {}.\n", encoder.version);
    if writing || document.contains(&format!("Encoder: {}.", encoder.version)) {
        page::holds("docs/bench.md", name, &table);
    } else {
        let told = "the table of the page is that of another encoder, and not compared";
        let _ = writeln!(std::io::stderr(), "{name}: {}: {told}", encoder.version);
    }
}

#[test]
fn ten_recordings_say_the_same() {
    let test = "ten_recordings_say_the_same";
    let (Some(shared), Some(encoder)) = (shared_or_skip(test), Encoder::or_skip(test)) else {
        return;
    };
    let rows = each(FILES.to_vec(), |(name, slow)| {
        let folder = Folder::default();
        let known = Known::read(&shared, name);
        let file = name.rsplit('/').next().expect("a name");
        let told = known.stated().unwrap_or_default();
        let wav = slow.map_or_else(
            || known.path.clone(),
            |fs| {
                // As loud as 16 bits hold.
                let peak = known
                    .recording
                    .samples
                    .iter()
                    .fold(0.0, |m: f64, x| m.max(x.abs()));
                let options = format!("-ar {fs} -c:a pcm_s16le -af volume={}", 0.7 / peak);
                encoder.make(&known.path, &options, &folder.path().join("as.wav"))
            },
        );
        let (sound, said) = (read(&wav), hear(&wav, &told));
        let mut out = format!("| {file} | {told} | WAV | {} | | | | |\n", said.words());
        for (ending, options, codec) in CODECS {
            let to = folder.path().join(format!("as.{ending}"));
            let packed = encoder.make(&wav, options, &to);
            let (decoded, heard) = (read(&packed), hear(&packed, &told));
            let Difference {
                gain_db,
                added_db,
                late,
            } = difference(&sound, &decoded);
            let same = heard.same(&said);
            if codec == "FLAC" {
                assert_eq!(decoded.samples, sound.samples, "{file}");
                assert_eq!((heard.words(), same), (said.words(), 1.0), "{file}");
            }
            assert_eq!(late, 0, "{file}, {codec}: shifted");
            heard.holds_to(&said, &format!("{file}, {codec}"));
            let words = match heard.words() {
                words if words == said.words() => "the same".to_owned(),
                words => words,
            };
            let added = match decoded.samples == sound.samples {
                true => "none".to_owned(),
                false => format!("{added_db:.0}"),
            };
            // Writing to a String cannot fail.
            let _ = writeln!(
                out,
                "| {file} | {told} | {} | {words} | {:.1} % | {gain_db:.1} | {added} | {late} |",
                decoded.format,
                100.0 * same
            );
        }
        out
    });
    let head = "| recording | told | file | said | lines with the same state | loudness, dB | added, dB | shift, samples |\n|---|---|---|---|---|---|---|---|\n";
    hold("codecs", &(head.to_owned() + &rows.concat()), &encoder);
}

/// A steady line, Hz, and a mode beside it, Hz and damping ratio.
const LINE_HZ: f64 = 900.0;
const MODE: (f64, f64) = (1500.0, 0.02);
const FS: f64 = 48_000.0;

#[test]
fn a_weak_mode_beside_a_loud_line() {
    let Some(encoder) = Encoder::or_skip("a_weak_mode_beside_a_loud_line") else {
        return;
    };
    let folder = Folder::default();
    let rows = each(vec![20, 30, 40, 50, 60], |below_db| {
        let n = 20 * FS as usize;
        let mode: Vec<f64> = signal::modes(&[MODE], FS, 7).take(n).collect();
        let rms = (mode.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
        let line_rms = 0.3 / 2f64.sqrt();
        let gain = line_rms / rms * 10f64.powf(-f64::from(below_db) / 20.0);
        let hiss = signal::modes(&[(9000.0, 0.7)], FS, 8).map(|x| 1e-5 * x);
        let sound: Vec<f64> = (0..n)
            .zip(mode.iter().zip(hiss))
            .map(|(k, (x, hiss))| {
                0.3 * (std::f64::consts::TAU * LINE_HZ * k as f64 / FS).sin() + gain * x + hiss
            })
            .collect();
        let wav = folder.pcm16(&format!("{below_db}.wav"), FS as u32, &sound);
        let zeta = |file: &Path| {
            let options = "--order 6,5 --band 300:2500 --json";
            let fit = rarma!().on("identify", file, options).json();
            let modes = fit["modes"].as_array().expect("modes");
            let near = |m: &&Value| (m["f"].as_f64().expect("f") / MODE.0 - 1.0).abs() < 0.05;
            let found = modes.iter().filter(near);
            let zetas = found.map(|m| 100.0 * m["zeta"].as_f64().expect("zeta"));
            zetas
                .min_by(f64::total_cmp)
                .map_or("lost".to_owned(), |z| format!("{z:.2} %"))
        };
        let mut row = format!("| {below_db} dB below | {}", zeta(&wav));
        for (ending, options, _) in CODECS {
            let to = folder.path().join(format!("{below_db}.{ending}"));
            let _ = write!(row, " | {}", zeta(&encoder.make(&wav, options, &to)));
        }
        row + " |\n"
    });
    let head = "| mode beside the line | WAV | FLAC | MP3 | AAC |\n|---|---|---|---|---|\n";
    hold("weak-modes", &(head.to_owned() + &rows.concat()), &encoder);
}
