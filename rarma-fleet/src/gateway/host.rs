//! The other end: a Sparkplug host that takes records of gateways and hands them to a store.
//!
//! [`Receiver`] is without a wire; [`receive`] puts it on one. It says that it is there (`STATE`), asks
//! gateways it does not know for their births, tells each where its store is with that gateway's
//! journal, and acknowledges what the store has taken.
//!
//! **Once.** A message names the number before its first record. One that goes on where the store is, is
//! taken; records that the store has, are passed over; one that leaves something out is not taken, and
//! the gateway sends it again. So a store gets each number once and in order, whatever the broker loses,
//! doubles or turns about. What a gateway made twice itself it named twice the same, which the store
//! knows by the record's name.
//!
//! **A record of a later schema** (a gateway that is newer than this program) is not stored, so neither it nor
//! what follows is acknowledged: it stays in the gateway's journal. What follows is taken all the same, and
//! the gateway hears how far that is (`Journal/Come`), so that it goes on. A newer program gets all of
//! it again, and knows what it has by its name.

mod wire;

use super::metrics::{NODE, OfNode, REBIRTH, node_alias};
use super::session::NAMESPACE;
use crate::record::{Record, RecordError, SCHEMA, Utc, from_line};
use srad_types::constants::BDSEQ;
use srad_types::payload::{DataType, Message, Metric, Payload, metric};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
pub use wire::receive;

/// A record with its number in the journal, and its line as it came.
pub type Numbered = (u64, String, Record);

/// Where records end.
pub trait Sink {
    /// The highest number of a journal that is stored; 0: none.
    ///
    /// # Errors
    /// The store cannot be read; in one line.
    fn position(&mut self, identity: &str) -> Result<u64, String>;

    /// Stores lines and, in the same step, that the journal is stored up to `number`. Lines may be beyond
    /// it, and come again after a restart, where one before them is of a later schema.
    ///
    /// # Errors
    /// The store cannot be written, and nothing was: it is sent again.
    fn store(&mut self, identity: &str, number: u64, records: &[Numbered]) -> Result<(), String>;
}

/// What a host is to say.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// Topic.
    pub topic: String,
    /// Payload.
    pub payload: Vec<u8>,
}

#[derive(Debug, Default)]
struct Node {
    identity: Option<String>,
    /// `bdSeq` of its birth.
    birth: Option<u64>,
    /// Stored up to here.
    position: u64,
    /// Come up to here; beyond `position` where something between them is of a later schema.
    come: u64,
    /// The next number of its messages.
    expected: Option<u8>,
    asked: Option<Instant>,
}

/// Takes the records of a group of gateways.
#[derive(Debug)]
pub struct Receiver {
    group: String,
    nodes: BTreeMap<String, Node>,
    /// Messages and records that were not taken, by what was wrong.
    pub refused: BTreeMap<&'static str, u64>,
    /// Records that came though the store had them: sent twice.
    pub repeated: u64,
    /// What has to be told at once, a line each.
    pub notices: Vec<String>,
}

/// The records of a message.
struct Came {
    /// The number of the last one.
    last: u64,
    records: Vec<Numbered>,
    /// Number and schema of the first one of a later schema.
    later: Option<(u64, u64)>,
}

/// A birth that was asked for is waited for so long.
const BIRTH: Duration = Duration::from_secs(5);
/// Most gateways that are remembered.
const MOST_NODES: usize = 1000;

impl Receiver {
    /// Of the gateways of a group.
    #[must_use]
    pub fn new(group: &str) -> Self {
        Self {
            group: group.to_owned(),
            nodes: BTreeMap::new(),
            refused: BTreeMap::new(),
            repeated: 0,
            notices: Vec::new(),
        }
    }

    fn refuse(&mut self, why: &'static str) {
        *self.refused.entry(why).or_default() += 1;
    }

    /// Takes a message; what is to be said then.
    ///
    /// # Errors
    /// The store does not take it.
    pub fn take(
        &mut self,
        topic: &str,
        payload: &[u8],
        sink: &mut dyn Sink,
    ) -> Result<Vec<Said>, String> {
        let parts: Vec<&str> = topic.split('/').collect();
        let (kind, name) = match parts[..] {
            [NAMESPACE, group, kind, node] if group == self.group => (kind, node),
            [
                NAMESPACE,
                group,
                kind @ ("DBIRTH" | "DDATA" | "DDEATH" | "DCMD"),
                node,
                _,
            ] if group == self.group => (kind, node),
            _ => {
                self.refuse("a foreign topic");
                return Ok(Vec::new());
            }
        };
        let Ok(payload) = Payload::decode(payload) else {
            self.refuse("a payload that is none");
            return Ok(Vec::new());
        };
        if !self.nodes.contains_key(name) && self.nodes.len() >= MOST_NODES {
            self.refuse("one gateway too many");
            return Ok(Vec::new());
        }
        let name = name.to_owned();
        match kind {
            "NBIRTH" => self.born(&name, &payload, sink),
            "NDEATH" => {
                // The will of a connection before the last birth is no death.
                if let Some(node) = self.nodes.get_mut(&name)
                    && node.birth == birth_of(&payload)
                {
                    node.identity = None;
                }
                Ok(Vec::new())
            }
            "NDATA" | "DDATA" | "DBIRTH" | "DDEATH" => self.data(&name, kind, &payload, sink),
            "NCMD" | "DCMD" => Ok(Vec::new()),
            _ => {
                self.refuse("a kind of message that is none");
                Ok(Vec::new())
            }
        }
    }

    fn born(
        &mut self,
        name: &str,
        payload: &Payload,
        sink: &mut dyn Sink,
    ) -> Result<Vec<Said>, String> {
        let Some(identity) = payload
            .metrics
            .iter()
            .find_map(|m| text_of(m, OfNode::Identity))
        else {
            self.refuse("a birth without a journal (not a gateway of ours)");
            return Ok(Vec::new());
        };
        let position = sink.position(&identity)?;
        let node = self.nodes.entry(name.to_owned()).or_default();
        node.expected = Some(1);
        node.asked = None;
        (node.position, node.come) = (position, position);
        node.birth = birth_of(payload);
        node.identity = Some(identity.clone());
        Ok(vec![self.acknowledged(name, &identity, position, position)])
    }

    fn data(
        &mut self,
        name: &str,
        kind: &str,
        payload: &Payload,
        sink: &mut dyn Sink,
    ) -> Result<Vec<Said>, String> {
        let node = self.nodes.entry(name.to_owned()).or_default();
        let sequence = payload.seq.and_then(|seq| u8::try_from(seq).ok());
        let in_order = node.identity.is_some() && sequence.is_some() && node.expected == sequence;
        node.expected = sequence.map(|s| s.wrapping_add(1));
        let Some(identity) = node.identity.clone().filter(|_| in_order) else {
            // Never born here, or a message was lost: everything is asked for again, but not all the time.
            node.identity = None;
            if node.asked.is_some_and(|at| at.elapsed() < BIRTH) {
                return Ok(Vec::new());
            }
            node.asked = Some(Instant::now());
            self.refuse("data before a birth, or a message missing");
            return Ok(vec![self.rebirth(name)]);
        };
        if kind != "NDATA" {
            return Ok(Vec::new());
        }
        let (position, come) = (node.position, node.come);
        let Some(came) = self.records(payload, come) else {
            return Ok(Vec::new());
        };
        let position = match came.later {
            _ if position < come => position,
            None => came.last,
            Some((number, schema)) => {
                self.notices.push(format!(
                    "gateway {name}: record {number} has schema {schema}, this program knows up to {SCHEMA} (update it: from there on records stay in the gateway's journal, too)"
                ));
                number - 1
            }
        };
        if came.last > come {
            sink.store(&identity, position, &came.records)?;
        }
        if let Some(node) = self.nodes.get_mut(name) {
            (node.position, node.come) = (position, came.last);
        }
        Ok(vec![
            self.acknowledged(name, &identity, position, came.last),
        ])
    }

    /// The records of a message beyond a number; none where the message has none or leaves some out.
    fn records(&mut self, payload: &Payload, come: u64) -> Option<Came> {
        let previous = payload
            .metrics
            .iter()
            .find_map(|m| count_of(m, OfNode::Previous))?;
        if previous > come {
            self.refuse("records that leave some out");
            return None;
        }
        let mut came = Came {
            last: come,
            records: Vec::new(),
            later: None,
        };
        let mut number = None;
        for metric in &payload.metrics {
            if let Some(count) = count_of(metric, OfNode::Number) {
                number = Some(count);
            } else if let Some(line) = text_of(metric, OfNode::Line)
                && let Some(number) = number.take()
            {
                if number <= came.last {
                    self.repeated += 1;
                    continue;
                }
                came.last = number;
                match from_line(&line) {
                    Ok(record) => came.records.push((number, line, record)),
                    Err(RecordError::Future { found }) => {
                        came.later.get_or_insert((number, found));
                        self.refuse("a record of a later schema");
                    }
                    // It will never be one: the gateway keeps it for a while after it is acknowledged.
                    Err(_) => self.refuse("a record that is none"),
                }
            }
        }
        Some(came)
    }

    /// Asks a gateway for its births.
    fn rebirth(&self, name: &str) -> Said {
        let mut metric = Metric::new();
        metric.set_name(REBIRTH.to_owned());
        metric.set_datatype(DataType::Boolean);
        metric.set_value(metric::Value::BooleanValue(true));
        self.command(name, vec![metric])
    }

    fn acknowledged(&self, name: &str, identity: &str, number: u64, come: u64) -> Said {
        let named = |of: OfNode, datatype, value| {
            let mut metric = Metric::new();
            metric.set_name(NODE[of as usize].name.to_owned());
            metric.set_datatype(datatype);
            metric.set_value(value);
            metric
        };
        let identity = metric::Value::StringValue(identity.to_owned());
        let count = |of, count| named(of, DataType::UInt64, metric::Value::LongValue(count));
        let mut metrics = vec![
            named(OfNode::Identity, DataType::String, identity),
            count(OfNode::Acknowledged, number),
        ];
        metrics.extend((come > number).then(|| count(OfNode::Come, come)));
        self.command(name, metrics)
    }

    fn command(&self, name: &str, metrics: Vec<Metric>) -> Said {
        let ms = now_ms();
        let payload = Payload {
            timestamp: Some(ms),
            metrics: metrics
                .into_iter()
                .map(|mut metric| {
                    metric.set_timestamp(ms);
                    metric
                })
                .collect(),
            ..Payload::default()
        };
        Said {
            topic: format!("{NAMESPACE}/{}/NCMD/{name}", self.group),
            payload: payload.encode_to_vec(),
        }
    }
}

fn birth_of(payload: &Payload) -> Option<u64> {
    let metric = payload
        .metrics
        .iter()
        .find(|m| m.name.as_deref() == Some(BDSEQ))?;
    match metric.value.as_ref()? {
        metric::Value::LongValue(number) => Some(*number),
        metric::Value::IntValue(number) => Some(u64::from(*number)),
        _ => None,
    }
}

fn value_of(metric: &Metric, of: OfNode) -> Option<&metric::Value> {
    let named = metric
        .name
        .as_deref()
        .map(|name| name == NODE[of as usize].name);
    let is = named.unwrap_or(metric.alias == Some(node_alias(of)));
    metric.value.as_ref().filter(|_| is)
}

fn count_of(metric: &Metric, of: OfNode) -> Option<u64> {
    match value_of(metric, of)? {
        metric::Value::LongValue(count) => Some(*count),
        _ => None,
    }
}

fn text_of(metric: &Metric, of: OfNode) -> Option<String> {
    match value_of(metric, of)? {
        metric::Value::StringValue(text) => Some(text.clone()),
        _ => None,
    }
}

fn now_ms() -> u64 {
    Utc::now().map_or(0, |now| now.micros().unsigned_abs() / 1000)
}

#[cfg(test)]
#[path = "host_tests.rs"]
mod tests;
