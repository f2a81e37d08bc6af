//! The program on a pipe, and how much memory it takes.

use crate::process::{Ended, Rarma};
use std::ffi::OsStr;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::Duration;

/// Between two looks at a program's memory.
const LOOK: Duration = Duration::from_millis(2);

/// What a run on a pipe left behind.
#[derive(Debug, Clone)]
pub struct Fed {
    /// How it ended; standard output is empty where it was not wanted.
    pub ended: Ended,
    /// Most memory it held at any time, bytes.
    pub peak_bytes: u64,
}

impl Rarma {
    /// Runs the program, hands it to `feed` what it reads, and watches its memory. What it
    /// writes is dropped unless it is `wanted`.
    ///
    /// # Panics
    /// It cannot be started, or prints what is not UTF-8.
    pub fn fed(
        self,
        arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
        wanted: bool,
        feed: impl FnOnce(&mut dyn Write) -> io::Result<()> + Send + 'static,
    ) -> Fed {
        let mut command = Command::new(self.program());
        command.args(arguments).stdin(Stdio::piped());
        let out = if wanted {
            Stdio::piped()
        } else {
            Stdio::null()
        };
        command.stdout(out).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program");
        let stdin = child.stdin.take().expect("its standard input");
        let feeder = thread::spawn(move || {
            let mut pipe = io::BufWriter::with_capacity(1 << 16, stdin);
            // A program that ends early reads no more: its exit code tells.
            let _ = feed(&mut pipe).and_then(|()| pipe.flush());
        });
        let stdout = child.stdout.take().map(|pipe| thread::spawn(|| all(pipe)));
        let stderr = child.stderr.take().map(|pipe| thread::spawn(|| all(pipe)));
        let (code, peak_bytes) = watched(&mut child);
        feeder.join().expect("a feeder");
        let text = |reader: Option<thread::JoinHandle<String>>| {
            reader.map_or_else(String::new, |r| r.join().expect("a reader"))
        };
        Fed {
            ended: Ended {
                code,
                stdout: text(stdout),
                stderr: text(stderr),
            },
            peak_bytes,
        }
    }

    /// Starts the program with its standard input and output in hand; its standard error is the child's.
    ///
    /// # Panics
    /// It cannot be started.
    pub fn talking(
        self,
        arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
    ) -> (Child, ChildStdin, impl Iterator<Item = String>) {
        let mut child = Command::new(self.program())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let stdin = child.stdin.take().expect("its standard input");
        let stdout = BufReader::new(child.stdout.take().expect("its standard output"));
        (child, stdin, stdout.lines().map_while(Result::ok))
    }
}

fn all(mut pipe: impl Read) -> String {
    let mut text = String::new();
    pipe.read_to_string(&mut text).expect("UTF-8 on a pipe");
    text
}

/// Interrupts a program, as Ctrl-C does.
///
/// # Panics
/// The system knows no `kill`.
pub fn interrupt(child: &Child) {
    signal(child, "INT");
}

/// Sends a program a signal of this name (`INT`, `TERM`, …).
///
/// # Panics
/// The system knows no `kill`.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([&format!("-{name}"), &child.id().to_string()])
        .status();
    assert!(sent.expect("kill").success());
}

/// Waits for the end; the exit code, and the most memory held, bytes.
fn watched(child: &mut Child) -> (Option<i32>, u64) {
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let held = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let kib = held.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok());
        most = most.max(1024 * kib.unwrap_or(0));
        match child.try_wait() {
            Ok(None) => thread::sleep(LOOK),
            Ok(Some(status)) => return (status.code(), most),
            Err(why) => panic!("{why}"),
        }
    }
}

/// Sound of a machine that idles, cuts, and chatters for a while in every half minute, as
/// 16 bit samples: made as it is read, so that it may be of any length.
#[derive(Debug, Clone)]
pub struct Workday {
    fs_hz: f64,
    /// Length of a half minute, s.
    round_s: f64,
    /// Samples written for each of the machine's.
    every: u64,
    written: u64,
    /// The machine's samples before and after.
    between: [f64; 2],
    sample: u64,
    random: u64,
    /// Two resonances: state of each.
    modes: [[f64; 2]; 2],
}

/// The machine is played at this rate, Hz; at a multiple of it, straight lines join its samples.
const STEPS_HZ: f64 = 8_000.0;
/// The machine idles, cuts and chatters once in so long, s.
const ROUND_S: f64 = 30.0;
/// Frequencies of the two resonances, Hz; the second one chatters.
const MODES_HZ: [f64; 2] = [640.0, 1_130.0];

impl Workday {
    /// From its beginning.
    #[must_use]
    pub fn new(fs_hz: f64) -> Self {
        Self {
            fs_hz,
            round_s: ROUND_S,
            every: (fs_hz / STEPS_HZ).round().max(1.0) as u64,
            written: 0,
            between: [0.0; 2],
            sample: 0,
            random: 0x2545_f491_4f6c_dd1d,
            modes: [[0.0; 2]; 2],
        }
    }

    /// The same with so many rounds of idling, cutting and chatter in half a minute.
    #[must_use]
    pub fn hurried(self, rounds: u32) -> Self {
        Self {
            round_s: ROUND_S / f64::from(rounds),
            ..self
        }
    }

    /// White noise, −1 to 1.
    fn noise(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Writes a WAV of `seconds`, its length unknown to the header.
    ///
    /// # Errors
    /// The pipe is closed.
    pub fn write(mut self, seconds: f64, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&endless_header(self.fs_hz as u32))?;
        let samples = (seconds * self.fs_hz) as u64;
        let mut block = Vec::with_capacity(8192);
        for x in self.by_ref().take(samples as usize) {
            block.extend(x.to_le_bytes());
            if block.len() == 8192 {
                out.write_all(&block)?;
                block.clear();
            }
        }
        out.write_all(&block)
    }
}

impl Iterator for Workday {
    type Item = i16;

    fn next(&mut self) -> Option<i16> {
        let part = self.written % self.every;
        self.written += 1;
        if part == 0 {
            self.between = [self.between[1], self.step()];
        }
        let [from, to] = self.between;
        let x = from + (to - from) * part as f64 / self.every as f64;
        Some((x * 32_767.0) as i16)
    }
}

impl Workday {
    /// The machine's next sample at [`STEPS_HZ`].
    fn step(&mut self) -> f64 {
        let t = self.sample as f64 / STEPS_HZ % self.round_s * (ROUND_S / self.round_s);
        self.sample += 1;
        let drive = match t {
            t if t < 6.0 => 0.002,
            _ => 0.05,
        };
        let mut sum = 0.002 * self.noise();
        for (k, f) in MODES_HZ.into_iter().enumerate() {
            let chatters = k == 1 && (20.0..22.0).contains(&t);
            let zeta = if chatters { 0.0 } else { 0.03 };
            let w = std::f64::consts::TAU * f / STEPS_HZ;
            let (r, noise) = ((-zeta * w).exp(), drive * self.noise());
            let [a, b] = self.modes[k];
            let mut y = 2.0 * r * w.cos() * a - r * r * b + noise * w;
            if chatters {
                y = y.clamp(-0.4, 0.4);
            }
            self.modes[k] = [y, a];
            sum += y;
        }
        sum.clamp(-0.9, 0.9)
    }
}

/// Header of a WAV of one channel whose writer did not know its length.
#[must_use]
pub fn endless_header(fs_hz: u32) -> Vec<u8> {
    let mut header = crate::files::wav(crate::files::PCM, 1, fs_hz, 16, &[]);
    header[4..8].fill(0xff);
    header[40..44].fill(0xff);
    header
}
