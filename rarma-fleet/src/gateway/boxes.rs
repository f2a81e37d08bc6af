//! One box: its wire is opened and opened again, its frames become records and live values.

use super::clock::{BoxClock, ClockFault};
use super::condense::{Condenser, UnderWay, Whose};
use super::config::BoxConfig;
use super::journal::Entry;
use super::link::{Link, Open};
use super::metrics::{Live, OfBox};
use super::notices::Notices;
use super::slots::Slots;
use super::speaking::{News, Speaking};
use super::told::Told;
use super::value::Value;
use super::words;
use crate::record::{Body, Name, Record, Utc, settings_hash, to_line};
use rarma_box::guard::FaultRecord;
use rarma_box::wire::{Answer, Head, Identity, LinkKey, Telemetry};
use rarma_core::named::Named;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A box that cannot be reached, or whose link holds for less, is tried again after so long; doubled up
/// to the most.
const AGAIN: Duration = Duration::from_secs(1);
const AGAIN_MOST: Duration = Duration::from_secs(15);
/// A box that says nothing for so long is not there, whatever its link says.
const SILENT: Duration = Duration::from_secs(10);
/// Settings are read again after so long.
const SETTINGS: Duration = Duration::from_secs(3600);

/// Records of a box on their way to the journal, with what is under way there after them.
pub(super) struct Batch {
    pub entries: Vec<Entry>,
    pub under_way: Option<(String, String)>,
}

/// What the threads of a box share with the rest.
pub(super) struct Shared {
    pub live: Mutex<Live>,
    pub told: Mutex<Slots>,
}

impl Shared {
    pub fn live(&self) -> std::sync::MutexGuard<'_, Live> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn told(&self) -> std::sync::MutexGuard<'_, Slots> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Why a recording is told nothing.
pub(super) const RECORDING: &str = "not told: it is a recording";

pub(super) struct BoxThread {
    pub config: BoxConfig,
    pub key: Option<LinkKey>,
    pub stretch_s: f64,
    pub keep: Duration,
    pub before: Option<UnderWay>,
    pub shared: Arc<Shared>,
    pub batches: SyncSender<Batch>,
    pub notices: Notices,
    pub stop: Arc<AtomicBool>,
}

impl BoxThread {
    /// Until it is told to stop, or a recording has ended.
    pub fn run(mut self, open: &dyn Open) {
        let whose = Whose::new(self.config.name.clone(), self.config.machine.clone());
        let clock = self
            .config
            .started
            .map_or_else(BoxClock::live, BoxClock::since);
        let mut condenser = Condenser::new(whose, clock, self.stretch_s, self.before.take());
        let mut again = AGAIN;
        let mut reachable = true;
        while !self.stopped() {
            match open.open(&self.config.port, self.config.baud) {
                Ok(mut link) => {
                    let opened = Instant::now();
                    let heard = self.listen(&mut *link, &mut condenser);
                    self.shared.live().here = false;
                    match heard {
                        Ok(()) => break,
                        Err(why) => self.notices.of_box(&self.config.name, &why),
                    }
                    reachable = true;
                    if opened.elapsed() >= AGAIN {
                        again = AGAIN;
                        continue;
                    }
                }
                Err(why) => {
                    if std::mem::take(&mut reachable) {
                        self.notices
                            .of_box(&self.config.name, &format!("{why}; it is tried again"));
                    }
                }
            }
            self.pause(again);
            again = (2 * again).min(AGAIN_MOST);
        }
        if self.config.started.is_some() && !self.stopped() {
            // A recording has ended, and with it what was under way.
            let mut entries = Vec::new();
            condenser.end(&mut |record| entries.extend(self.entry(&record)));
            self.hand_on(entries, &condenser);
        }
    }

    /// Until the link ends. What was to be told then waits for the next one.
    fn listen(&self, link: &mut dyn Link, condenser: &mut Condenser) -> Result<(), String> {
        if !link.answers() && !self.shared.told().close().is_empty() {
            self.refused(RECORDING);
        }
        let mut speaking = Speaking::new(rand::random(), self.key);
        let heard = self.hear(link, condenser, &mut speaking);
        let mut told = self.shared.told();
        for (one, at) in speaking.rest() {
            told.put(one, at);
        }
        heard
    }

    fn hear(
        &self,
        link: &mut dyn Link,
        condenser: &mut Condenser,
        speaking: &mut Speaking,
    ) -> Result<(), String> {
        let answers = link.answers();
        let mut kept = Instant::now();
        let mut asked = Instant::now();
        let mut news = Vec::new();
        let mut foreign = false;
        let mut heard = Instant::now();
        let mut counts = link.counts();
        if answers {
            // Ends whatever half frame the line still holds.
            link.send(&[0])?;
        }
        while !self.stopped() {
            if answers {
                self.take_told(condenser, speaking);
                if asked.elapsed() > SETTINGS {
                    speaking.ask_settings();
                    asked = Instant::now();
                }
                speaking.go_on(link, &mut news)?;
            }
            let mut entries = Vec::new();
            let arrival = Utc::now().map_err(|why| why.to_string())?;
            let goes_on = link.listen(&mut |head, message| {
                speaking.hears(&head, &message, &mut news);
                self.identity(&message, condenser);
                let fault = condenser.take(head, &message, arrival, &mut |record| {
                    entries.extend(self.entry(&record));
                });
                if let Some(fault) = fault {
                    self.notices.of_box(&self.config.name, &clock_words(fault));
                }
                self.show(head, &message, condenser);
            })?;
            let before = std::mem::replace(&mut counts, link.counts());
            if counts.whole > before.whole {
                heard = Instant::now();
            }
            if let Some(version) = counts
                .foreign
                .filter(|_| !std::mem::replace(&mut foreign, counts.foreign.is_some()))
            {
                self.notices.of_box(
                    &self.config.name,
                    &format!("frames of protocol version {version}: use the version of rarma that came with the firmware"),
                );
            }
            {
                let mut live = self.shared.live();
                live.set(OfBox::Frames, Some(Value::Count(counts.whole)));
                live.set(OfBox::Missing, Some(Value::Count(counts.missing)));
                live.set(OfBox::Broken, Some(Value::Count(counts.broken)));
                live.here = counts.whole > 0 && heard.elapsed() < SILENT;
            }
            for news in news.drain(..) {
                self.tell_news(news, condenser);
            }
            if !entries.is_empty() || kept.elapsed() > self.keep {
                kept = Instant::now();
                self.hand_on(entries, condenser);
            }
            if !goes_on {
                return Ok(());
            }
        }
        Ok(())
    }

    /// What controllers have told since: the tool for records, the rest for the box.
    fn take_told(&self, condenser: &mut Condenser, speaking: &mut Speaking) {
        let told = self.shared.told().drain();
        for (one, at) in told {
            if let Told::Tool(tool) = one {
                let shown = tool.as_ref().map(|name| Value::Text(name.to_string()));
                self.shared.live().set(OfBox::Tool, shown);
                condenser.whose.tool = tool;
            } else {
                speaking.tell(one, at);
            }
        }
    }

    fn identity(&self, message: &Telemetry, condenser: &mut Condenser) {
        let identity: &Identity = match message {
            Telemetry::Hello(identity) => identity,
            Telemetry::Reply(reply) => match &reply.answer {
                Answer::Identity(identity) => identity,
                _ => return,
            },
            _ => return,
        };
        condenser.rate(f64::from(identity.sample_rate_hz));
        condenser.whose.firmware = Name::new(identity.version.trim()).ok();
        let mut live = self.shared.live();
        live.set(OfBox::Board, Some(Value::Text(identity.board.to_string())));
        live.set(
            OfBox::Firmware,
            Some(Value::Text(identity.version.to_string())),
        );
    }

    fn show(&self, _: Head, message: &Telemetry, condenser: &Condenser) {
        let mut live = self.shared.live();
        let number = |x: f32| Some(Value::Number(words::decimal(x)));
        match message {
            Telemetry::Verdict(v) => {
                let state = v.state.name();
                live.set(OfBox::State, Some(Value::Text(state.to_owned())));
                live.set(OfBox::Reason, Some(Value::Text(v.reason.name().to_owned())));
                live.set(OfBox::Level, number(v.level));
                let least = v
                    .modes
                    .iter()
                    .min_by(|a, b| a.damping.total_cmp(&b.damping));
                live.set(
                    OfBox::ModeFrequency,
                    least.and_then(|m| number(m.frequency)),
                );
                live.set(
                    OfBox::ModeFrequencySd,
                    least.and_then(|m| number(m.frequency_sd)),
                );
                live.set(OfBox::ModeDamping, least.and_then(|m| number(m.damping)));
                live.set(
                    OfBox::ModeDampingSd,
                    least.and_then(|m| number(m.damping_sd)),
                );
                live.set(
                    OfBox::Speed,
                    v.spindle
                        .hz
                        .map(|hz| Value::Number(words::decimal(hz * 60.0))),
                );
                live.set(OfBox::Drift, condenser.clock.drift_ppm().map(Value::Number));
            }
            Telemetry::Alarm(a) => {
                live.set(OfBox::AlarmOn, Some(Value::Flag(a.on)));
                live.set(OfBox::AlarmFrequency, number(a.frequency));
                live.set(OfBox::AlarmDamping, number(a.damping));
            }
            Telemetry::Status(s) => {
                live.set(OfBox::Mode, Some(Value::Text(s.mode.name().to_owned())));
                let fault = |f: &FaultRecord| Value::Text(f.code.name().to_owned());
                live.set(OfBox::Fault, s.fault.as_ref().map(fault));
            }
            _ => {}
        }
    }

    fn tell_news(&self, news: News, condenser: &mut Condenser) {
        match news {
            News::Settings(text) => {
                let hash = settings_hash(text.as_bytes());
                self.shared
                    .live()
                    .set(OfBox::Settings, Some(Value::Text(hash.to_string())));
                condenser.whose.settings = Some(hash);
            }
            News::Taken(Told::Teeth(teeth)) => {
                condenser.whose.teeth = Some(teeth).filter(|&z| z > 0);
                self.shared
                    .live()
                    .set(OfBox::Teeth, Some(Value::Count(u64::from(teeth))));
            }
            // The box's own verdicts tell the speed that is in force; a tool is not told to it.
            News::Taken(Told::Speed(_) | Told::Tool(_)) => {}
            News::Refused(why) => self.refused(&why),
        }
    }

    fn refused(&self, why: &str) {
        self.shared
            .live()
            .set(OfBox::Notice, Some(Value::Text(why.to_owned())));
        self.notices.of_box(&self.config.name, why);
    }

    fn entry(&self, record: &Record) -> Option<Entry> {
        match to_line(record) {
            Ok(line) => Some(Entry {
                sender: record.id.sender.to_string(),
                verdict: matches!(record.body, Body::Verdict(_)),
                line,
            }),
            Err(why) => {
                self.notices.of_box(
                    &self.config.name,
                    &format!("a record cannot be written: {why}"),
                );
                None
            }
        }
    }

    fn hand_on(&self, entries: Vec<Entry>, condenser: &Condenser) {
        let state = condenser
            .under_way()
            .and_then(|u| serde_json::to_string(u).ok());
        let batch = Batch {
            entries,
            // Nothing is under way: kept as such, or a restart would tell of it again.
            under_way: Some((
                self.config.name.to_string(),
                state.unwrap_or_else(|| "null".to_owned()),
            )),
        };
        // Waits while the journal does not take more: the box's frames wait in its link.
        let _ = self.batches.send(batch);
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Waits. What was told meanwhile is told to the box if it comes back in time, and dropped if not.
    fn pause(&self, long: Duration) {
        let until = Instant::now() + long;
        while Instant::now() < until && !self.stopped() {
            let old = self.shared.told().old(Instant::now());
            for told in old {
                self.refused(&format!("not told: {told}: the box is away"));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn clock_words(fault: ClockFault) -> String {
    match fault {
        ClockFault::HostBack { seconds } => format!(
            "this computer's clock was set back by {seconds:.1} s; times of records begin anew with it"
        ),
        ClockFault::BoxBack { seconds } => {
            format!("the box's time ran back by {seconds:.1} s (its monitor was started anew)")
        }
    }
}

#[cfg(test)]
#[path = "boxes_tests.rs"]
mod tests;
