//! Records on their way: in order and by number, as far as may be, and again where nobody has said that they are
//! there.

use super::{OUTBOX, Uplink};
use crate::gateway::config::Acknowledge;
use crate::gateway::journal::Kept;
use crate::gateway::metrics::{OfNode, data, node_alias};
use crate::gateway::session::Outgoing;
use crate::gateway::value::Value;
use crate::gateway::writing::lock;
use crate::record::from_line;
use srad_types::payload::Metric;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Most records that are on their way.
const WINDOW: u64 = 4096;
/// Most records and bytes of lines in one message.
const RECORDS: usize = 128;
const BYTES: usize = 48 * 1024;
/// Without a word of the store for so long, records are sent again.
const PATIENCE: Duration = Duration::from_secs(5);

/// How far records are.
pub(super) struct Flow {
    /// The store has said where it is, since the last birth.
    pub agreed: bool,
    /// Sent up to here.
    pub sent: u64,
    /// The store has heard records up to here, beyond what it has acknowledged: one of them is of a later
    /// schema than its own.
    pub come: u64,
    /// Records up to here were there at the birth: they are history.
    pub history: u64,
    /// When the store was last heard, or records were first sent.
    pub heard: Instant,
    /// Marks on their way: number of the journal, and of the packet once it has one.
    pub marks: VecDeque<(u64, Option<u16>)>,
}

impl Flow {
    /// Nothing sent, and no store heard.
    pub fn new() -> Self {
        Self {
            agreed: false,
            sent: 0,
            come: 0,
            history: 0,
            heard: Instant::now(),
            marks: VecDeque::new(),
        }
    }

    /// A mark has left as this packet.
    pub fn left(&mut self, id: u16) {
        let waits = self.marks.iter_mut().find(|(_, packet)| packet.is_none());
        if let Some(mark) = waits {
            mark.1 = Some(id);
        }
    }
}

impl Uplink {
    /// Puts what the journal has and nobody was sent yet into the outbox, as much as may be on its way.
    pub(super) fn records(&mut self, ms: u64) {
        let journal = Arc::clone(&self.journal);
        let mut journal = lock(&journal);
        let come = journal.acknowledged().max(self.flow.come);
        if self.flow.sent > come && self.flow.heard.elapsed() > PATIENCE {
            self.flow.sent = come;
            self.flow.marks.clear();
            self.flow.heard = Instant::now();
        }
        while self.outbox.len() < OUTBOX && self.flow.sent < journal.last() {
            if self.flow.sent.saturating_sub(come) >= WINDOW {
                break;
            }
            let kept = match journal.after(self.flow.sent, RECORDS) {
                Ok(kept) => kept,
                Err(why) => {
                    self.notices.say(why.to_string());
                    break;
                }
            };
            for notice in journal.notices.drain(..) {
                self.notices.say(notice);
            }
            if self.flow.sent == come {
                self.flow.heard = Instant::now();
            }
            let count = within(&kept);
            let Some(last) = kept[..count].last().map(|k| k.seq) else {
                break;
            };
            let metrics = self.of_records(&kept[..count]);
            self.outbox.extend(self.session.data(metrics, ms));
            self.flow.sent = last;
            if self.broker.acknowledge == Acknowledge::Broker {
                // Deliveries of one connection are taken in order: a broker that has acknowledged
                // this one has taken all before it.
                self.flow.marks.push_back((last, None));
                self.outbox.push_back(Outgoing {
                    topic: self.mark.clone(),
                    payload: last.to_string().into_bytes(),
                    at_least_once: true,
                });
            }
        }
    }

    /// A message of records.
    fn of_records(&self, kept: &[Kept]) -> Vec<Metric> {
        let mut metrics = Vec::with_capacity(1 + 2 * kept.len());
        for (k, one) in kept.iter().enumerate() {
            let historical = one.seq <= self.flow.history;
            // A record's time is that of what it tells.
            let ms = from_line(&one.line).map_or(0, |r| r.time.micros().unsigned_abs() / 1000);
            if k == 0 {
                let previous = Some(Value::Count(one.previous));
                metrics.push(data(node_alias(OfNode::Previous), previous, ms, historical));
            }
            let number = Some(Value::Count(one.seq));
            metrics.push(data(node_alias(OfNode::Number), number, ms, historical));
            let line = Some(Value::Text(one.line.clone()));
            metrics.push(data(node_alias(OfNode::Line), line, ms, historical));
        }
        metrics
    }

    /// The broker has a mark, and all records before it.
    pub(super) fn marked(&mut self, id: u16) {
        let Some(place) = self
            .flow
            .marks
            .iter()
            .position(|(_, packet)| *packet == Some(id))
        else {
            return;
        };
        let Some(&(number, _)) = self.flow.marks.get(place) else {
            return;
        };
        self.flow.marks.drain(..=place);
        self.acknowledge(number);
    }

    /// All up to this number are where they belong.
    fn acknowledge(&mut self, number: u64) {
        self.flow.heard = Instant::now();
        if let Err(why) = lock(&self.journal).acknowledge(number) {
            self.notices.say(why.to_string());
        }
    }

    /// The store says how far it has them, and how far they have come: see [`Flow::come`].
    pub(super) fn store_has(&mut self, identity: &str, number: u64, come: u64) {
        let (own, last, acknowledged) = {
            let journal = lock(&self.journal);
            (
                journal.identity().to_string(),
                journal.last(),
                journal.acknowledged(),
            )
        };
        if identity != own {
            self.notices
                .say("refused: the store has acknowledged another journal's records".to_owned());
            return;
        }
        if come > last {
            self.notices.say(format!(
                "refused: the store has acknowledged record {come}, the journal has {last}"
            ));
            return;
        }
        if !self.flow.agreed {
            self.flow.agreed = true;
            // A store that has less than was acknowledged was set back: it gets again what is still there.
            self.flow.sent = come;
            if number < acknowledged {
                self.notices.note(format!(
                    "the store is set back to record {number} of {acknowledged}: what the journal still has is sent again"
                ));
            }
        }
        if come > number && self.flow.come <= number {
            self.notices.say(format!(
                "the store does not know the schema of record {}: from there on records stay in the journal, too (update the store)",
                number + 1
            ));
        }
        self.flow.come = come;
        self.acknowledge(number);
    }
}

/// How many of the first go into one message.
fn within(kept: &[Kept]) -> usize {
    let mut bytes = 0;
    let fits = kept.iter().take_while(|one| {
        bytes += one.line.len();
        bytes <= BYTES
    });
    fits.count().max(kept.len().min(1))
}
