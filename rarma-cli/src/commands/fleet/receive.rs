//! `rarma store receive`: the plant's broker on one side, a store on the other.

use super::{Opened, tell};
use crate::args::StoreReceiveArgs;
use crate::failure::Failure;
use crate::output::{self, stdout};
use crate::signals;
use rarma_fleet::gateway::config::HostConfig;
use rarma_fleet::gateway::host;
use rarma_fleet::store::{Receiving, Taken};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub(super) fn main(args: &StoreReceiveArgs) -> Result<u8, Failure> {
    let config = HostConfig::read(&args.file).map_err(Failure::Input)?;
    let mut opened = Opened::new(&args.store)?;
    let stop = Arc::new(AtomicBool::new(false));
    let ended = Arc::clone(&stop);
    signals::on_interrupt(move || ended.store(true, Ordering::Relaxed))?;
    eprintln!(
        "group {}, host {}: records go to {}",
        config.group, config.host, opened.place
    );
    let every = Duration::from_secs_f64(args.every);
    let mut told: Option<Instant> = None;
    let mut at_each = |taken: &Taken| {
        if told.is_none_or(|at| at.elapsed() >= every) {
            told = Some(Instant::now());
            tell(taken, 0, args.json);
            // Nobody reads any more.
            if stdout::check().is_err() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    };
    let mut sink = Receiving::new(&mut opened.store, &mut at_each);
    let receiver = host::receive(
        &config.broker,
        config.group.as_str(),
        config.host.as_str(),
        &mut sink,
        &stop,
        &mut |why| output::trouble(format_args!("{why}")),
    );
    let receiver = receiver.map_err(Failure::Input)?;
    let refused: u64 = receiver.refused.values().sum();
    tell(&sink.taken, refused, args.json);
    for (why, times) in &receiver.refused {
        output::trouble(format_args!("refused {times} times: {why}"));
    }
    stdout::check().map(|()| 0)
}
