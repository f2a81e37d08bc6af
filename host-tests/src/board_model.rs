//! The image for the NUCLEO-G474RE on the model of its chip (tools/g474-model): one run, what the
//! host says in it, and what came back.

use crate::resources::board_image_or_skip;
use rarma_box::guard::Mode;
use rarma_box::settings::SettingValue;
use rarma_box::wire::{Command as Word, Deframer, Head, MAX_FRAME, Order, Telemetry, encode_order};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use xtask::chip::TRACE;
use xtask::chip::figures::Figures;
use xtask::chip::program::Program;
use xtask::chip::trace::Trace;

/// The first words of the model's random numbers (tools/g474-model/entropy.py): the session,
/// the turn of nobody at start, and that of the first host that takes control.
pub const SESSION: u32 = 0x5E55_0001;
/// The turn of nobody.
pub const NOBODYS: u32 = SESSION + 1;
const OURS: u32 = SESSION + 2;
/// Where the image for the NUCLEO-G474RE has its settings (firmware/memory/nucleo-g474re.x).
pub const SETTINGS_AT: u32 = 0x0807_8000;
/// How many bytes.
pub const SETTINGS_BYTES: usize = 0x8000;
/// The number of the host itself.
const HOST: u32 = 7;

/// What one run of the model brought.
#[derive(Debug)]
pub struct Seen {
    /// Every frame.
    pub frames: Vec<(Head, Telemetry)>,
    /// What was seen from outside.
    pub run: Value,
    /// What was executed from the moment on that `--count-from` names; nothing without it.
    pub trace: Trace,
    /// The image's program.
    pub program: Program,
    /// Its file.
    pub image: PathBuf,
}

/// Runs the image: codes of the microphone, what happens at its pins, options of the model.
///
/// # Panics
/// The model fails, or the image gets stuck in it.
#[must_use]
pub fn run(
    name: &str,
    seconds: f64,
    codes: &[u16],
    script: &Value,
    options: &[&str],
) -> Option<Seen> {
    let (image, model, packages) = board_image_or_skip(name)?;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |file: &str, bytes: &[u8]| {
        let path = folder.path().join(file);
        std::fs::write(&path, bytes).expect("the temporary folder takes files");
        path
    };
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    let output = Command::new("python3")
        .env("PYTHONPATH", packages)
        .arg(model)
        .args([&image, folder.path()])
        .args(["--seconds", &seconds.to_string()])
        .arg("--microphone-1")
        .arg(write("sound.u16", &bytes))
        .arg("--script")
        .arg(write("script.json", script.to_string().as_bytes()))
        .args(options)
        .output()
        .expect("python3 starts");
    assert!(
        output.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let program = Program::read_file(&image).expect("an image for this chip");
    let trace = match options.contains(&"--count-from") {
        true => Trace::read(&folder.path().join(TRACE), &program).expect("a whole trace"),
        false => Trace::default(),
    };
    let is_cut = options.contains(&"--resets");
    let run = read_json(&folder.path().join("run.json"));
    // Every access to a register is judged by published data, in every test.
    let findings = run["judged"]["findings"].as_array().expect("a list");
    assert!(findings.is_empty(), "{name}: {findings:#?}");
    Some(Seen {
        frames: frames(&folder.path().join("frames.bin"), is_cut),
        run,
        trace,
        program,
        image,
    })
}

/// What the model says when it refuses what it is given: the image, then options; an image of no
/// name is the board's own.
///
/// # Panics
/// It refuses nothing.
#[must_use]
pub fn refused(name: &str, arguments: &[String]) -> Option<String> {
    let (image, model, packages) = board_image_or_skip(name)?;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (given, options) = arguments.split_first().expect("an image");
    let image = Some(given)
        .filter(|name| !name.is_empty())
        .map_or(image, Into::into);
    let output = Command::new("python3")
        .env("PYTHONPATH", packages)
        .arg(model)
        .args([&image, folder.path()])
        .args(["--seconds", "0.001"])
        .args(options)
        .output()
        .expect("python3 starts");
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
    Some(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Every configuration write of the image's start, changed in turn: `part` of them, as "0/4".
/// What was run has `killed_by`.
///
/// # Panics
/// The unchanged image fails in the scene.
#[must_use]
pub fn mutants(name: &str, codes: &[u16], scene: &Value, part: &str) -> Option<Vec<Value>> {
    let (image, model, packages) = board_image_or_skip(name)?;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sound = folder.path().join("sound.u16");
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    std::fs::write(&sound, bytes).expect("the temporary folder takes files");
    let script = folder.path().join("scene.json");
    std::fs::write(&script, scene.to_string()).expect("the temporary folder takes files");
    let output = Command::new("python3")
        .env("PYTHONPATH", packages)
        .arg(model.with_file_name("mutants.py"))
        .args([&image, folder.path()])
        .arg("--scene")
        .arg(script)
        .arg("--microphone-1")
        .arg(sound)
        .args(["--part", part])
        .output()
        .expect("python3 starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {said}");
    let found = read_json(&folder.path().join("mutants.json"));
    found.as_array().cloned()
}

fn read_json(path: &Path) -> Value {
    let text = std::fs::read(path).expect("the model writes it");
    serde_json::from_slice(&text).expect("the model writes JSON")
}

/// Every frame. A broken one is a failure, unless a reset has cut the one it came in.
fn frames(path: &Path, is_cut: bool) -> Vec<(Head, Telemetry)> {
    let mut deframer = Deframer::default();
    let mut broken = 0;
    let frames = std::fs::read(path)
        .expect("the model writes it")
        .into_iter()
        .filter_map(|byte| deframer.push::<Telemetry>(byte))
        .filter_map(|frame| frame.inspect_err(|_| broken += 1).ok())
        .collect();
    assert!(broken <= usize::from(is_cut), "{broken} frames are broken");
    frames
}

/// The figures of docs/flash.md belong to a compiler (`cargo xtask chip`): whether the image is
/// another's, which is said.
///
/// # Panics
/// The page is not there, or names no compiler.
#[must_use]
pub fn made_by_another_compiler(test: &str) -> bool {
    let elf = std::env::var_os("RARMA_BOARD_ELF").and_then(|path| std::fs::read(path).ok());
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/flash.md"));
    let compiler = Figures::compiler_in(&page.expect("the page is there"));
    let said = compiler.expect("it names its compiler");
    let said = said.replace("rustc ", "rustc version ");
    let other = elf.is_some_and(|elf| !elf.windows(said.len()).any(|at| at == said.as_bytes()));
    if other {
        eprintln!(
            "SKIPPED: {test}: docs/flash.md has the figures of {said}, the image is another's"
        );
    }
    other
}

/// The host at the link: what it says becomes steps of the model's script.
#[derive(Debug, Default, Clone)]
pub struct Host {
    /// The steps, to be added to.
    pub steps: Vec<Value>,
    sequence: u32,
}

impl Host {
    /// Says a command at a time, s. The first one must take the control.
    ///
    /// # Panics
    /// The command does not fit a frame.
    pub fn say(&mut self, at: f64, command: Word) {
        let mut frame = [0; MAX_FRAME];
        self.sequence += 1;
        let by = if self.sequence == 1 { HOST } else { OURS };
        let order = Order { by, command };
        let bytes = encode_order(&order, SESSION, self.sequence, None, &mut frame);
        let bytes = bytes.expect("a command fits a frame");
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.steps.push(json!([at, "host", hex]));
    }
    /// Brings CERS to its bias: contacts closed, these settings, start, a command, arm, and heartbeats
    /// up to a moment, s.
    #[must_use]
    pub fn armed(seconds: f64, settings: &[(u16, SettingValue)], command: Option<Word>) -> Self {
        let steps = vec![json!([0.0, "PA6", 1]), json!([0.0, "PC8", 1])];
        let mut host = Self { steps, sequence: 0 };
        host.say(0.015, Word::Take { turn: NOBODYS });
        let between = 4e-3 / settings.len().max(1) as f64;
        for (k, &(setting, value)) in settings.iter().enumerate() {
            host.say(0.0155 + between * k as f64, Word::Set { setting, value });
        }
        host.say(0.02, Word::Start(Mode::Cers));
        host.say(0.025, Word::Heartbeat);
        if let Some(command) = command {
            host.say(0.027, command);
        }
        host.say(0.03, Word::Arm);
        let mut at = 0.125;
        while at < seconds {
            host.say(at, Word::Heartbeat);
            at += 0.1;
        }
        host
    }
}
