//! A store that keeps lines in memory, on the host's side of the broker; and one that is a process of its own with a
//! file of SQLite, to be killed.

use rarma_fleet::gateway::config::HostConfig;
use rarma_fleet::gateway::host::{Numbered, Receiver, Sink, receive};
use rarma_fleet::record::Record;
use rarma_fleet::store::{Receiving, Taken};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// What came, in the order in which it came.
pub type Stored = Vec<(u64, Record)>;

#[derive(Clone, Default)]
struct Memory(Arc<Mutex<(Stored, u64)>>, Arc<AtomicUsize>);

impl Sink for Memory {
    fn position(&mut self, _: &str) -> Result<u64, String> {
        Ok(self.0.lock().unwrap().1)
    }

    fn store(&mut self, _: &str, number: u64, records: &[Numbered]) -> Result<(), String> {
        let mut kept = self.0.lock().unwrap();
        kept.0
            .extend(records.iter().map(|(n, _, record)| (*n, record.clone())));
        kept.1 = number;
        self.1.store(kept.0.len(), Ordering::Relaxed);
        Ok(())
    }
}

/// The file of a host that logs in as `user`; `folder` holds the broker's files.
fn file(user: &str, port: u16) -> String {
    format!(
        "group = \"plant\"\nhost = \"store\"\n[broker]\nhost = \"localhost\"\nport = {port}\nca = \"broker/ca.pem\"\nuser = \"{user}\"\npassword_file = \"broker/{user}.password\"\n"
    )
}

pub struct Store {
    memory: Memory,
    said: Arc<Mutex<Vec<String>>>,
    thread: JoinHandle<Receiver>,
}

impl Store {
    /// `folder` holds the broker's files; `port` is the broker's own, which is not cut.
    pub fn start(folder: &Path, port: u16, stop: &Arc<AtomicBool>) -> Self {
        Self::start_as("store", folder, port, stop)
    }

    /// The same, as another user.
    pub fn start_as(user: &str, folder: &Path, port: u16, stop: &Arc<AtomicBool>) -> Self {
        let broker = HostConfig::parse(&file(user, port), folder).unwrap().broker;
        let memory = Memory::default();
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let (mut sink, stop, kept) = (memory.clone(), Arc::clone(stop), Arc::clone(&said));
        let thread = thread::spawn(move || {
            let mut tell = |line: &str| {
                eprintln!("store: {line}");
                kept.lock().unwrap().push(line.to_owned());
            };
            receive(&broker, "plant", "store", &mut sink, &stop, &mut tell).unwrap()
        });
        Self {
            memory,
            said,
            thread,
        }
    }

    pub fn count(&self) -> usize {
        self.memory.1.load(Ordering::Relaxed)
    }

    /// What it has told people.
    pub fn said(&self) -> String {
        self.said.lock().unwrap().join("\n")
    }

    pub fn end(self) -> (Stored, Receiver) {
        let receiver = self.thread.join().unwrap();
        let stored = std::mem::take(&mut self.memory.0.lock().unwrap().0);
        (stored, receiver)
    }
}

const FILE: &str = "RARMA_TEST_STORE_FILE";

/// A store on a file of SQLite in a process of its own.
pub struct Killed {
    child: std::process::Child,
    file: PathBuf,
}

impl Killed {
    pub fn start(folder: &Path, port: u16) -> Self {
        let path = folder.join("store.toml");
        fs::write(&path, file("store", port)).unwrap();
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "store_child", "--nocapture"])
            .args(["--test-threads", "1"])
            .env(FILE, &path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        Self { child, file: path }
    }

    /// SIGKILL.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// In order; what it says then.
    pub fn end(&mut self) -> String {
        drop(self.child.stdin.take());
        let until = Instant::now() + Duration::from_secs(20);
        while self.child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < until, "the store does not end");
            thread::sleep(Duration::from_millis(20));
        }
        fs::read_to_string(self.file.with_extension("said")).unwrap()
    }

    /// All that is in it.
    pub fn lines(&self) -> Vec<String> {
        let mut store = opened(&self.file);
        store.lines(None, None, None, 1 << 20).unwrap()
    }
}

impl Drop for Killed {
    fn drop(&mut self) {
        self.kill();
    }
}

fn opened(file: &Path) -> rarma_fleet::store::Store {
    let place = file.with_file_name("plant.db");
    rarma_fleet::store::Store::open(place.to_str().unwrap()).unwrap()
}

/// What the child does; false: this process is none.
pub fn child() -> bool {
    let Some(file) = std::env::var_os(FILE).map(PathBuf::from) else {
        return false;
    };
    let config = HostConfig::read(&file).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let ended = Arc::clone(&stop);
    // Standard input ends when the store is to.
    thread::spawn(move || {
        let _ = std::io::Read::read_to_end(&mut std::io::stdin(), &mut Vec::new());
        ended.store(true, Ordering::Relaxed);
    });
    let mut store = opened(&file);
    let mut at_each = |_: &Taken| {};
    let mut sink = Receiving::new(&mut store, &mut at_each);
    let mut tell = |line: &str| eprintln!("store: {line}");
    let receiver = receive(
        &config.broker,
        "plant",
        "store",
        &mut sink,
        &stop,
        &mut tell,
    )
    .unwrap();
    let Taken { new, same, .. } = sink.taken;
    let said = format!(
        "{new} new, {same} there already by name, {} by number, refused {:?}",
        receiver.repeated, receiver.refused
    );
    fs::write(file.with_extension("said"), said).unwrap();
    true
}
