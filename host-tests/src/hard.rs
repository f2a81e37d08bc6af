//! The program under hard bounds of time and memory.

use crate::process::Rarma;
use std::ffi::OsStr;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A run that waits for something takes no time of the processor: it may last so many times
/// longer.
const WAITING: u32 = 20;
/// The signal at the end of a program's time.
const SIGXCPU: i32 = 24;

/// What a run may take.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Address space, KiB.
    pub kib: u64,
    /// Time of the processor, whole seconds, far beyond what any good run takes: beyond it, it
    /// does not end. What else the machine does is no part of it.
    pub time: Duration,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            kib: 1 << 20,
            time: Duration::from_secs(120),
        }
    }
}

/// How it ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Well, or with one line of refusal.
    Well,
    /// In another way.
    Bad(String),
}

/// Runs the program within bounds: it must end with one of the codes 0 to 3, 3 with one
/// line on standard error, and must not panic.
///
/// # Panics
/// It cannot be started.
pub fn bounded(
    program: Rarma,
    arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
    bounds: Bounds,
) -> Verdict {
    held(program.program().as_ref(), arguments, bounds)
}

fn held(
    program: &OsStr,
    arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
    bounds: Bounds,
) -> Verdict {
    let (kib, seconds) = (bounds.kib, bounds.time.as_secs());
    let limits = format!("ulimit -v {kib}; ulimit -S -t {seconds}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limits])
        .arg(program)
        .args(arguments)
        // Every thread's heap would ask for 64 MiB of addresses of its own.
        .env("MALLOC_ARENA_MAX", "2")
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let mut pipe = child.stderr.take().expect("its standard error");
    let reader = thread::spawn(move || {
        let mut text = Vec::new();
        let _ = pipe.read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    });
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().expect("a child") {
            Some(status) => break status,
            None if begun.elapsed() > WAITING * bounds.time => {
                let _ = child.kill();
                let _ = child.wait();
                return Verdict::Bad(format!("waits on after {:?}", WAITING * bounds.time));
            }
            None => thread::sleep(Duration::from_millis(5)),
        }
    };
    let stderr = reader.join().expect("a reader");
    // What is odd about a file is said before it is refused.
    let refusals = stderr.lines().filter(|line| line.starts_with("rarma: "));
    let lines = refusals.count();
    match status.code() {
        _ if stderr.contains("panicked") => Verdict::Bad(stderr),
        None if status.signal() == Some(SIGXCPU) => {
            Verdict::Bad(format!("runs on after {:?}", bounds.time))
        }
        Some(0..=2) => Verdict::Well,
        Some(3) if lines == 1 => Verdict::Well,
        code => Verdict::Bad(format!("ends with {code:?}: {stderr}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(line: &str) -> Verdict {
        let bounds = Bounds {
            time: Duration::from_secs(1),
            ..Bounds::default()
        };
        held("sh".as_ref(), ["-c", line], bounds)
    }

    #[test]
    fn a_program_that_runs_on_is_ended() {
        let Verdict::Bad(why) = shell("while :; do :; done") else {
            panic!("it never ends");
        };
        assert!(why.contains("runs on after 1s"), "{why}");
        assert_eq!(shell("sleep 2"), Verdict::Well);
        assert_eq!(shell("echo rarma: no >&2; exit 3"), Verdict::Well);
        assert!(matches!(shell("exit 3"), Verdict::Bad(_)));
    }
}
