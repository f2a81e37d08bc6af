//! From boxes to a plant: `rarma gateway`.
//!
//! ```text
//! box ── frames ── [boxes] ── records ── [writing] ── journal ── [uplink] ── broker ── [host] ── store
//!                     └────── live values ──────────────────────────┘└── shdr ── agent
//! box ── command ── [speaking] ── [slots] ── Told ───────────────── [uplink] ── DCMD
//! ```
//! Pure parts, without a wire: [`clock`], [`condense`], [`told`], [`metrics`], [`session`], [`host`]. One
//! thread a box, one that writes the journal, one for the broker, one for agents of MTConnect.
//! [docs/plant.md](../../../docs/plant.md), [decision 79](../../../docs/decisions/0079-gateway.md).

mod boxes;
pub mod clock;
pub mod condense;
pub mod config;
pub mod host;
pub mod journal;
pub mod link;
pub mod metrics;
mod notices;
pub mod session;
mod shdr;
mod slots;
mod speaking;
mod tls;
pub mod told;
mod uplink;
pub mod value;
mod words;
mod writing;

use self::boxes::{BoxThread, Shared};
use self::config::{Broker, Config};
use self::journal::{Journal, Limits};
use self::link::Open;
use self::metrics::{Live, OfBox};
use self::notices::Notices;
pub use self::notices::{Tell, Weight};
use self::uplink::{Uplink, Ward};
use self::value::Value;
use rumqttc::Transport;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use tokio::sync::Notify;

/// Batches between the boxes and the journal: what waits in memory while a disk is full.
const BATCHES: usize = 256;

/// How the gateway stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct GatewayStatus {
    /// Boxes in the file.
    pub boxes: usize,
    /// Boxes that are heard.
    pub heard: usize,
    /// Highest number of the journal.
    pub last: u64,
    /// Highest number that is at its store.
    pub acknowledged: u64,
    /// Records that went unsent for want of room.
    pub dropped: u64,
    /// Frames that did not come from their boxes, by their numbers.
    pub frames_missing: u64,
    /// Frames that came.
    pub frames: u64,
}

/// A gateway that runs.
pub struct Gateway {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    boxes: Vec<JoinHandle<()>>,
    shared: Vec<Arc<Shared>>,
    journal: Arc<Mutex<Journal>>,
    /// Where agents of MTConnect come in.
    pub shdr: Option<SocketAddr>,
}

impl Gateway {
    /// Reads all that the file names, without touching a box, the broker or the journal.
    ///
    /// # Errors
    /// One line.
    pub fn check(config: &Config, open: &dyn Open) -> Result<(), String> {
        config.broker.as_ref().map(reached).transpose()?;
        for path in config.boxes.iter().filter_map(|one| one.key.as_deref()) {
            open.key(path)?;
        }
        Ok(())
    }

    /// Starts what the file asks for. Boxes and a broker that cannot be reached are tried again; what is
    /// wrong with the file, the journal, a key or a certificate ends it here. What there is to tell people while it
    /// runs goes to `tell`, from several threads.
    ///
    /// # Errors
    /// One line.
    pub fn start(config: &Config, open: Arc<dyn Open>, tell: Tell) -> Result<Self, String> {
        let limits = Limits {
            bytes: config.journal_bytes,
            acknowledged_bytes: config.journal_bytes / 16,
        };
        let uplink = config
            .broker
            .as_ref()
            .map(|b| reached(b).map(|r| (b, r)))
            .transpose()?;
        let mut keys = Vec::new();
        for one in &config.boxes {
            keys.push(one.key.as_deref().map(|path| open.key(path)).transpose()?);
        }
        let server = config.shdr.as_deref().map(shdr::Server::open).transpose()?;
        let mut journal = Journal::open(&config.journal, limits).map_err(|why| why.to_string())?;
        let notices = Notices::new(tell);
        journal
            .notices
            .drain(..)
            .for_each(|notice| notices.say(notice));
        let mut before: std::collections::HashMap<String, String> = journal
            .under_way()
            .map_err(|why| why.to_string())?
            .into_iter()
            .collect();
        let journal = Arc::new(Mutex::new(journal));
        let stop = Arc::new(AtomicBool::new(false));
        let wake = Arc::new(Notify::new());
        let (batches, taken) = mpsc::sync_channel(BATCHES);
        let mut gateway = Self {
            stop: Arc::clone(&stop),
            threads: Vec::new(),
            boxes: Vec::new(),
            shared: Vec::new(),
            journal: Arc::clone(&journal),
            shdr: server.as_ref().and_then(|server| server.address().ok()),
        };
        let mut wards = Vec::new();
        for (one, key) in config.boxes.iter().zip(keys) {
            let mut live = Live::default();
            live.set(OfBox::Machine, Some(Value::Text(one.machine.to_string())));
            let shared = Arc::new(Shared {
                live: Mutex::new(live),
                told: Mutex::default(),
            });
            let of_box = BoxThread {
                config: one.clone(),
                key,
                stretch_s: config.stretch_s,
                keep: Duration::from_secs_f64(config.keep_s),
                before: before
                    .remove(one.name.as_str())
                    .and_then(|state| serde_json::from_str(&state).ok())
                    .flatten(),
                shared: Arc::clone(&shared),
                batches: batches.clone(),
                notices: notices.clone(),
                stop: Arc::clone(&stop),
            };
            let open = Arc::clone(&open);
            gateway
                .boxes
                .push(spawn(&format!("box {}", one.name), move || {
                    of_box.run(&*open)
                })?);
            gateway.shared.push(Arc::clone(&shared));
            wards.push(Ward {
                name: one.name.clone(),
                shared,
            });
        }
        drop(batches);
        let boxes: Vec<_> = wards
            .iter()
            .map(|w| (w.name.clone(), Arc::clone(&w.shared)))
            .collect();
        if let Some((broker, (transport, credentials))) = uplink {
            let share = (Arc::clone(&wake), notices.clone(), Arc::clone(&stop));
            let uplink = Uplink::new(
                config,
                broker,
                transport,
                credentials,
                Arc::clone(&journal),
                wards,
                share,
            );
            let notices = notices.clone();
            gateway
                .threads
                .push(spawn("broker", move || run_uplink(uplink, &notices))?);
        }
        if let Some(server) = server {
            let (notices, stop) = (notices.clone(), Arc::clone(&stop));
            gateway
                .threads
                .push(spawn("shdr", move || server.run(&boxes, &notices, &stop))?);
        }
        let keep = Duration::from_secs_f64(config.keep_s);
        gateway.threads.push(spawn("journal", move || {
            writing::run(&taken, &journal, keep, &wake, &notices)
        })?);
        Ok(gateway)
    }

    /// How it stands.
    #[must_use]
    pub fn standing(&self) -> GatewayStatus {
        let count = |metric| {
            let of = |shared: &Arc<Shared>| match shared.live().get(metric) {
                Some(Value::Count(count)) => *count,
                _ => 0,
            };
            self.shared.iter().map(of).sum()
        };
        let heard = self.shared.iter().filter(|s| s.live().here).count();
        let (frames, frames_missing) = (count(OfBox::Frames), count(OfBox::Missing));
        let journal = writing::lock(&self.journal);
        GatewayStatus {
            boxes: self.shared.len(),
            heard,
            last: journal.last(),
            acknowledged: journal.acknowledged(),
            dropped: journal.dropped(),
            frames_missing,
            frames,
        }
    }

    /// Every box was a recording, and all of them have ended.
    #[must_use]
    pub fn is_through(&self) -> bool {
        self.boxes.iter().all(JoinHandle::is_finished)
    }

    /// Ends in order: boxes first, so that what they have said is in the journal; then the rest.
    pub fn stop(self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.boxes.into_iter().chain(self.threads) {
            let _ = thread.join();
        }
    }
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, String> {
    thread::Builder::new()
        .name(name.chars().take(15).collect())
        // Rooms of a box's thread are small; a thousand boxes are a thousand of them.
        .stack_size(512 * 1024)
        .spawn(run)
        .map_err(|why| format!("a thread for {name} cannot be had: {why}"))
}

fn run_uplink(uplink: Uplink, notices: &Notices) {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    match runtime {
        Ok(runtime) => {
            runtime.block_on(uplink.run());
            runtime.shutdown_timeout(Duration::from_secs(1));
        }
        Err(why) => notices.say(format!("no connection to a broker can be made: {why}")),
    }
}

/// User and password of the broker.
fn credentials(broker: &Broker) -> Result<Option<(String, String)>, String> {
    let (Some(user), Some(path)) = (&broker.user, &broker.password_file) else {
        return Ok(None);
    };
    let text = std::fs::read_to_string(path).map_err(|why| {
        format!(
            "{}: open: {} (one line, the password)",
            path.display(),
            why.kind()
        )
    })?;
    Ok(Some((
        user.clone(),
        text.trim_end_matches(['\r', '\n']).to_owned(),
    )))
}

/// How the broker is reached, and as whom.
fn reached(broker: &Broker) -> Result<(Transport, Option<(String, String)>), String> {
    Ok((tls::transport(broker)?, credentials(broker)?))
}
