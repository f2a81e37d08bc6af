//! The rules of a Sparkplug B edge node, without a wire: births before data, numbers of messages,
//! deaths, the primary host.
//!
//! ```text
//! will: NDEATH(bdSeq)   CONNECT   SUBSCRIBE NCMD, DCMD, STATE
//!   primary host named?  wait for STATE online
//! NBIRTH(seq 0, bdSeq)  DBIRTH(seq 1) …  then NDATA and DDATA, seq up to 255 and on from 0
//!   STATE offline, not older than the online one: NDEATH, and off the broker
//! ```

use super::metrics::{self, NODE, REBIRTH};
use super::value::Value;
use super::words::shortened;
use srad_types::constants::BDSEQ;
use srad_types::payload::{DataType, Message, Metric, Payload, metric};

/// First part of every topic.
pub const NAMESPACE: &str = "spBv1.0";

/// A message to the broker.
#[derive(Debug, Clone, PartialEq)]
pub struct Outgoing {
    /// Topic.
    pub topic: String,
    /// Payload.
    pub payload: Vec<u8>,
    /// At least once; all but deaths go at most once, as the specification asks.
    pub at_least_once: bool,
}

/// What a host wants.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanted {
    /// All births again.
    Rebirth,
    /// Its store has everything up to this number of the journal with this identity.
    Acknowledged {
        /// Identity of the journal, as the birth told it.
        identity: String,
        /// The number.
        number: u64,
        /// What comes up to this number was taken or is not understood: none of it is to be sent
        /// again. `number` at least.
        come: u64,
    },
    /// A metric of a box is to be written.
    Write {
        /// Which box.
        device: String,
        /// Name of the metric.
        metric: String,
        /// Its value: a number or a text.
        value: Value,
    },
    /// Nothing of these; in words.
    Foreign(String),
}

/// What a host says of itself.
#[derive(serde::Deserialize)]
pub(super) struct State {
    pub online: bool,
    timestamp: u64,
}

/// What the state of the primary host asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostSays {
    /// Nothing new.
    Nothing,
    /// It is there: births may go.
    Online,
    /// It has gone: die, and leave.
    Offline,
}

/// The state of one edge node at its broker.
#[derive(Debug)]
pub struct Session {
    group: String,
    node: String,
    devices: Vec<String>,
    primary: Option<String>,
    birth: u8,
    /// When it connected.
    since_ms: u64,
    sequence: u8,
    born: bool,
    /// Last state of the primary host: online, and its time.
    host: Option<(bool, u64)>,
}

impl Session {
    /// A node that is not connected. `devices` in the order of their aliases.
    #[must_use]
    pub fn new(group: &str, node: &str, devices: Vec<String>, primary: Option<String>) -> Self {
        Self {
            group: group.to_owned(),
            node: node.to_owned(),
            devices,
            primary,
            birth: 0,
            since_ms: 0,
            sequence: 0,
            born: false,
            host: None,
        }
    }

    /// A new connection at a time, of the number `birth`: what the broker says when it is lost.
    pub fn connects(&mut self, birth: u8, ms: u64) -> Outgoing {
        self.since_ms = ms;
        self.birth = birth;
        self.born = false;
        self.host = None;
        self.death()
    }

    /// What is subscribed to.
    #[must_use]
    pub fn filters(&self) -> Vec<String> {
        let Self { group, node, .. } = self;
        let mut filters = vec![
            format!("{NAMESPACE}/{group}/NCMD/{node}"),
            format!("{NAMESPACE}/{group}/DCMD/{node}/+"),
        ];
        if let Some(host) = &self.primary {
            filters.push(format!("{NAMESPACE}/STATE/{host}"));
        }
        filters
    }

    /// Births may go now: there is no primary host, or it is there.
    #[must_use]
    pub fn may_be_born(&self) -> bool {
        self.primary.is_none() || self.host.is_some_and(|(online, _)| online)
    }

    /// Births have gone.
    #[must_use]
    pub fn is_born(&self) -> bool {
        self.born
    }

    /// The node's birth. Devices have to be born again after it.
    pub fn birth(&mut self, values: &[(metrics::OfNode, Value)], ms: u64) -> Outgoing {
        self.born = true;
        self.sequence = 0;
        let mut payload = Payload {
            timestamp: Some(ms),
            seq: Some(0),
            ..Payload::default()
        };
        payload.metrics.push(self.bd_seq(ms));
        let mut rebirth = Metric::new();
        rebirth.set_name(REBIRTH.to_owned());
        rebirth.set_datatype(DataType::Boolean);
        rebirth.set_timestamp(ms);
        rebirth.set_value(metric::Value::BooleanValue(false));
        payload.metrics.push(rebirth);
        for (k, row) in NODE.iter().enumerate() {
            let value = values.iter().find(|(metric, _)| *metric as usize == k);
            payload.metrics.push(metrics::born(
                row,
                1 + k as u64,
                value.map(|(_, v)| v.clone()),
                ms,
            ));
        }
        Outgoing {
            topic: self.node_topic("NBIRTH"),
            payload: payload.encode_to_vec(),
            at_least_once: false,
        }
    }

    /// A box's birth.
    pub fn device_birth(
        &mut self,
        device: usize,
        metrics: Vec<Metric>,
        ms: u64,
    ) -> Option<Outgoing> {
        self.of_device("DBIRTH", device, metrics, ms)
    }

    /// A box's data.
    pub fn device_data(
        &mut self,
        device: usize,
        metrics: Vec<Metric>,
        ms: u64,
    ) -> Option<Outgoing> {
        self.of_device("DDATA", device, metrics, ms)
    }

    /// A box's death.
    pub fn device_death(&mut self, device: usize, ms: u64) -> Option<Outgoing> {
        self.of_device("DDEATH", device, Vec::new(), ms)
    }

    /// The node's data.
    pub fn data(&mut self, metrics: Vec<Metric>, ms: u64) -> Option<Outgoing> {
        let topic = self.node_topic("NDATA");
        self.numbered(topic, metrics, ms)
    }

    /// The node's death: what it says itself before it leaves, and its will.
    #[must_use]
    pub fn death(&self) -> Outgoing {
        // Of the time of the connection: it is written before it is true.
        let payload = Payload {
            timestamp: Some(self.since_ms),
            metrics: vec![self.bd_seq(self.since_ms)],
            ..Payload::default()
        };
        Outgoing {
            topic: self.node_topic("NDEATH"),
            payload: payload.encode_to_vec(),
            at_least_once: true,
        }
    }

    /// The connection is lost, or left.
    pub fn leaves(&mut self) {
        self.born = false;
        self.host = None;
    }

    fn of_device(
        &mut self,
        kind: &str,
        device: usize,
        metrics: Vec<Metric>,
        ms: u64,
    ) -> Option<Outgoing> {
        let name = self.devices.get(device)?;
        let topic = format!("{}/{name}", self.node_topic(kind));
        self.numbered(topic, metrics, ms)
    }

    fn numbered(&mut self, topic: String, metrics: Vec<Metric>, ms: u64) -> Option<Outgoing> {
        if !self.born {
            return None;
        }
        self.sequence = self.sequence.wrapping_add(1);
        let payload = Payload {
            timestamp: Some(ms),
            metrics,
            seq: Some(u64::from(self.sequence)),
            ..Payload::default()
        };
        Some(Outgoing {
            topic,
            payload: payload.encode_to_vec(),
            at_least_once: false,
        })
    }

    fn bd_seq(&self, ms: u64) -> Metric {
        let mut metric = Metric::new();
        metric.set_name(BDSEQ.to_owned());
        metric.set_datatype(DataType::Int64);
        metric.set_timestamp(ms);
        metric.set_value(metric::Value::LongValue(u64::from(self.birth)));
        metric
    }

    fn node_topic(&self, kind: &str) -> String {
        format!("{NAMESPACE}/{}/{kind}/{}", self.group, self.node)
    }

    /// What a message from the broker says of the primary host. A topic that is not its state says
    /// nothing.
    pub fn hears_state(&mut self, topic: &str, payload: &[u8]) -> HostSays {
        let Some(primary) = &self.primary else {
            return HostSays::Nothing;
        };
        if topic
            .strip_prefix(NAMESPACE)
            .and_then(|t| t.strip_prefix("/STATE/"))
            != Some(primary)
        {
            return HostSays::Nothing;
        }
        let Ok(state) = serde_json::from_slice::<State>(payload) else {
            return HostSays::Nothing;
        };
        let before = self.host;
        match (before, state.online) {
            // An offline that is older than the online one is the will of a connection before it.
            (Some((true, since)), false) if state.timestamp < since => HostSays::Nothing,
            (Some((true, _)), false) => {
                self.host = Some((false, state.timestamp));
                HostSays::Offline
            }
            (_, false) => HostSays::Nothing,
            (_, true) => {
                self.host = Some((true, state.timestamp));
                if self.born {
                    HostSays::Nothing
                } else {
                    HostSays::Online
                }
            }
        }
    }

    /// What a message from the broker asks for.
    #[must_use]
    pub fn hears_command(&self, topic: &str, payload: &[u8]) -> Vec<Wanted> {
        let foreign = |why: &str| vec![Wanted::Foreign(format!("{}: {why}", shortened(topic)))];
        let parts: Vec<&str> = topic.split('/').collect();
        let (device, ours) = match parts[..] {
            [NAMESPACE, group, "NCMD", node] => (None, group == self.group && node == self.node),
            [NAMESPACE, group, "DCMD", node, device] => {
                (Some(device), group == self.group && node == self.node)
            }
            _ => (None, false),
        };
        if !ours {
            return foreign("a topic that is not this gateway's");
        }
        let Ok(payload) = Payload::decode(payload) else {
            return foreign("no payload of Sparkplug B");
        };
        match device {
            None => node_wants(&payload),
            Some(device) => self.device_wants(device, &payload),
        }
        .unwrap_or_else(|why| foreign(&why))
    }

    fn device_wants(&self, device: &str, payload: &Payload) -> Result<Vec<Wanted>, String> {
        let place = self.devices.iter().position(|d| d == device);
        let index = place.ok_or("no box of this name is in the gateway's file")? as u64;
        let write = |metric: &Metric| {
            let named = metric.name.clone().or_else(|| {
                let place = metric.alias?.checked_sub(64 * (index + 1))?;
                let row = metrics::BOX.get(usize::try_from(place).ok()?)?;
                Some(row.name.to_owned())
            });
            let name = named.ok_or("a metric without a name or an alias that was born")?;
            let value = metric.value.as_ref().and_then(|v| match v {
                metric::Value::StringValue(text) => Some(Value::Text(text.clone())),
                number => Value::number_of(number, metric.datatype).map(Value::Number),
            });
            Ok(Wanted::Write {
                device: device.to_owned(),
                value: value.ok_or(format!("{}: no number and no text", shortened(&name)))?,
                metric: name,
            })
        };
        payload.metrics.iter().map(write).collect()
    }
}

fn node_wants(payload: &Payload) -> Result<Vec<Wanted>, String> {
    let of = |wanted: metrics::OfNode| {
        let row = &NODE[wanted as usize];
        let alias = metrics::node_alias(wanted);
        payload
            .metrics
            .iter()
            .find(|m| m.name.as_deref() == Some(row.name) || m.alias == Some(alias))
    };
    let mut wants = Vec::new();
    let rebirth = payload
        .metrics
        .iter()
        .find(|m| m.name.as_deref() == Some(REBIRTH));
    if let Some(Metric {
        value: Some(metric::Value::BooleanValue(true)),
        ..
    }) = rebirth
    {
        wants.push(Wanted::Rebirth);
    }
    if let Some(acknowledged) = of(metrics::OfNode::Acknowledged) {
        let count = |metric: &Metric| match metric.value {
            Some(metric::Value::LongValue(number)) => Some(number),
            Some(metric::Value::IntValue(number)) => Some(u64::from(number)),
            _ => None,
        };
        let number = count(acknowledged).ok_or("Journal/Acknowledged: no number")?;
        // Only a store that has left something out says it.
        let come = match of(metrics::OfNode::Come) {
            Some(come) => count(come)
                .filter(|&come| come >= number)
                .ok_or("Journal/Come: no number, or less than Journal/Acknowledged")?,
            None => number,
        };
        let identity = match of(metrics::OfNode::Identity).and_then(|m| m.value.as_ref()) {
            Some(metric::Value::StringValue(identity)) => identity.clone(),
            _ => return Err("Journal/Acknowledged without Journal/Identity".to_owned()),
        };
        wants.push(Wanted::Acknowledged {
            identity,
            number,
            come,
        });
    }
    if wants.is_empty() {
        return Err("no metric that can be written here".to_owned());
    }
    Ok(wants)
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
