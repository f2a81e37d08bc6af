//! Records of one machine on one day, before they are numbered.

use super::PlantConfig;
use crate::record::{Body, Id, Name, Record, SCHEMA, Utc, settings_hash};

/// What is said on a day.
pub(super) struct Says {
    machine: Name,
    start: Utc,
    day: u32,
    /// By people with rigs: whole records.
    pub by_test: Vec<Record>,
    /// By the box, by time: it numbers and dates them.
    pub by_box: Vec<Said>,
}

/// Something a box says, by true time.
#[derive(Debug, Clone)]
pub(super) struct Said {
    /// Day and part of it, from 0.
    pub day: f64,
    /// The record but for its name and clock. Where it speaks of an earlier one of the same day, `seq` there is
    /// a place in the day's list.
    pub record: Record,
}

impl Says {
    pub fn new(config: &PlantConfig, machine: Name, day: u32) -> Self {
        Self {
            machine,
            start: config.start,
            day,
            by_test: Vec::new(),
            by_box: Vec::new(),
        }
    }

    /// The day, from 0.
    pub fn day(&self) -> u32 {
        self.day
    }

    fn record(&self, sender: Name, part: f64, tool: &str, operator: &str, body: Body) -> Record {
        let name = |text: &str| Name::new(text).ok();
        Record {
            schema: SCHEMA,
            id: Id {
                sender,
                session: 0,
                seq: 0,
            },
            machine: self.machine.clone(),
            time: self.start.plus_s((f64::from(self.day) + part) * 86_400.0),
            clock: None,
            tool: name(tool),
            operator: name(operator),
            settings: Some(settings_hash(b"usual")),
            firmware: name("0.1.0"),
            body,
        }
    }

    /// A test: its rig is the sender, its day the session.
    pub fn test(&mut self, rig: &str, part: f64, tool: &str, operator: &str, body: Body) {
        let sender = Name::new(&format!("{rig}-{}", self.machine)).expect("short");
        let mut record = self.record(sender, part, tool, operator, body);
        record.id.session = u64::from(self.day) + 1;
        record.id.seq = self
            .by_test
            .iter()
            .filter(|r| r.id.sender == record.id.sender)
            .count() as u64;
        self.by_test.push(record);
    }

    /// The box says something; its place in the day's list.
    pub fn by_box(&mut self, part: f64, tool: &str, operator: &str, body: Body) -> u64 {
        let sender = Name::new(&format!("box-{}", self.machine)).expect("short");
        let record = self.record(sender, part, tool, operator, body);
        self.by_box.push(Said {
            day: f64::from(self.day) + part,
            record,
        });
        self.by_box.len() as u64 - 1
    }
}
