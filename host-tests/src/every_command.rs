//! Every command of `rarma` once, short: what it reads, says and writes.

use crate::files::Folder;
use crate::frames::Sender;
use crate::process::Rarma;
use crate::signal;
use std::fs;
use std::path::{Path, PathBuf};

const FS: u32 = 8000;

/// Inputs of all commands.
#[derive(Debug)]
pub struct Inputs {
    folder: Folder,
}

/// A command: its name (as `els model`), its words, and what it writes.
#[derive(Debug, Clone)]
pub struct Case {
    /// Which command.
    pub command: &'static str,
    /// All words, the command's included. `OUT` stands for the folder that is written into.
    words: String,
    /// Files that it writes, below that folder.
    pub writes: &'static [&'static str],
}

impl Case {
    /// The words before inputs and outputs have their places.
    #[must_use]
    pub fn options(&self) -> Vec<&str> {
        self.words.split_whitespace().collect()
    }

    /// The words of the command line.
    #[must_use]
    pub fn arguments(&self, inputs: &Inputs, out: &Path) -> Vec<String> {
        let place = |path: &Path| path.to_str().expect("a name").to_owned();
        self.words
            .split_whitespace()
            .map(|word| match word.strip_prefix("IN/") {
                Some(name) => place(&inputs.at(name)),
                None => word.replace("OUT", &place(out)),
            })
            .collect()
    }
}

/// The commands that can be run on any machine. A test asks that none is missing; `target`
/// needs an emulator and says what `monitor` says, by the same lines; `connect` needs a box
/// that answers; `listen` needs a sound card (`rarma-cli/tests/sound_card.rs`); `store`, `trends`, `plant`
/// and `gateway` need the feature `fleet` (`rarma-cli/tests/fleet.rs`, `gateway.rs`).
pub const ELSEWHERE: [&str; 12] = [
    "gateway",
    "target",
    "connect",
    "listen",
    "store add",
    "store receive",
    "store show",
    "store ask",
    "store export",
    "store thin",
    "trends",
    "plant",
];

/// One case or more of every command but [`ELSEWHERE`].
#[must_use]
pub fn cases() -> Vec<Case> {
    let case = |command, words: &str, writes| Case {
        command,
        words: format!("{command} {words}"),
        writes,
    };
    vec![
        case(
            "monitor",
            "IN/sound.wav --report OUT/page",
            &["page/index.html"],
        ),
        case("monitor", "IN/sound.wav --json", &[]),
        case(
            "advise",
            "IN/sound.wav --rpm 3000 --teeth 2 --reach 60:120 --report OUT/page",
            &["page/index.html"],
        ),
        case("advise", "IN/sound.wav --json", &[]),
        case(
            "advise",
            "IN/sound.wav --rpm 11000 --teeth 3 --machine three-mode-chatter --json",
            &[],
        ),
        case(
            "act",
            "IN/sound.wav --rpm 3000 --teeth 2 --controller dry --override 60:120 --log OUT/act.jsonl --report OUT/page",
            &["page/index.html"],
        ),
        case(
            "act",
            "IN/sound.wav --rpm 3000 --teeth 2 --controller dry --json",
            &[],
        ),
        case("identify", "IN/sound.wav --order 2,1", &[]),
        case("identify", "IN/sound.wav --order 2,1 --json", &[]),
        case(
            "identify",
            "IN/sound.wav --channels all --order 2,0 --rows 10",
            &[],
        ),
        case(
            "identify",
            "IN/sound.wav --order 2,1 --report OUT/page",
            &["page/index.html"],
        ),
        case(
            "identify",
            "IN/sound.wav --channels all --order 2,0 --report OUT/page",
            &["page/index.html"],
        ),
        case("order", "IN/sound.wav --max 2", &[]),
        case(
            "order",
            "IN/sound.wav --max 2 --report OUT/page",
            &["page/index.html"],
        ),
        case("psd", "IN/sound.wav --method welch", &[]),
        case("psd", "IN/sound.wav --method welch --json", &[]),
        case(
            "psd",
            "IN/sound.wav --method welch --out OUT/psd.uff",
            &["psd.uff"],
        ),
        case(
            "convert",
            "IN/sound.wav --out OUT/sound.mat",
            &["sound.mat"],
        ),
        case(
            "convert",
            "IN/sound.wav --unit Pa --out OUT/sound.uff",
            &["sound.uff"],
        ),
        case(
            "lobes",
            "turning-980 --speeds 2 --report OUT/page",
            &["page/index.html"],
        ),
        case("lobes", "turning-980 --speeds 2 --json", &[]),
        case(
            "simulate",
            "turning-980 --out OUT/cut.wav --truth OUT/cut.json",
            &["cut.wav", "cut.json"],
        ),
        case("simulate", "turning-980 --out OUT/cut.mat", &["cut.mat"]),
        case("simulate", "--list", &[]),
        case("simulate", "--schema", &[]),
        case(
            "choose-order",
            "turning-980 --max 2 --seconds 0.5 --runs 1 --settings OUT/set.json",
            &["set.json"],
        ),
        case(
            "sweep",
            "turning-980 --depth-mm 0.05:0.1 --steps 2 --seconds 0.5 --report OUT/page",
            &["page/index.html"],
        ),
        case(
            "population",
            "--seeds 3:4 --told exact --out OUT/cuts --report OUT/page",
            &["cuts/cut-000003.wav", "cuts/labels.json", "page/index.html"],
        ),
        case("population", "--seeds 3:4 --detectors none --json", &[]),
        case(
            "els model",
            "els-short-tool --uff OUT/tool.uff --report OUT/page",
            &["tool.uff", "page/index.html"],
        ),
        case(
            "els limit",
            "IN/tool.uff --uff OUT/tool.uff --report OUT/page",
            &["tool.uff", "page/index.html"],
        ),
        case(
            "els hammer",
            "IN/force.wav IN/response.wav --band 500:3000 --uff OUT/tool.uff --report OUT/page",
            &["tool.uff", "page/index.html"],
        ),
        case(
            "els fit",
            "els-short-tool --unknown joint.0 --receptance IN/tool.uff",
            &[],
        ),
        case(
            "ldbb run",
            "ldbb-m5 --out OUT/test --report OUT/page",
            &["test/analysis.json", "page/index.html"],
        ),
        case(
            "ldbb analyse",
            "IN/bar --save OUT/bar.json --report OUT/page",
            &["bar.json", "page/index.html"],
        ),
        case(
            "ldbb compare",
            "IN/bar IN/bar --report OUT/page",
            &["page/index.html"],
        ),
        case(
            "cers run",
            "cers-rest --quick --out OUT/record --csv OUT/r.csv --uff OUT/r.uff --structure OUT/modes --report OUT/page",
            &[
                "record/signals.wav",
                "record/record.toml",
                "r.csv",
                "r.uff",
                "modes/structure-x.json",
                "modes/structure-y.json",
                "page/index.html",
            ],
        ),
        case(
            "cers analyse",
            "IN/cers --quick --csv OUT/r.csv --uff OUT/r.uff --report OUT/page",
            &["r.csv", "r.uff", "page/index.html"],
        ),
        case("box", "--sim IN/box.toml --record OUT/box.frames", &[]),
        case("box", "--sim IN/box.toml --json", &[]),
        case("box", "--list", &[]),
        case("box", "--settings", &[]),
        case("decode", "IN/box.frames --wav OUT/box.wav", &["box.wav"]),
        case("decode", "IN/box.frames --json", &[]),
        case(
            "demo",
            "--out OUT/demo",
            &["demo/telemetry.bin", "demo/index.html"],
        ),
        case("completions", "bash", &[]),
        case("completions", "zsh", &[]),
        case("man", "--out OUT/man", &["man/rarma.1"]),
    ]
}

impl Inputs {
    /// Makes them.
    ///
    /// # Panics
    /// A command that should make one fails.
    #[must_use]
    pub fn new(rarma: Rarma) -> Self {
        let folder = Folder::default();
        let sound: Vec<f64> = signal::modes(&[(900.0, 0.05)], f64::from(FS), 1)
            .map(|x| 0.15 * x)
            .take(2 * FS as usize)
            .collect();
        let _ = folder.pcm16("sound.wav", FS, &sound);
        let (force, response) = blow();
        let _ = folder.float("force.wav", 20_000, &force);
        let _ = folder.float("response.wav", 20_000, &response);
        let _ = folder.file("box.toml", b"name = \"box\"\nabout = \"streams\"\nduration_s = 1.0\nhears = \"quiet\"\nhost = [{ at_s = 0.05, say = \"stream 0.9\" }]\n");
        let mut sender = Sender::new(1);
        let mut frames = sender.started(f64::from(FS));
        let codes: Vec<i16> = sound.iter().map(|x| (x * 32_767.0) as i16).collect();
        frames.extend(sender.raw(0, &codes));
        let _ = folder.file("box.frames", &frames);
        let inputs = Self { folder };
        for words in [
            ["els", "model", "els-short-tool", "--uff", "tool.uff"],
            ["ldbb", "run", "ldbb-m5", "--out", "bar"],
            ["cers", "run", "cers-rest", "--quick", "--out=cers"],
        ] {
            let mut words: Vec<String> = words.map(str::to_owned).to_vec();
            if let Some(last) = words.last_mut() {
                let (option, name) = last.split_once('=').unwrap_or(("", last));
                let path = inputs.at(name).display().to_string();
                *last = if option.is_empty() {
                    path
                } else {
                    format!("{option}={path}")
                };
            }
            let ended = rarma.run(&words);
            assert_eq!(ended.code, Some(0), "{ended:?}");
        }
        inputs
    }

    /// Where an input is.
    #[must_use]
    pub fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// A blow with a hammer, N, and how a tool of two modes answers, m/s²; 20 kHz.
fn blow() -> (Vec<f32>, Vec<f32>) {
    let mut force = vec![0.0; 20_000];
    for (k, f) in force[100..110].iter_mut().enumerate() {
        *f = 1000.0 * (std::f32::consts::PI * (k as f32 + 0.5) / 10.0).sin();
    }
    let answer = |k: usize| {
        let t = (k as f64 - 105.0) / 20_000.0;
        let mode = |f_hz: f64, zeta: f64| {
            let w = std::f64::consts::TAU * f_hz;
            50.0 * (-zeta * w * t).exp() * (w * t).sin()
        };
        if t > 0.0 {
            mode(1000.0, 0.02) + mode(2000.0, 0.015)
        } else {
            0.0
        }
    };
    // A sensor is never quite still.
    let noise = signal::modes(&[(5000.0, 0.3)], 20_000.0, 3);
    let response = (0..20_000).zip(noise);
    let response = response.map(|(k, x)| (answer(k) + 0.01 * x) as f32);
    (force, response.collect())
}

/// What is left in a folder by somebody who did not come to the end.
///
/// # Panics
/// The folder cannot be read.
#[must_use]
pub fn parts(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            out.extend(parts(&path));
        } else if path.extension().is_some_and(|e| e == "part") {
            out.push(path);
        }
    }
    out
}
