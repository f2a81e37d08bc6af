//! A store that keeps lines in memory, on the host's side of the broker.

use rarma_fleet::gateway::config::Config;
use rarma_fleet::gateway::host::{Numbered, Receiver, Sink, receive};
use rarma_fleet::record::Record;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

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

pub struct Store {
    memory: Memory,
    thread: JoinHandle<Receiver>,
}

impl Store {
    /// `folder` holds the broker's files; `port` is the broker's own, which is not cut.
    pub fn start(folder: &Path, port: u16, stop: &Arc<AtomicBool>) -> Self {
        let text = format!(
            "group = \"plant\"\nnode = \"x\"\njournal = \"x\"\n[broker]\nhost = \"localhost\"\nport = {port}\nca = \"broker/ca.pem\"\nuser = \"store\"\npassword_file = \"broker/store.password\"\n[[box]]\nname = \"x\"\nmachine = \"x\"\nport = \"x\"\n"
        );
        let broker = Config::parse(&text, folder).unwrap().broker.unwrap();
        let memory = Memory::default();
        let (mut sink, stop) = (memory.clone(), Arc::clone(stop));
        let thread = thread::spawn(move || {
            let mut tell = |line: &str| eprintln!("store: {line}");
            receive(&broker, "plant", "store", &mut sink, &stop, &mut tell).unwrap()
        });
        Self { memory, thread }
    }

    pub fn count(&self) -> usize {
        self.memory.1.load(Ordering::Relaxed)
    }

    pub fn end(self) -> (Stored, Receiver) {
        let receiver = self.thread.join().unwrap();
        let stored = std::mem::take(&mut self.memory.0.lock().unwrap().0);
        (stored, receiver)
    }
}
