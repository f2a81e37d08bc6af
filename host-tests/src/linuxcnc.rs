//! A real LinuxCNC with its simulated spindle, without a screen, for tests.

use crate::act_loop::Turns;
use rarma_cli::controller::Actor;
use rarma_core::act::Reading;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Where tools/linuxcnc/sim/run.py listens.
const RUNNER: &str = "127.0.0.1:9872";
/// Where rarma_override.py does.
pub const COMPONENT: &str = "127.0.0.1:9871";
/// The files of the component.
const TOOLS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tools/linuxcnc");
/// The line of rarma.hal that says after how long without a beat HAL gives back, s.
const DEAD_MAN: &str = "setp watchdog.timeout-0 ";
/// It has this long to start.
const START: Duration = Duration::from_secs(60);

/// One that runs.
pub struct LinuxCnc {
    child: Child,
    lines: BufReader<TcpStream>,
}

impl LinuxCnc {
    /// Starts it in a folder of its own, as another user where this one is root: it will not
    /// run as root.
    ///
    /// # Panics
    /// It does not start: what it said stands in the folder's `said.txt`.
    #[must_use]
    pub fn start(folder: &Path) -> Self {
        alone();
        for name in [
            "rarma.hal",
            "rarma_override.py",
            "sim/mill.ini",
            "sim/run.py",
            "sim/spindle.hal",
        ] {
            let from = Path::new(TOOLS).join(name);
            let to = folder.join(from.file_name().expect("a name"));
            fs::copy(&from, to).expect("copied");
        }
        for empty in ["mill.var", "mill.tbl"] {
            fs::write(folder.join(empty), "").expect("written");
        }
        let edit = |name: &str, from: &str, to: &str| {
            let path = folder.join(name);
            let text = fs::read_to_string(&path).expect("read");
            assert!(text.contains(from), "{name}: {from}");
            fs::write(path, text.replace(from, to)).expect("written");
        };
        // Some versions want the whole path.
        let runner = folder.join("run.py").display().to_string();
        edit("mill.ini", "./run.py", &runner);
        edit("rarma.hal", "rarma-least 0.8", "rarma-least 0.5");
        edit("rarma.hal", "rarma-most 1.2", "rarma-most 1.5");
        // Without a real-time kernel, on a busy computer, its fast thread has been seen to stand
        // still for longer than 0.3 s, and the dead man did what it is for.
        let shipped = format!("{DEAD_MAN}{}", shipped_dead_man_s());
        edit("rarma.hal", &shipped, &format!("{DEAD_MAN}1.0"));
        let said = fs::File::create(folder.join("said.txt")).expect("a file");
        let root = fs::metadata("/proc/self").is_ok_and(|m| {
            use std::os::unix::fs::MetadataExt as _;
            m.uid() == 0
        });
        let ini = folder.join("mill.ini");
        let mut command = if root {
            let owned = Command::new("chown")
                .args(["-R", "nobody"])
                .arg(folder)
                .status();
            assert!(owned.expect("chown").success());
            // Before other work on this computer: it keeps time.
            let mut command = Command::new("chrt");
            command.args(["--rr", "1", "runuser", "-u", "nobody", "--"]);
            // It goes by the user's own home if it is not told here.
            let home = format!("HOME={}", folder.display());
            command.args(["env", &home, "linuxcnc"]);
            command
        } else {
            Command::new("linuxcnc")
        };
        let child = command
            .args(["-r".as_ref(), ini.as_os_str()])
            .current_dir(folder)
            .env("HOME", folder)
            .env_remove("DISPLAY")
            .stdin(Stdio::null())
            .stderr(said.try_clone().expect("a file"))
            .stdout(said)
            .spawn()
            .expect("linuxcnc");
        let begun = Instant::now();
        let socket = loop {
            match TcpStream::connect(RUNNER) {
                Ok(socket) => break socket,
                Err(why) => {
                    let told = fs::read_to_string(folder.join("said.txt")).unwrap_or_default();
                    assert!(begun.elapsed() < START, "{why}: {told}");
                    thread::sleep(Duration::from_millis(200));
                }
            }
        };
        if root {
            in_time();
        }
        Self {
            child,
            lines: BufReader::new(socket),
        }
    }

    /// Tells tools/linuxcnc/sim/run.py something.
    ///
    /// # Panics
    /// It is not done.
    pub fn say(&mut self, line: &str) {
        assert_eq!(self.ask(line), "done", "{line}");
    }

    /// Runs a program at this speed, 1/min, and waits until the spindle turns so: what is advised goes by the speed that
    /// turns.
    ///
    /// # Panics
    /// It does not get there.
    pub fn run_up(&mut self, rpm: f64) {
        self.say(&format!("run {rpm} 60"));
        let begun = Instant::now();
        let component = TcpStream::connect(COMPONENT).expect("it listens");
        for line in BufReader::new(component).lines() {
            let line = line.expect("a status");
            let status: serde_json::Value = serde_json::from_str(&line).expect("JSON");
            if (status["actual_rpm"].as_f64().unwrap_or(0.0) / rpm - 1.0).abs() < 0.005 {
                break;
            }
            assert!(begun.elapsed() < START, "{line}");
        }
        // It sees that this link has ended before it takes the next.
        thread::sleep(Duration::from_millis(200));
    }

    /// Our factor of the speed, as HAL has it at this moment.
    ///
    /// # Panics
    /// It is not told.
    pub fn factor(&mut self) -> f64 {
        let answer = self.ask("factor");
        answer.parse().unwrap_or_else(|_| panic!("{answer}"))
    }

    /// From now on the dead man has the time of the rarma.hal that is shipped, s, which this returns.
    ///
    /// # Panics
    /// It is not done.
    pub fn dead_man_as_shipped(&mut self) -> f64 {
        let shipped_s = shipped_dead_man_s();
        self.say(&format!("hal {DEAD_MAN}{shipped_s}"));
        shipped_s
    }

    fn ask(&mut self, line: &str) -> String {
        writeln!(self.lines.get_mut(), "{line}").expect("it listens");
        let mut answer = String::new();
        self.lines.read_line(&mut answer).expect("an answer");
        answer.trim_end().to_owned()
    }
}

fn shipped_dead_man_s() -> f64 {
    let text = fs::read_to_string(Path::new(TOOLS).join("rarma.hal")).expect("read");
    let value = text.lines().find_map(|line| line.strip_prefix(DEAD_MAN));
    let value = value.and_then(|value| value.trim().parse().ok());
    value.unwrap_or_else(|| panic!("rarma.hal: no line `{DEAD_MAN}`"))
}

/// There can be one at a time on a computer, and one that was ended needs a moment to go.
fn alone() {
    let begun = Instant::now();
    let runs = || {
        let found = Command::new("pgrep").args(["-x", "rtapi_app"]).output();
        found.is_ok_and(|o| o.status.success())
    };
    while runs() {
        assert!(
            begun.elapsed() < END,
            "another LinuxCNC runs on this computer"
        );
        thread::sleep(Duration::from_millis(100));
    }
}

/// Its fast thread goes back to ordinary scheduling where the kernel has no real time, and stands
/// still for a second now and then on a busy computer.
fn in_time() {
    let done = Command::new("sh")
        .args(["-c", "chrt --all-tasks --rr --pid 1 $(pgrep -x rtapi_app)"])
        .status();
    assert!(done.is_ok_and(|s| s.success()), "chrt of rtapi_app");
}

/// It has this long to end.
const END: Duration = Duration::from_secs(30);

impl Drop for LinuxCnc {
    fn drop(&mut self) {
        let _ = writeln!(self.lines.get_mut(), "quit");
        let begun = Instant::now();
        while let Ok(None) = self.child.try_wait() {
            if begun.elapsed() > END {
                let _ = self.child.kill();
                let _ = self.child.wait();
                return;
            }
            thread::sleep(Duration::from_millis(50));
        }
    }
}

/// The cut goes on as fast as it would, at the speed that LinuxCNC's spindle has: from one
/// report of it to the next, in a straight line, one report late.
#[derive(Debug)]
pub struct RealTime {
    begun: Instant,
    played_s: f64,
    hz: f64,
    reported_hz: f64,
    /// Until the next report is due, s.
    left_s: f64,
    /// The longest that the cut was behind the clock, s.
    pub late_s: f64,
}

/// From one report to the next, s.
const REPORT_S: f64 = 0.02;

impl RealTime {
    /// From now on.
    #[must_use]
    pub fn from_now(hz: f64) -> Self {
        Self {
            begun: Instant::now(),
            played_s: 0.0,
            hz,
            reported_hz: hz,
            left_s: REPORT_S,
            late_s: 0.0,
        }
    }
}

impl Turns for RealTime {
    fn turn(&mut self, actor: &Actor, dt_s: f64) -> f64 {
        self.played_s += dt_s;
        let ahead_s = self.played_s - self.begun.elapsed().as_secs_f64();
        self.late_s = self.late_s.max(-ahead_s);
        thread::sleep(Duration::from_secs_f64(ahead_s.max(0.0)));
        if let Some(hz) = actor.reading().and_then(Reading::spindle_hz)
            && hz != self.reported_hz
        {
            (self.reported_hz, self.left_s) = (hz, REPORT_S);
        }
        let part = (dt_s / self.left_s.max(dt_s)).min(1.0);
        self.hz += (self.reported_hz - self.hz) * part;
        self.left_s -= dt_s;
        self.hz
    }
}
