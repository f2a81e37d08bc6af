//! The metrics of Sparkplug B: what the gateway (edge node) and each box (device) have, under which
//! names and aliases.
//!
//! Aliases are unique over the node and its devices: the node's begin at 1, those of box k (from 0)
//! at 64·(k + 1). `bdSeq` and `Node Control/Rebirth` have none, as the specification asks.

use super::value::Value;
use srad_types::payload::{DataType, Metric, metric};
use srad_types::{PropertySet, payload};

/// What kind of value a metric has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// UTF-8.
    Text,
    /// A double.
    Number,
    /// A count.
    Count,
    /// Yes or no.
    Flag,
}

/// One metric of the table.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Name.
    pub name: &'static str,
    /// Kind of value.
    pub kind: Type,
    /// Unit, as the property `engUnit`; empty: none.
    pub unit: &'static str,
}

const fn row(name: &'static str, kind: Type, unit: &'static str) -> Row {
    Row { name, kind, unit }
}

macro_rules! metrics {
    ($(#[$doc:meta])* $of:ident $table:ident { $($(#[$about:meta])* $id:ident: $name:expr, $kind:ident, $unit:expr;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $of { $($(#[$about])* $id,)* }

        /// The rows of the table, in the order of their aliases.
        pub const $table: &[Row] = &[$(row($name, Type::$kind, $unit),)*];
    };
}

metrics! {
    /// Metrics of a box.
    OfBox BOX {
        /// Of which machine.
        Machine: "Machine", Text, "";
        /// What the monitor believes.
        State: "State", Text, "";
        /// Why.
        Reason: "Reason", Text, "";
        /// Root mean square of the band.
        Level: "Level", Number, "";
        /// Frequency of the least damped mode.
        ModeFrequency: "Mode/Frequency", Number, "Hz";
        /// Its deviation.
        ModeFrequencySd: "Mode/Frequency SD", Number, "Hz";
        /// Its damping ratio.
        ModeDamping: "Mode/Damping", Number, "";
        /// Its deviation.
        ModeDampingSd: "Mode/Damping SD", Number, "";
        /// An alarm stands.
        AlarmOn: "Alarm/On", Flag, "";
        /// Frequency of the last alarm.
        AlarmFrequency: "Alarm/Frequency", Number, "Hz";
        /// Damping ratio of the last alarm.
        AlarmDamping: "Alarm/Damping", Number, "";
        /// Spindle speed; can be written.
        Speed: super::told::Told::SPEED, Number, "1/min";
        /// Teeth of the tool; can be written.
        Teeth: super::told::Told::TEETH, Count, "";
        /// What the box does.
        Mode: "Box/Mode", Text, "";
        /// The latched fault.
        Fault: "Box/Fault", Text, "";
        /// Board.
        Board: "Box/Board", Text, "";
        /// Firmware.
        Firmware: "Box/Firmware", Text, "";
        /// Hash of the settings.
        Settings: "Box/Settings", Text, "";
        /// How much faster the box's clock runs than UTC.
        Drift: "Clock/Drift", Number, "ppm";
        /// Frames that came whole.
        Frames: "Link/Frames", Count, "";
        /// Frames that did not come, by their numbers.
        Missing: "Link/Frames missing", Count, "";
        /// Frames that came broken.
        Broken: "Link/Frames broken", Count, "";
        /// What the gateway had to notice of this box last.
        Notice: "Notice", Text, "";
        /// Tool in the spindle; can be written.
        Tool: super::told::Told::TOOL, Text, "";
    }
}

metrics! {
    /// Metrics of the gateway.
    OfNode NODE {
        /// Version of the program.
        Version: "Gateway/Version", Text, "";
        /// What the gateway had to notice last.
        Notice: "Gateway/Notice", Text, "";
        /// Identity of the journal, decimal digits.
        Identity: "Journal/Identity", Text, "";
        /// Highest number that is at its store; a store writes it.
        Acknowledged: "Journal/Acknowledged", Count, "";
        /// Records that wait.
        Waiting: "Journal/Waiting", Count, "";
        /// Records that went unsent for want of room.
        Dropped: "Journal/Dropped", Count, "";
        /// Number of the record before the first of a message.
        Previous: "Record/Previous", Count, "";
        /// Number of the record whose line follows.
        Number: "Record/Number", Count, "";
        /// A record.
        Line: "Record/Line", Text, "";
        /// Highest number that has come to the store, beyond [`Self::Acknowledged`] where a record between
        /// them is of a later schema; a store writes it.
        Come: "Journal/Come", Count, "";
    }
}

/// Room for the metrics of one box.
const STEP: u64 = 64;
const _: () = assert!(BOX.len() < STEP as usize && NODE.len() < STEP as usize);

/// Asks for births.
pub const REBIRTH: &str = srad_types::constants::NODE_CONTROL_REBIRTH;

/// Alias of a metric of box `index`.
#[must_use]
pub fn box_alias(index: usize, metric: OfBox) -> u64 {
    STEP * (index as u64 + 1) + metric as u64
}

/// Alias of a metric of the gateway.
#[must_use]
pub fn node_alias(metric: OfNode) -> u64 {
    1 + metric as u64
}

impl Value {
    fn wire(self) -> metric::Value {
        match self {
            Self::Text(text) => metric::Value::StringValue(text),
            Self::Number(number) => metric::Value::DoubleValue(number),
            Self::Count(count) => metric::Value::LongValue(count),
            Self::Flag(flag) => metric::Value::BooleanValue(flag),
        }
    }

    /// Reads a number of whatever width; none of text, flags and what is no number.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "speeds and teeth are small")]
    pub fn number_of(value: &metric::Value, datatype: Option<u32>) -> Option<f64> {
        let signed = |bits: u64| bits.cast_signed() as f64;
        match *value {
            metric::Value::DoubleValue(x) => Some(x),
            metric::Value::FloatValue(x) => Some(f64::from(x)),
            metric::Value::IntValue(n) => match datatype.map(DataType::try_from) {
                Some(Ok(DataType::Int8 | DataType::Int16 | DataType::Int32)) => {
                    Some(f64::from(n.cast_signed()))
                }
                _ => Some(f64::from(n)),
            },
            metric::Value::LongValue(n) => match datatype.map(DataType::try_from) {
                Some(Ok(DataType::Int64)) => Some(signed(n)),
                _ => Some(n as f64),
            },
            _ => None,
        }
    }
}

/// A metric as it is born: with name, alias, type, unit and its value now.
#[must_use]
pub fn born(row: &Row, alias: u64, value: Option<Value>, ms: u64) -> Metric {
    let mut metric = Metric::new();
    metric.set_name(row.name.to_owned());
    metric.set_alias(alias);
    metric.set_datatype(match row.kind {
        Type::Text => DataType::String,
        Type::Number => DataType::Double,
        Type::Count => DataType::UInt64,
        Type::Flag => DataType::Boolean,
    });
    metric.set_timestamp(ms);
    if !row.unit.is_empty() {
        let mut properties = PropertySet::new();
        // The one way this fails is a name that comes twice.
        let _ = properties.insert("engUnit", Some(row.unit.to_owned()));
        metric.properties = Some(payload::PropertySet::from(properties));
    }
    set(&mut metric, value);
    metric
}

/// A metric as data: alias and value.
#[must_use]
pub fn data(alias: u64, value: Option<Value>, ms: u64, historical: bool) -> Metric {
    let mut metric = Metric::new();
    metric.set_alias(alias);
    metric.set_timestamp(ms);
    if historical {
        metric.is_historical = Some(true);
    }
    set(&mut metric, value);
    metric
}

fn set(metric: &mut Metric, value: Option<Value>) {
    // JSON and Sparkplug agree on this: there is no number that is none.
    match value.filter(|v| !matches!(v, Value::Number(x) if !x.is_finite())) {
        Some(value) => metric.set_value(value.wire()),
        None => metric.set_null(),
    };
}

/// The values of one box as they are now, and which have changed since they were last sent.
#[derive(Debug, Clone)]
pub struct Live {
    values: Vec<Option<Value>>,
    changed: Vec<bool>,
    /// The box is heard.
    pub here: bool,
}

impl Default for Live {
    fn default() -> Self {
        Self {
            values: vec![None; BOX.len()],
            changed: vec![false; BOX.len()],
            here: false,
        }
    }
}

impl Live {
    /// A value as it is now.
    pub fn set(&mut self, metric: OfBox, value: Option<Value>) {
        let place = metric as usize;
        if self.values[place] != value {
            self.values[place] = value;
            self.changed[place] = true;
        }
    }

    /// What it is now.
    #[must_use]
    pub fn get(&self, metric: OfBox) -> Option<&Value> {
        self.values[metric as usize].as_ref()
    }

    /// All metrics with their values, as they are born.
    pub fn births(&mut self, index: usize, ms: u64) -> Vec<Metric> {
        self.changed.fill(false);
        let alias = |k: usize| STEP * (index as u64 + 1) + k as u64;
        let rows = BOX.iter().zip(&self.values).enumerate();
        rows.map(|(k, (row, value))| born(row, alias(k), value.clone(), ms))
            .collect()
    }

    /// What has changed since it was asked last.
    pub fn changes(&mut self, index: usize, ms: u64) -> Vec<Metric> {
        let alias = |k: usize| STEP * (index as u64 + 1) + k as u64;
        let changed = self.changed.iter_mut().zip(&self.values).enumerate();
        changed
            .filter_map(|(k, (changed, value))| {
                std::mem::take(changed).then(|| data(alias(k), value.clone(), ms, false))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_alias_comes_twice_among_fifty_boxes() {
        let mut aliases = BTreeSet::new();
        let mut count = 0;
        for k in 0..NODE.len() as u64 {
            aliases.insert(1 + k);
            count += 1;
        }
        for index in 0..50 {
            for metric in Live::default().births(index, 0) {
                aliases.insert(metric.alias.unwrap());
                count += 1;
            }
        }
        assert_eq!(aliases.len(), count);
        assert_eq!(box_alias(0, OfBox::Machine), 64);
        assert_eq!(node_alias(OfNode::Version), 1);
    }

    #[test]
    fn only_what_changes_is_sent_again() {
        let mut live = Live::default();
        live.set(OfBox::State, Some(Value::Text("idle".into())));
        assert_eq!(live.births(0, 5).len(), BOX.len());
        live.set(OfBox::State, Some(Value::Text("idle".into())));
        assert!(live.changes(0, 6).is_empty());
        live.set(OfBox::Level, Some(Value::Number(f64::NAN)));
        let changes = live.changes(0, 7);
        assert_eq!(changes.len(), 1);
        assert_eq!(
            (changes[0].alias, changes[0].is_null),
            (Some(67), Some(true))
        );
        assert!(live.changes(0, 8).is_empty());
    }
}
