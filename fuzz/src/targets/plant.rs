//! What a plant sends: records, what other commands print and become, and messages of its broker.

use crate::{Target, check};
use rarma_fleet::convert::{self, Head};
use rarma_fleet::gateway::host::{Numbered, Receiver, Sink};
use rarma_fleet::gateway::session::Session;
use rarma_fleet::record::{Kind, Name, Quantity, RecordError, from_line, to_line};

pub(super) const RECORDS: Target = Target {
    name: "records",
    reads: "lines of records, and JSON that becomes records",
    run: |bytes| {
        let text = String::from_utf8_lossy(bytes);
        for line in text.lines() {
            one_record(line);
        }
        let name = |text: &str| Name::new(text).expect("a short word");
        let time = "2026-03-01T12:00:00Z".parse().expect("a time");
        let head = Head {
            machine: name("M1"),
            time: Some(time),
            sender: name("file"),
            tool: None,
            operator: None,
        };
        match convert::records(&text, &head) {
            Ok(records) => {
                // The same text gives the same records.
                assert_eq!(convert::records(&text, &head), Ok(records.clone()));
                for record in records {
                    match to_line(&record) {
                        Ok(line) => one_record(&line),
                        Err(why) => assert!(matches!(why, RecordError::Long(_)), "{why}"),
                    }
                }
            }
            Err(why) => check::one_line(&why.to_string()),
        }
    },
    words: || {
        let mut words: Vec<String> = [
            "\"schema\":1,",
            "\"body\":{",
            "\"kind\":\"",
            "\"machine\":\"",
            "\"time\":\"2026-03-01T12:00:00Z\"",
            "\"summary\":{",
            "\"findings\":{",
            "\"sweep\":{\"tracks\":[",
            "\"polar\":[",
            "\"utc\":",
            "\"act\":\"proposed\"",
            "null",
            "1e308",
        ]
        .map(str::to_owned)
        .to_vec();
        words.extend(Kind::ALL.map(|kind| kind.name().to_owned()));
        words.extend(Quantity::ALL.map(|quantity| quantity.name().to_owned()));
        words
    },
};

/// What is taken is written so that it is taken again, and all its numbers are some.
fn one_record(line: &str) {
    match from_line(line) {
        Ok(record) => {
            match to_line(&record) {
                Ok(again) => assert_eq!(from_line(&again).as_ref(), Ok(&record), "{again}"),
                // In other spelling it may be longer.
                Err(why) => assert!(matches!(why, RecordError::Long(_)), "{why}"),
            }
            for reading in record.body.readings() {
                assert!(
                    reading.value.is_finite() && reading.sd.is_finite(),
                    "{reading:?}"
                );
            }
        }
        Err(why) => check::one_line(&why.to_string()),
    }
}

pub(super) const SPARKPLUG: Target = Target {
    name: "sparkplug",
    reads: "messages of a broker, as the store's host and as a gateway",
    run: |bytes| {
        let mut host = Receiver::new("plant");
        let mut sink = Memory::default();
        let mut gateway = Session::new("plant", "gw", vec!["box".to_owned()], Some("store".into()));
        let _ = gateway.connects(1, 1);
        let mut rest = bytes;
        // A topic, the length of a payload in two bytes, the payload.
        while let [topic, low, high, after @ ..] = rest {
            let length = usize::from(u16::from_le_bytes([*low, *high]));
            let (payload, left) = after.split_at(length.min(after.len()));
            rest = left;
            let topic = TOPICS[usize::from(*topic) % TOPICS.len()];
            let said = host.take(topic, payload, &mut sink);
            for said in said.expect("this store takes all") {
                let _ = gateway.hears_command(&said.topic, &said.payload);
            }
            let _ = gateway.hears_state(topic, payload);
            let _ = gateway.hears_command(topic, payload);
        }
    },
    words: || {
        vec![
            "{\"online\":true,\"timestamp\":1}".to_owned(),
            "bdSeq".to_owned(),
        ]
    },
};

const TOPICS: [&str; 9] = [
    "spBv1.0/plant/NBIRTH/gw",
    "spBv1.0/plant/NDATA/gw",
    "spBv1.0/plant/NDEATH/gw",
    "spBv1.0/plant/DBIRTH/gw/box",
    "spBv1.0/plant/DDATA/gw/box",
    "spBv1.0/plant/NCMD/gw",
    "spBv1.0/plant/DCMD/gw/box",
    "spBv1.0/STATE/store",
    "other",
];

/// A store that takes numbers that rise, and nothing else; beyond `number` where one of a later schema is left out.
#[derive(Default)]
struct Memory {
    number: u64,
}

impl Sink for Memory {
    fn position(&mut self, _: &str) -> Result<u64, String> {
        Ok(self.number)
    }

    fn store(&mut self, _: &str, number: u64, records: &[Numbered]) -> Result<(), String> {
        assert!(records.is_sorted_by_key(|(n, ..)| *n), "out of order");
        for (_, line, record) in records {
            assert_eq!(from_line(line).as_ref(), Ok(record), "{line}");
        }
        self.number = number;
        Ok(())
    }
}
