//! A simulated Grbl at the other end of a socket (as grblHAL has one), as its documentation says:
//! override bytes are flags that the main loop looks at, so that of two alike at once one is
//! lost; the range is 10 to 200 %; a report shows what was true when it was asked for.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// The main loop goes round so often.
const LOOP: Duration = Duration::from_millis(8);

/// What the simulated Grbl does.
#[derive(Debug, Clone)]
pub struct State {
    /// As in reports: `Run`, `Idle`, ….
    pub name: &'static str,
    /// Speed that the program asks for, 1/min.
    pub program_rpm: f64,
    /// Overrides, percent.
    pub spindle: i32,
    /// See `spindle`.
    pub feed: i32,
    /// Highest speed of the spindle, 1/min.
    pub most_rpm: f64,
    /// It takes no override.
    pub refuses: bool,
    /// All bytes that have come.
    pub bytes: Vec<u8>,
    /// The largest and the smallest override of the speed so far.
    pub ends: (i32, i32),
}

/// The simulated Grbl.
pub struct Grbl {
    state: Arc<Mutex<State>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Where it listens, as `--controller grbl:` takes it.
    pub port: String,
}

impl Grbl {
    /// Runs a program with this speed.
    ///
    /// # Panics
    /// There is no socket to be had.
    #[must_use]
    pub fn running(program_rpm: f64) -> Self {
        let listens = TcpListener::bind("127.0.0.1:0").expect("a socket");
        let port = format!("tcp:{}", listens.local_addr().expect("an address"));
        let state = Arc::new(Mutex::new(State {
            name: "Run",
            program_rpm,
            spindle: 100,
            feed: 100,
            most_rpm: 1e9,
            refuses: false,
            bytes: Vec::new(),
            ends: (100, 100),
        }));
        let ends = Arc::new(AtomicBool::new(false));
        let thread = thread::spawn({
            let (state, ends) = (Arc::clone(&state), Arc::clone(&ends));
            move || {
                let (peer, _) = listens.accept().expect("somebody");
                serve(peer, &state, &ends);
            }
        });
        Self {
            state,
            ends,
            thread: Some(thread),
            port,
        }
    }

    /// What it does, to look at and to change.
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The speed that it commands, 1/min, for whoever plays the spindle.
    pub fn turns(&self) -> impl Fn() -> f64 + Send + use<> {
        let state = Arc::clone(&self.state);
        move || {
            let state = state.lock().unwrap_or_else(PoisonError::into_inner);
            state.rpm()
        }
    }

    /// The cable is pulled.
    pub fn pull(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        // Where nobody has connected it still waits for somebody.
        let _ = TcpStream::connect(self.port.trim_start_matches("tcp:"));
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Grbl {
    fn drop(&mut self) {
        self.pull();
    }
}

fn serve(mut port: TcpStream, state: &Mutex<State>, ends: &AtomicBool) {
    port.set_read_timeout(Some(LOOP)).expect("a timeout");
    let mut buffer = [0; 256];
    while !ends.load(Ordering::SeqCst) {
        let n = port.read(&mut buffer).unwrap_or(0);
        let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
        let came = &buffer[..n];
        now.bytes.extend_from_slice(came);
        // A report first, then what the flags say, each once.
        let report = came.contains(&b'?').then(|| now.report());
        for (byte, spindle, feed) in [
            (0x9C, 1, 0),
            (0x9D, -1, 0),
            (0x9A, 10, 0),
            (0x9B, -10, 0),
            (0x93, 0, 1),
            (0x94, 0, -1),
        ] {
            if came.contains(&byte) && !now.refuses {
                now.spindle = (now.spindle + spindle).clamp(10, 200);
                now.feed = (now.feed + feed).clamp(10, 200);
            }
        }
        now.ends = (now.ends.0.min(now.spindle), now.ends.1.max(now.spindle));
        drop(now);
        if let Some(report) = report {
            let _ = port.write_all(report.as_bytes());
        }
        thread::sleep(LOOP);
    }
}

impl State {
    fn rpm(&self) -> f64 {
        (self.program_rpm * f64::from(self.spindle) / 100.0).min(self.most_rpm)
    }

    fn report(&self) -> String {
        let rpm = self.rpm();
        format!(
            "<{}|MPos:0.000,0.000,0.000|FS:500,{rpm:.0}|Ov:{},100,{}>\r\nok\r\n",
            self.name, self.feed, self.spindle
        )
    }
}
