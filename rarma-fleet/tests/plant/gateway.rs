//! The gateway as a process of its own: this test program, started again.

use super::boxes::SimulatedBox;
use super::link::Sockets;
use rarma_fleet::gateway::Gateway;
use rarma_fleet::gateway::config::Config;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

const FILE: &str = "RARMA_TEST_GATEWAY_FILE";

/// What the child tells of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    pub last: u64,
    pub acknowledged: u64,
    pub dropped: u64,
    pub frames: u64,
}

/// Where the gateway's files are.
pub struct Places {
    pub config: PathBuf,
    journal: PathBuf,
    standing: PathBuf,
    said: PathBuf,
    /// A small disk of its own, where this machine lets us make one.
    disk: Option<PathBuf>,
}

impl Places {
    pub fn make(
        folder: &Path,
        boxes: &[SimulatedBox],
        port: u16,
        stretch_s: f64,
        own_disk: bool,
    ) -> Self {
        let home = folder.join("gateway");
        fs::create_dir_all(home.join("journal")).unwrap();
        let disk = home.join("journal");
        let mounted = own_disk && mount(&disk);
        if own_disk && !mounted {
            eprintln!(
                "SKIPPED in part: no small disk can be made here (it takes root), so that none gets full"
            );
        }
        let mut text = format!(
            "group = \"plant\"\nnode = \"gw\"\njournal = \"journal/records.db\"\nstretch_s = {stretch_s}\njournal_bytes = 134217728\nlive_s = 1\n\
             [broker]\nhost = \"localhost\"\nport = {port}\nca = \"../broker/ca.pem\"\nuser = \"gateway\"\npassword_file = \"../broker/gateway.password\"\nprimary_host = \"store\"\n"
        );
        for (k, one) in boxes.iter().enumerate() {
            text.push_str(&format!(
                "[[box]]\nname = \"box-{k}\"\nmachine = \"M{k}\"\nport = \"tcp:127.0.0.1:{}\"\nstarted = \"2026-01-05T00:00:00Z\"\n",
                one.port
            ));
        }
        let config = home.join("gateway.toml");
        fs::write(&config, text).unwrap();
        Self {
            config,
            journal: disk.clone(),
            standing: home.join("standing"),
            said: home.join("said"),
            disk: mounted.then_some(disk),
        }
    }

    /// Fills the disk for as long as `meanwhile` takes. It says where the journal was then.
    pub fn disk_full(&self, meanwhile: impl FnOnce() -> (u64, u64)) {
        if self.disk.is_none() {
            return;
        }
        let ballast = self.journal.join("ballast");
        let mut file = fs::File::create(&ballast).unwrap();
        let mut size = 1 << 20;
        while size >= 4096 {
            use std::io::Write as _;
            if file.write_all(&vec![1; size]).is_err() {
                size /= 2;
            }
        }
        let (before, after) = meanwhile();
        println!("disk full: the journal stood at {before}, then at {after}");
        drop(file);
        fs::remove_file(&ballast).unwrap();
    }

    /// Most memory of any of the gateway's processes, MB; 0 where the system does not tell.
    pub fn most_memory_mb(&self) -> f64 {
        let text = fs::read_to_string(self.standing.with_extension("memory")).unwrap_or_default();
        text.lines()
            .filter_map(|l| l.parse::<f64>().ok())
            .fold(0.0, f64::max)
            / 1024.0
    }
}

impl Drop for Places {
    fn drop(&mut self) {
        if let Some(disk) = &self.disk {
            let _ = Command::new("umount").arg("-l").arg(disk).status();
        }
    }
}

fn mount(place: &Path) -> bool {
    let mut mount = Command::new("mount");
    mount
        .args(["-t", "tmpfs", "-o", "size=256m", "tmpfs"])
        .arg(place);
    mount
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|s| s.success())
}

pub struct Child {
    child: std::process::Child,
    standing: PathBuf,
    said: PathBuf,
}

impl Child {
    pub fn start(places: &Places) -> Self {
        let said = fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&places.said)
            .unwrap();
        let child = Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "gateway_child",
                "--nocapture",
                "--test-threads",
                "1",
            ])
            .env(FILE, &places.config)
            .env("RARMA_TEST_STANDING", &places.standing)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(said)
            .spawn()
            .unwrap();
        Self {
            child,
            standing: places.standing.clone(),
            said: places.said.clone(),
        }
    }

    pub fn standing(&self) -> Standing {
        let until = Instant::now() + Duration::from_secs(5);
        loop {
            let text = fs::read_to_string(&self.standing).unwrap_or_default();
            let n: Vec<u64> = text
                .split_whitespace()
                .filter_map(|n| n.parse().ok())
                .collect();
            if let [last, acknowledged, dropped, frames] = n[..] {
                return Standing {
                    last,
                    acknowledged,
                    dropped,
                    frames,
                };
            }
            assert!(
                Instant::now() < until,
                "the gateway does not say how it stands: {}",
                self.said()
            );
            thread::sleep(Duration::from_millis(20));
        }
    }

    pub fn runs(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    pub fn said(&self) -> String {
        let text = fs::read_to_string(&self.said).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(30)..].join("\n")
    }

    /// SIGKILL.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    pub fn again(self, places: &Places) -> Self {
        drop(self);
        Self::start(places)
    }

    /// In order: it is told to.
    pub fn end(mut self) {
        drop(self.child.stdin.take());
        let until = Instant::now() + Duration::from_secs(20);
        while self.runs() {
            assert!(
                Instant::now() < until,
                "the gateway does not end: {}",
                self.said()
            );
            thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Whether this process is the gateway that another one started.
pub fn is_child() -> bool {
    std::env::var_os(FILE).is_some()
}

/// What the child does.
pub fn child() {
    let Some(file) = std::env::var_os(FILE) else {
        eprintln!("SKIPPED: the gateway of the other tests, which start it themselves");
        return;
    };
    let standing = PathBuf::from(std::env::var_os("RARMA_TEST_STANDING").unwrap());
    let config = Config::read(Path::new(&file)).unwrap();
    let gateway = Gateway::start(
        &config,
        Arc::new(Sockets),
        Arc::new(|_, line| eprintln!("{line}")),
    )
    .unwrap();
    // Standard input ends when the gateway is to.
    let ended = thread::spawn(|| {
        let mut rest = Vec::new();
        let _ = std::io::Read::read_to_end(&mut std::io::stdin(), &mut rest);
    });
    let memory = standing.with_extension("memory");
    let mut beats = 0;
    while !ended.is_finished() {
        let s = gateway.standing();
        let part = standing.with_extension("part");
        fs::write(
            &part,
            format!("{} {} {} {}", s.last, s.acknowledged, s.dropped, s.frames),
        )
        .unwrap();
        fs::rename(&part, &standing).unwrap();
        if beats % 10 == 0
            && let Some(kb) = resident_kb()
        {
            let mut lines = fs::read_to_string(&memory).unwrap_or_default();
            lines.push_str(&format!("{kb}\n"));
            fs::write(&memory, lines).unwrap();
        }
        beats += 1;
        thread::sleep(Duration::from_millis(100));
    }
    gateway.stop();
}

/// The largest memory this process has had.
fn resident_kb() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}
