//! `rarma act` as a user runs it: live sound on standard input, which chatters for as long as it is played,
//! whatever is ordered.

use crate::piped::signal;
use crate::process::{Ended, Rarma};
use rarma_plants::cut::VirtualCut;
use rarma_scenarios::scenario;
use serde_json::Value;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// What is heard.
const SCENARIO: &str = "three-mode-chatter";
/// Its speed, 1/min.
pub const RPM: f64 = 11_000.0;
/// It is played for so long at most, s: longer than any test waits.
const SOUND_S: f64 = 120.0;
/// A test waits so long at most.
const LONGEST: Duration = Duration::from_secs(60);
/// Sound is handed over in pieces of, s.
const PIECE_S: f64 = 0.02;

/// The program while it listens. Dropped, it is killed.
pub struct Acting {
    child: Child,
    sound: Option<JoinHandle<()>>,
    silent: Arc<AtomicBool>,
    folder: PathBuf,
}

impl Acting {
    /// `rarma act -` with these options, blank between them; what it says goes to files of this folder.
    ///
    /// # Panics
    /// It cannot be started.
    #[must_use]
    pub fn begin(rarma: Rarma, folder: &Path, options: &str) -> Self {
        let mut loaded = scenario::load(SCENARIO, Some(1)).expect("a scenario");
        loaded.scenario.duration_s = SOUND_S;
        let mut cut = VirtualCut::new(&loaded.scenario).expect("a cut");
        let fs_hz = cut.sample_rate_hz();
        // Files: a pipe that nobody reads would hold it up.
        let file = |name: &str| File::create(folder.join(name)).expect("a file");
        let mut child = Command::new(rarma.program())
            .args(["act", "-", "--raw", "f32", "--fs", &fs_hz.to_string()])
            .args(["--teeth", "3", "--json"])
            .args(options.split_whitespace())
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(file("stdout.txt"))
            .stderr(file("stderr.txt"))
            .spawn()
            .expect("the program");
        let mut input = child.stdin.take().expect("a pipe");
        let silent = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&silent);
        let sound = thread::spawn(move || {
            let begun = Instant::now();
            let piece = (PIECE_S * fs_hz) as usize;
            let mut played_s = 0.0;
            while !ends.load(Ordering::SeqCst) {
                let samples = cut.by_ref().take(piece).map(|r| r.value);
                let bytes: Vec<u8> = samples.flat_map(f32::to_le_bytes).collect();
                // A program that has ended reads no more.
                if bytes.is_empty() || input.write_all(&bytes).is_err() {
                    return;
                }
                played_s += PIECE_S;
                let due = Duration::from_secs_f64(played_s);
                thread::sleep(due.saturating_sub(begun.elapsed()));
            }
        });
        Self {
            child,
            sound: Some(sound),
            silent,
            folder: folder.to_owned(),
        }
    }

    /// Waits until it is so.
    ///
    /// # Panics
    /// The program has ended before, or it takes too long.
    pub fn until(&mut self, what: &str, mut is: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !is() {
            let ended = self.child.try_wait().expect("a child");
            let waits = ended.is_none() && begun.elapsed() < LONGEST;
            assert!(waits, "{what}: {ended:?}: {}", self.said("stderr.txt"));
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Sends it a signal of this name.
    pub fn signal(&self, name: &str) {
        signal(&self.child, name);
    }

    /// The sound ends, and standard input with it.
    pub fn end_sound(&mut self) {
        self.silent.store(true, Ordering::SeqCst);
        if let Some(sound) = self.sound.take() {
            sound.join().expect("a sound");
        }
    }

    /// Waits for its end; the sound goes on unless it was ended.
    ///
    /// # Panics
    /// It does not end.
    pub fn ended(&mut self) -> Ended {
        let begun = Instant::now();
        let status: ExitStatus = loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                break status;
            }
            let said = || self.said("stderr.txt");
            assert!(begun.elapsed() < LONGEST, "it does not end: {}", said());
            thread::sleep(Duration::from_millis(10));
        };
        Ended {
            code: status.code(),
            stdout: self.said("stdout.txt"),
            stderr: self.said("stderr.txt"),
        }
    }

    fn said(&self, name: &str) -> String {
        fs::read_to_string(self.folder.join(name)).unwrap_or_default()
    }
}

impl Drop for Acting {
    fn drop(&mut self) {
        self.silent.store(true, Ordering::SeqCst);
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The whole lines of a log, so far.
///
/// # Panics
/// A line is not JSON.
#[must_use]
pub fn log_lines(log: &Path) -> Vec<Value> {
    let text = fs::read_to_string(log).unwrap_or_default();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let parse = |line| serde_json::from_str(line).unwrap_or_else(|why| panic!("{why}: {line}"));
    whole.lines().map(parse).collect()
}

/// The words of what happened, so far.
///
/// # Panics
/// As [`log_lines`].
#[must_use]
pub fn acts(log: &Path) -> Vec<String> {
    let word = |line: &Value| line["act"].as_str().expect("an act").to_owned();
    log_lines(log).iter().map(word).collect()
}

/// The log ends with the giving back, because the listening has ended, and with its arrival.
///
/// # Panics
/// It does not.
pub fn ends_given_back(lines: &[Value]) {
    let [.., ends, returned] = lines else {
        panic!("{lines:?}")
    };
    assert_eq!(
        (&ends["act"], &ends["why"]),
        (&"ends".into(), &"ended".into())
    );
    assert_eq!(returned["act"], "returned", "{lines:?}");
}
