//! `rarma act`: listens as `monitor` does, and orders another speed of the controller where
//! it chatters, if it may.
//!
//! A real controller goes by the clock, one that is none by the time of the sound. What hears is the monitor itself or a
//! box.

mod by_box;
mod by_clock;
mod by_sound;
mod ear;

use super::monitor::{self, Manner};
use super::process;
use crate::advice::Reach;
use crate::advice::machine::{self, Belief};
use crate::args::{ActArgs, USUAL_LIMITS, Which};
use crate::controller::linuxcnc::USUAL_ADDRESS;
use crate::controller::{
    ActLog, ActRecord, Actor, Charts, Chatter, Controller, Dry, Grbl, LinuxCnc, What,
};
use crate::failure::Failure;
use crate::progress::progress;
use by_box::Listener;
use by_clock::ByClock;
use by_sound::BySound;
use rarma_core::act::ActConfig;
use std::thread;
use std::time::{Duration, Instant};

/// One step of the policy.
const STEP: Duration = Duration::from_millis(20);
/// A controller has this long for its first report.
const FIRST: Duration = Duration::from_secs(3);

pub(super) fn main(args: &ActArgs) -> Result<u8, Failure> {
    if !args.monitor.more.is_empty() {
        return Err(Failure::Usage(
            "several recordings: a controller is given the orders of one".to_owned(),
        ));
    }
    let at_box = by_box::port_of(args);
    if args.key.is_some() && at_box.is_none() {
        return Err(Failure::Usage(
            "--key: seals what is said to a box, and the input is none (box:PORT is one)"
                .to_owned(),
        ));
    }
    let dry = args.controller == Which::Dry;
    if dry && args.act {
        return Err(Failure::Usage(
            "--act: there is nobody to order anything of (name a controller, or leave out --act)"
                .to_owned(),
        ));
    }
    let tells = args.monitor.speed_from.is_some() || args.monitor.tacho.is_some();
    if !dry && (tells || args.monitor.rpm.is_some()) {
        return Err(Failure::Usage(
            "--controller: the controller tells the speed: leave out --rpm, --speed-from and --tacho".to_owned(),
        ));
    }
    if dry && !tells && args.monitor.rpm.is_none() && at_box.is_none() {
        return Err(Failure::Usage(
            "--controller dry: tells no speed: add --rpm, --speed-from or --tacho".to_owned(),
        ));
    }
    let mut listener = at_box
        .map(|port| Listener::open(args, port, !dry))
        .transpose()?;
    let teeth = listener.as_ref().map(Listener::teeth);
    let Some(teeth) = teeth.or(args.monitor.teeth) else {
        return Err(Failure::Usage(
            "--teeth: no speed can be proposed without the number of teeth".to_owned(),
        ));
    };
    let (least, most) = args.limits.unwrap_or(USUAL_LIMITS);
    let config = ActConfig {
        rate_per_s: args.rate / 100.0,
        tries: args.tries,
        keeps_feed: !args.same_feed,
        ..ActConfig::limits(args.act, least / 100.0, most / 100.0)
    };
    let mut machine = machine::told(&args.machine, Some(teeth))?.map(Charts::new);
    if dry && machine.is_some() && args.monitor.rpm.is_none() {
        return Err(Failure::Usage(
            match at_box {
                Some(_) => "--machine: it is worked out before the listening, and nobody tells for which speed (name a controller, or leave out --machine)",
                None => "--machine: it is worked out before the listening, and nobody tells for which speed: add --rpm",
            }
            .to_owned(),
        ));
    }
    if let (true, Some(charts), Some(rpm)) = (dry, &mut machine, args.monitor.rpm) {
        // A recording is heard faster than it was made.
        let bar = progress(Belief::CHARTED as u64, "machines like the one told");
        charts.make(rpm / 60.0, &config, || bar.inc(1));
        bar.finish_and_clear();
    }
    let about = Chatter {
        teeth,
        structure: process::structure(args.monitor.structure.as_deref())?,
        power: args.power,
        machine,
    };
    let (name, controller): (&str, Box<dyn Controller>) = match &args.controller {
        Which::Dry => ("none", Box::new(Dry::default())),
        Which::Grbl(port) => ("Grbl", Box::new(Grbl::open(port, args.baud)?)),
        Which::LinuxCnc(address) => {
            let address = address.as_deref().unwrap_or(USUAL_ADDRESS);
            let open = LinuxCnc::open(address, config.keeps_feed)?;
            ("LinuxCNC", Box::new(open))
        }
    };
    let log = args.log_file().as_deref().map(ActLog::open).transpose()?;
    let mut actor = Actor::new(controller, config, about, log)?;
    let begins = What::Begins {
        controller: name.to_owned(),
        orders: args.act,
        limits: [least, most],
    };
    let first = actor.note(0.0, begins);
    let reach = Reach {
        percent: (least, most),
        power: args.power,
        same_feed: args.same_feed,
        ..Reach::default()
    };
    let manner = |beside| Manner {
        reach,
        beside: Some(beside),
        ..Manner::default()
    };
    if dry {
        let mut beside = BySound::new(actor, first);
        let code = match &mut listener {
            Some(listener) => listener.hear(&mut beside, args.monitor.json)?,
            None => monitor::heard(&args.monitor, manner(&mut beside))?.code,
        };
        beside.end()?;
        return Ok(code);
    }
    first_report(&mut actor, (least, most))?;
    let mut beside = ByClock::start(actor, first, args.act, listener.is_some())?;
    let heard = match &mut listener {
        Some(listener) => listener.hear(&mut beside, args.monitor.json),
        None => monitor::heard(&args.monitor, manner(&mut beside)).map(|heard| heard.code),
    };
    // Whatever came of the listening: what is ordered is given back first.
    let ended = beside.end();
    let code = heard?;
    ended?;
    Ok(code)
}

/// Waits for the controller to speak, and sees that it takes what may be ordered.
fn first_report(actor: &mut Actor, (least, most): (f64, f64)) -> Result<(), Failure> {
    let begun = Instant::now();
    while actor.reading().is_none() {
        if begun.elapsed() > FIRST {
            return Err(Failure::Input(format!(
                "--controller: it has not reported in {} s (see that it is switched on, that it is the right port and speed, and that no other program has the port)",
                FIRST.as_secs()
            )));
        }
        let mut gone = None;
        actor.step(0.0, |record| gone = Some(record))?;
        if let Some(ActRecord {
            what: What::Gone { error },
            ..
        }) = gone
        {
            return Err(Failure::System(error));
        }
        thread::sleep(STEP);
    }
    match actor.range() {
        Some((low, high)) if 100.0 * low > least + 0.01 || 100.0 * high < most - 0.01 => {
            Err(Failure::Usage(format!(
                "--override {least}:{most}: the controller takes {:.0} to {:.0} %",
                100.0 * low,
                100.0 * high
            )))
        }
        _ => Ok(()),
    }
}
