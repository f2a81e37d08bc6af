//! What tools/linuxcnc/rarma_override.py says and takes, at a free port and without LinuxCNC: a program runs, and
//! a factor is in force as soon as it is told; where the link ends it is 1 again.

use serde_json::{Value, json};
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// It speaks so often.
const STEP: Duration = Duration::from_millis(20);

/// What it has come to.
#[derive(Debug, Default)]
pub struct State {
    /// Our factor of the speed; none: as programmed.
    pub factor: Option<f64>,
    /// All that it was told, line by line.
    pub told: Vec<Value>,
    /// So many have connected.
    pub peers: usize,
}

impl State {
    /// Factors of the speed that were ordered.
    #[must_use]
    pub fn orders(&self) -> Vec<f64> {
        let spindle = |line: &Value| line["factor"]["spindle"].as_f64();
        self.told.iter().filter_map(spindle).collect()
    }
}

/// One that listens.
pub struct Component {
    state: Arc<Mutex<State>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Where, as `--controller linuxcnc:` takes it.
    pub address: String,
}

impl Component {
    /// A program with this speed runs, and the factor may lie in this range.
    ///
    /// # Panics
    /// There is no socket to be had.
    #[must_use]
    pub fn running(program_rpm: f64, range: [f64; 2]) -> Self {
        let listens = TcpListener::bind("127.0.0.1:0").expect("a socket");
        listens.set_nonblocking(true).expect("a socket");
        let address = listens.local_addr().expect("an address").to_string();
        let state = Arc::new(Mutex::new(State::default()));
        let ends = Arc::new(AtomicBool::new(false));
        let thread = thread::spawn({
            let (state, ends) = (Arc::clone(&state), Arc::clone(&ends));
            move || {
                while !ends.load(Ordering::SeqCst) {
                    match listens.accept() {
                        Ok((peer, _)) => {
                            locked(&state).peers += 1;
                            serve(peer, (program_rpm, range), &state, &ends);
                            locked(&state).factor = None;
                        }
                        Err(_) => thread::sleep(STEP),
                    }
                }
            }
        });
        Self {
            state,
            ends,
            thread: Some(thread),
            address,
        }
    }

    /// What it has come to.
    pub fn state(&self) -> MutexGuard<'_, State> {
        locked(&self.state)
    }
}

impl Drop for Component {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn locked(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

fn serve(
    mut peer: TcpStream,
    (program_rpm, range): (f64, [f64; 2]),
    state: &Mutex<State>,
    ends: &AtomicBool,
) {
    peer.set_nonblocking(true).expect("a socket");
    let (mut buffer, mut bytes) = ([0; 4096], Vec::new());
    while !ends.load(Ordering::SeqCst) {
        match peer.read(&mut buffer) {
            Ok(0) => return,
            Ok(n) => bytes.extend_from_slice(&buffer[..n]),
            Err(why) if why.kind() == ErrorKind::WouldBlock => {}
            Err(_) => return,
        }
        let factor = {
            let mut now = locked(state);
            while let Some(end) = bytes.iter().position(|b| *b == b'\n') {
                let line: Vec<u8> = bytes.drain(..=end).collect();
                let line: Value = serde_json::from_slice(&line).expect("JSON");
                if line.get("leave").is_some() {
                    now.factor = None;
                }
                now.factor = line["factor"]["spindle"].as_f64().or(now.factor);
                now.told.push(line);
            }
            now.factor.unwrap_or(1.0)
        };
        let status = json!({
            "commanded_rpm": program_rpm,
            "actual_rpm": program_rpm * factor,
            "operator": 1.0,
            "operator_feed": 1.0,
            "factor": factor,
            "feed_factor": factor.min(1.0),
            "running": true,
            "stopped": false,
            "range": range,
        });
        if writeln!(peer, "{status}").is_err() {
            return;
        }
        thread::sleep(STEP);
    }
}
