//! `rarma gateway`: many boxes on one side, the plant's broker on the other.

use crate::args::GatewayArgs;
use crate::failure::Failure;
use crate::output::{self, stdout};
use crate::port::Port;
use crate::{key, signals};
use rarma_box::wire::{Head, LinkKey, Telemetry};
use rarma_fleet::gateway::config::Config;
use rarma_fleet::gateway::link::{Counts, Link, Open};
use rarma_fleet::gateway::{Gateway, GatewayStatus, Weight};
use rarma_recordings::FrameReader;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// How often it is looked whether the program is to end.
const LOOK: Duration = Duration::from_millis(100);

pub(super) fn main(args: &GatewayArgs) -> Result<u8, Failure> {
    let config = Config::read(&args.file).map_err(Failure::Input)?;
    Gateway::check(&config, &Ports).map_err(Failure::Input)?;
    if args.check {
        say!(
            "{}: {} boxes, group {}, gateway {}: in order",
            args.file.display(),
            config.boxes.len(),
            config.group,
            config.node
        );
        return Ok(0);
    }
    let stop = Arc::new(AtomicBool::new(false));
    let ended = Arc::clone(&stop);
    signals::on_interrupt(move || ended.store(true, Ordering::Relaxed))?;
    let said = |weight, line: &str| match weight {
        Weight::Notice => eprintln!("{line}"),
        Weight::Error => output::trouble(format_args!("{line}")),
    };
    let gateway =
        Gateway::start(&config, Arc::new(Ports), Arc::new(said)).map_err(Failure::System)?;
    if let Some(address) = gateway.shdr {
        eprintln!("SHDR at {address}");
    }
    let every = Duration::from_secs_f64(args.every);
    let mut told = Instant::now();
    let mut result = Ok(());
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(LOOK);
        let standing = gateway.standing();
        // Recordings end, and with them the gateway, once what they held is at the store.
        let through = gateway.is_through()
            && (config.broker.is_none() || standing.acknowledged == standing.last);
        if told.elapsed() >= every || through {
            told = Instant::now();
            tell(args.json, &standing);
            result = stdout::check();
            if result.is_err() {
                break;
            }
        }
        if through {
            break;
        }
    }
    gateway.stop();
    result.map(|()| 0)
}

fn tell(json: bool, s: &GatewayStatus) {
    if json {
        // Numbers only: there is nothing that could not be written.
        say!("{}", serde_json::to_string(s).unwrap_or_default());
        return;
    }
    say!(
        "{} of {} boxes heard, {} frames ({} missing), {} records, {} of them at the store, {} dropped",
        s.heard,
        s.boxes,
        s.frames,
        s.frames_missing,
        s.last,
        s.acknowledged,
        s.dropped
    );
}

/// Ports, sockets and files, as everywhere in this program.
struct Ports;

impl Open for Ports {
    fn open(&self, port: &str, baud: u32) -> Result<Box<dyn Link>, String> {
        let port = Port::open(port, baud).map_err(|why| why.to_string())?;
        Ok(Box::new(Wire {
            port,
            reader: FrameReader::default(),
        }))
    }

    fn key(&self, path: &Path) -> Result<LinkKey, String> {
        key::read(path).map_err(|why| why.to_string())
    }
}

struct Wire {
    port: Port,
    reader: FrameReader,
}

impl Link for Wire {
    fn listen(&mut self, with: &mut dyn FnMut(Head, Telemetry)) -> Result<bool, String> {
        let mut bytes = [0; 16 * 1024];
        match self.port.read(&mut bytes).map_err(|why| why.to_string())? {
            None => Ok(true),
            Some(0) if self.port.answers() => Err(self.port.closed().to_string()),
            Some(0) => Ok(false),
            Some(n) => {
                let came = bytes.get(..n).unwrap_or_default();
                self.reader.take(came, with);
                Ok(true)
            }
        }
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), String> {
        self.port.send(frame).map_err(|why| why.to_string())
    }

    fn answers(&self) -> bool {
        self.port.answers()
    }

    fn counts(&self) -> Counts {
        Counts {
            whole: self.reader.whole,
            broken: self.reader.broken,
            missing: self.reader.missing,
            foreign: self.reader.foreign,
        }
    }
}
