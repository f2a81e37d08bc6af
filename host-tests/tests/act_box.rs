//! Promise: `rarma act box:PORT` has a box hear: it tells it the speed that turns and the teeth, turns the cut by what the
//! box says over its link, and gives back when the box is gone or somebody else takes it.

use host_tests::act_ear::Firmware;
use host_tests::act_judge::{Kind, SEEDS, drawn};
use host_tests::act_loop::{FS_HZ, virtual_cut};
use host_tests::advice::Case;
use host_tests::files::Folder;
use host_tests::grbl::Grbl;
use rarma_cli::bridge::Bridge;
use rarma_core::decide::StructuralMode;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The tool enters so late that the command is there, s.
const ENTERS_S: f64 = 3.0;

/// Of the cuts of act_loop: 9026 1/min, seven teeth, 73 % is ordered.
fn case() -> Case {
    drawn(SEEDS + 9, Kind::Pocket, &(0.0..1e9)).expect("a pocket")
}

/// The modes of its structure, as a table.
fn modes() -> String {
    let all = case().structure;
    let row = |m: &StructuralMode<f64>| format!("{},{},{},{}\n", m.f_hz, m.f_sd, m.zeta, m.zeta_sd);
    let rows: String = all.modes().iter().map(row).collect();
    format!("f,f_sd,zeta,zeta_sd\n{rows}")
}

/// A machine: a Grbl, the cut at the speed that it turns, and a box that hears it.
struct Machine {
    grbl: Grbl,
    port: String,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Machine {
    /// Cuts for so long at most, s.
    fn cutting(length_s: f64) -> Self {
        let case = case();
        let rpm = 60.0 * case.cut.spindle_hz();
        let grbl = Grbl::running(rpm);
        let mut bridge = Bridge::open("127.0.0.1:0").expect("a socket");
        let port = format!("tcp:{}", bridge.address().expect("an address"));
        let ends = Arc::new(AtomicBool::new(false));
        let thread = thread::spawn({
            let (ends, turns) = (Arc::clone(&ends), grbl.turns());
            move || {
                let mut cut = virtual_cut(&case, ENTERS_S, length_s);
                let sample = || {
                    if ends.load(Ordering::SeqCst) {
                        return None;
                    }
                    cut.turn(turns() / 60.0);
                    cut.next().map(|reading| reading.value)
                };
                Firmware::of(&case, FS_HZ).serve(&mut bridge, sample);
            }
        });
        Self {
            grbl,
            port,
            ends,
            thread: Some(thread),
        }
    }

    /// The box loses its power.
    fn power_off(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the box is fast enough");
        }
    }

    /// Until the override of the spindle is as wanted, at most so long, s.
    fn wait(&self, run: &Running, seconds: f64, wanted: impl Fn(i32) -> bool) {
        let begun = Instant::now();
        loop {
            let now = self.grbl.state().spindle;
            if wanted(now) {
                return;
            }
            let read = |path| std::fs::read_to_string(path).expect("a file");
            assert!(
                begun.elapsed().as_secs_f64() < seconds,
                "{now} %\n{}{}",
                read(&run.said),
                read(&run.log)
            );
            thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
    }
}

/// The command, and where it says what.
struct Running {
    child: Child,
    said: PathBuf,
    log: PathBuf,
    _folder: Folder,
}

impl Running {
    fn start(port: &str, more: &[&str]) -> Self {
        let folder = Folder::default();
        let structure = folder.path().join("modes.csv");
        std::fs::write(&structure, modes()).expect("a file");
        let (said, log) = (folder.path().join("said"), folder.path().join("log"));
        let child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
            .args(["act", &format!("box:{port}"), "--override", "50:150"])
            .args(more)
            .arg("--structure")
            .arg(structure)
            .arg("--log")
            .arg(&log)
            .stdout(std::fs::File::create(&said).expect("a file"))
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        Self {
            child,
            said,
            log,
            _folder: folder,
        }
    }

    /// Until its log has this act, at most so long, s.
    fn wait_for(&self, act: &str, seconds: f64) {
        let begun = Instant::now();
        let line = format!("\"act\":\"{act}\"");
        loop {
            let log = std::fs::read_to_string(&self.log).expect("a file");
            if log.contains(&line) {
                return;
            }
            assert!(begun.elapsed().as_secs_f64() < seconds, "{act}\n{log}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for its end: exit code, standard error, what it said, and the acts of its log.
    fn end(self) -> (Option<i32>, String, String, Vec<String>) {
        let output = self.child.wait_with_output().expect("ended");
        let read = |path| std::fs::read_to_string(path).expect("a file");
        let acts = read(self.log)
            .lines()
            .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"))
            .map(|line| line["act"].as_str().expect("an act").to_owned())
            .collect();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), stderr, read(self.said), acts)
    }

    fn interrupt(&self) {
        let pid = self.child.id().to_string();
        let killed = Command::new("kill").args(["-INT", &pid]).status();
        assert!(killed.is_ok_and(|status| status.success()));
    }
}

fn grbl(machine: &Machine) -> String {
    format!("grbl:{}", machine.grbl.port)
}

#[test]
fn a_box_hears_the_cut_is_turned_and_the_speed_given_back() {
    let machine = Machine::cutting(60.0);
    let controller = grbl(&machine);
    let run = Running::start(&machine.port, &["--act", "--controller", &controller]);
    machine.wait(&run, 15.0, |percent| percent <= 75);
    run.wait_for("quiet", 15.0);
    run.interrupt();
    let (code, stderr, said, acts) = run.end();
    assert_eq!(code, Some(130), "{stderr}");
    assert_eq!(machine.grbl.state().spindle, 100, "{stderr}");
    for act in [
        "begins", "proposed", "ordered", "arrived", "quiet", "ends", "returned",
    ] {
        assert!(acts.iter().any(|a| a == act), "{act}: {acts:?}");
    }
    assert_eq!(
        acts.iter().filter(|act| *act == "ordered").count(),
        1,
        "{acts:?}\n{said}"
    );
    assert!(
        said.contains("CHATTER called") && said.contains("chatter released"),
        "{said}"
    );
}

#[test]
fn a_box_that_is_gone_gives_back() {
    let mut machine = Machine::cutting(60.0);
    let controller = grbl(&machine);
    let run = Running::start(&machine.port, &["--act", "--controller", &controller]);
    machine.wait(&run, 15.0, |percent| percent < 90);
    machine.power_off();
    machine.wait(&run, 10.0, |percent| percent == 100);
    let (code, stderr, _, acts) = run.end();
    assert_eq!(code, Some(4), "{stderr}");
    assert!(
        stderr.contains("box") || stderr.contains("closed"),
        "{stderr}"
    );
    assert!(acts.iter().any(|act| act == "returned"), "{acts:?}");
}

#[test]
fn another_host_that_takes_the_box_gives_back() {
    let machine = Machine::cutting(60.0);
    let controller = grbl(&machine);
    let run = Running::start(&machine.port, &["--act", "--controller", &controller]);
    machine.wait(&run, 15.0, |percent| percent < 90);
    let takes = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args([
            "connect",
            &machine.port,
            "--say",
            "take",
            "--seconds",
            "1",
            "--screen",
            "off",
        ])
        .stdin(Stdio::null())
        .output()
        .expect("started");
    assert!(takes.status.success());
    machine.wait(&run, 10.0, |percent| percent == 100);
    let (code, stderr, _, acts) = run.end();
    assert_eq!(code, Some(4), "{stderr}");
    assert!(
        stderr.contains("another host has taken control"),
        "{stderr}"
    );
    assert!(acts.iter().any(|act| act == "returned"), "{acts:?}");
}

#[test]
fn a_box_is_only_looked_at_where_nothing_is_ordered() {
    let machine = Machine::cutting(60.0);
    let run = Running::start(&machine.port, &["--controller", "dry"]);
    thread::sleep(Duration::from_secs(7));
    run.interrupt();
    let (code, stderr, said, acts) = run.end();
    assert_eq!(code, Some(130), "{stderr}");
    assert!(said.contains("CHATTER called"), "{said}");
    assert!(
        acts.iter().any(|act| act == "would-order"),
        "{acts:?}\n{said}"
    );
    assert!(!said.contains("control: host"), "{said}");
    assert_eq!(machine.grbl.state().spindle, 100);
}

#[test]
fn what_a_box_has_settings_for_is_refused() {
    let machine = Machine::cutting(60.0);
    for (more, named) in [
        (["--controller", "dry", "--band", "300:2000"], "--band"),
        (["--controller", "dry", "--rpm", "9000"], "--rpm"),
        (["--controller", "dry", "--teeth", "3"], "--teeth 3"),
    ] {
        let ended = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
            .args(["act", &format!("box:{}", machine.port)])
            .args(more)
            .output()
            .expect("started");
        let stderr = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(named), "{stderr}");
    }
}
