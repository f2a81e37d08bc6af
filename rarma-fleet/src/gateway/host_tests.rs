//! A host that hears what it should not, and too little, and twice.

use super::super::journal::Kept;
use super::super::metrics::data;
use super::super::session::Session;
use super::super::value::Value;
use super::*;
use proptest::prelude::*;

#[derive(Default)]
struct Memory {
    position: u64,
    numbers: Vec<u64>,
    broken: bool,
}

impl Sink for Memory {
    fn position(&mut self, _: &str) -> Result<u64, String> {
        Ok(self.position)
    }

    fn store(&mut self, _: &str, number: u64, records: &[Numbered]) -> Result<(), String> {
        if self.broken {
            return Err("the store is down".to_owned());
        }
        self.numbers.extend(records.iter().map(|(n, ..)| n));
        self.position = number;
        Ok(())
    }
}

const LINE: &str = r#"{"schema":1,"box":"box-1","session":9,"seq":17,"machine":"M1","time":"2026-03-01T12:00:00Z","kind":"alarm-called","body":{"f_hz":980.5,"zeta":-0.012}}"#;

fn kept(seq: u64, previous: u64) -> Kept {
    Kept {
        seq,
        previous,
        sender: "box-1".into(),
        line: LINE.to_owned(),
    }
}

fn metrics(of: &[Kept]) -> Vec<Metric> {
    let mut metrics = Vec::new();
    for (k, one) in of.iter().enumerate() {
        if k == 0 {
            metrics.push(data(
                node_alias(OfNode::Previous),
                Some(Value::Count(one.previous)),
                1,
                false,
            ));
        }
        metrics.push(data(
            node_alias(OfNode::Number),
            Some(Value::Count(one.seq)),
            1,
            false,
        ));
        metrics.push(data(
            node_alias(OfNode::Line),
            Some(Value::Text(one.line.clone())),
            1,
            true,
        ));
    }
    metrics
}

fn session() -> Session {
    let mut session = Session::new("plant", "gw", vec!["box-1".to_owned()], None);
    let _ = session.connects(3, 1);
    session
}

fn births(session: &mut Session, receiver: &mut Receiver, sink: &mut Memory) -> Vec<Said> {
    let birth = session.birth(&[(OfNode::Identity, Value::Text("77".into()))], 1);
    receiver.take(&birth.topic, &birth.payload, sink).unwrap()
}

#[test]
fn records_are_stored_once_in_order_and_acknowledged() {
    let (mut receiver, mut sink, mut session) =
        (Receiver::new("plant"), Memory::default(), session());
    sink.position = 2;
    let said = births(&mut session, &mut receiver, &mut sink);
    assert_eq!(
        session.hears_command(&said[0].topic, &said[0].payload),
        [super::super::session::Wanted::Acknowledged {
            identity: "77".into(),
            number: 2,
            come: 2,
        }]
    );
    // It has 1 and 2; 3 and 4 are new; a copy changes nothing.
    for _ in 0..2 {
        let out = session
            .data(
                metrics(&[kept(1, 0), kept(2, 1), kept(3, 2), kept(4, 3)]),
                2,
            )
            .unwrap();
        let said = receiver.take(&out.topic, &out.payload, &mut sink).unwrap();
        assert_eq!(said.len(), 1);
    }
    assert_eq!(sink.numbers, [3, 4]);
    // 5 is left out: nothing is taken, nothing acknowledged.
    let out = session.data(metrics(&[kept(6, 5)]), 2).unwrap();
    assert!(
        receiver
            .take(&out.topic, &out.payload, &mut sink)
            .unwrap()
            .is_empty()
    );
    assert_eq!(
        (
            sink.position,
            receiver.refused["records that leave some out"]
        ),
        (4, 1)
    );
}

#[test]
fn a_birth_that_never_comes_is_asked_for_and_nothing_is_taken_until_then() {
    let (mut receiver, mut sink, mut session) =
        (Receiver::new("plant"), Memory::default(), session());
    let _lost = session.birth(&[], 1);
    let mut asked = 0;
    for n in 1..50 {
        let out = session.data(metrics(&[kept(n, n - 1)]), 2).unwrap();
        asked += receiver
            .take(&out.topic, &out.payload, &mut sink)
            .unwrap()
            .len();
    }
    assert_eq!(
        (asked, sink.numbers.len()),
        (1, 0),
        "asked once, not at every message"
    );
    births(&mut session, &mut receiver, &mut sink);
    let out = session.data(metrics(&[kept(1, 0)]), 2).unwrap();
    let _ = receiver.take(&out.topic, &out.payload, &mut sink).unwrap();
    assert_eq!(sink.numbers, [1]);
}

#[test]
fn a_missing_message_asks_for_a_rebirth_and_an_old_will_is_no_death() {
    let (mut receiver, mut sink, mut session) =
        (Receiver::new("plant"), Memory::default(), session());
    births(&mut session, &mut receiver, &mut sink);
    let _ = session.connects(4, 1);
    births(&mut session, &mut receiver, &mut sink);
    let mut old = self::session();
    let will = old.connects(3, 1);
    let _ = receiver
        .take(&will.topic, &will.payload, &mut sink)
        .unwrap();
    let out = session.data(metrics(&[kept(1, 0)]), 2).unwrap();
    let _ = receiver.take(&out.topic, &out.payload, &mut sink).unwrap();
    assert_eq!(sink.numbers, [1]);
    let _lost = session.data(Vec::new(), 2);
    let out = session.data(metrics(&[kept(2, 1)]), 2).unwrap();
    let said = receiver.take(&out.topic, &out.payload, &mut sink).unwrap();
    assert_eq!(
        session.hears_command(&said[0].topic, &said[0].payload),
        [super::super::session::Wanted::Rebirth]
    );
    assert_eq!(sink.numbers, [1]);
}

/// It is not acknowledged, and told at once; what follows is stored all the same. The same again to a program that
/// knows the schema: it is stored, and then acknowledged.
#[test]
fn a_record_of_a_later_schema_stays_in_its_journal_and_holds_nothing_up() {
    let (mut receiver, mut sink, mut session) =
        (Receiver::new("plant"), Memory::default(), session());
    births(&mut session, &mut receiver, &mut sink);
    let future = |seq| Kept {
        line: LINE.replace("\"schema\":1", "\"schema\":9"),
        ..kept(seq, seq - 1)
    };
    let wrong = Kept {
        line: "{}".into(),
        ..kept(3, 2)
    };
    let says = |session: &mut Session, receiver: &mut Receiver, sink: &mut Memory, of: &[Kept]| {
        let out = session.data(metrics(of), 2).unwrap();
        let said = receiver.take(&out.topic, &out.payload, sink).unwrap();
        session.hears_command(&said[0].topic, &said[0].payload)
    };
    let acknowledged = |number, come| {
        [super::super::session::Wanted::Acknowledged {
            identity: "77".into(),
            number,
            come,
        }]
    };
    let first = [kept(1, 0), future(2), wrong, kept(4, 3)];
    assert_eq!(
        says(&mut session, &mut receiver, &mut sink, &first),
        acknowledged(1, 4)
    );
    assert_eq!((&sink.numbers[..], sink.position), (&[1, 4][..], 1));
    let told = std::mem::take(&mut receiver.notices);
    assert!(
        told.len() == 1 && told[0].contains("gateway gw: record 2 has schema 9"),
        "{told:?}"
    );
    // A copy, and more of both kinds: taken once, and not told again.
    for _ in 0..2 {
        let more = [future(5), kept(6, 5)];
        assert_eq!(
            says(&mut session, &mut receiver, &mut sink, &more),
            acknowledged(1, 6)
        );
    }
    assert_eq!((&sink.numbers[..], sink.position), (&[1, 4, 6][..], 1));
    assert!(receiver.notices.is_empty());
    assert_eq!(
        (
            receiver.refused["a record of a later schema"],
            receiver.refused["a record that is none"]
        ),
        (2, 1)
    );

    // The next program knows schema 9.
    let mut receiver = Receiver::new("plant");
    let said = births(&mut session, &mut receiver, &mut sink);
    assert_eq!(
        session.hears_command(&said[0].topic, &said[0].payload),
        acknowledged(1, 1)
    );
    let all: Vec<Kept> = (2..=6).map(|n| kept(n, n - 1)).collect();
    assert_eq!(
        says(&mut session, &mut receiver, &mut sink, &all),
        acknowledged(6, 6)
    );
    assert_eq!(sink.position, 6);
    assert!(sink.numbers.ends_with(&[2, 3, 4, 5, 6]));
}

#[test]
fn what_the_store_does_not_take_is_not_acknowledged() {
    let (mut receiver, mut sink, mut session) =
        (Receiver::new("plant"), Memory::default(), session());
    births(&mut session, &mut receiver, &mut sink);
    sink.broken = true;
    let out = session.data(metrics(&[kept(1, 0)]), 2).unwrap();
    assert!(receiver.take(&out.topic, &out.payload, &mut sink).is_err());
    sink.broken = false;
    let out = session.data(metrics(&[kept(1, 0)]), 2).unwrap();
    let _ = receiver.take(&out.topic, &out.payload, &mut sink).unwrap();
    assert_eq!(sink.numbers, [1]);
}

proptest! {
    /// Whatever messages are lost and doubled on the way, with the gateway sending again from what
    /// was acknowledged: every number is stored once and in order.
    #[test]
    fn lost_and_doubled_messages_lose_and_double_nothing(
        fates in proptest::collection::vec(0..4_u8, 1..120),
        count in 1_u64..40,
    ) {
        let (mut receiver, mut sink, mut session) = (Receiver::new("plant"), Memory::default(), session());
        births(&mut session, &mut receiver, &mut sink);
        let mut sent = 0;
        let mut fates = fates.into_iter().chain(std::iter::repeat(3));
        for _ in 0..2000 {
            if sink.position == count { break; }
            if sent >= count { sent = sink.position; }
            let next: Vec<Kept> = (sent + 1..=count.min(sent + 3)).map(|n| kept(n, n - 1)).collect();
            sent += next.len() as u64;
            let out = session.data(metrics(&next), 2).unwrap();
            let times = match fates.next() { Some(0) => 0, Some(1) => 2, _ => 1 };
            for _ in 0..times {
                for said in receiver.take(&out.topic, &out.payload, &mut sink).unwrap() {
                    for wanted in session.hears_command(&said.topic, &said.payload) {
                        if wanted == super::super::session::Wanted::Rebirth {
                            births(&mut session, &mut receiver, &mut sink);
                            sent = sink.position;
                        }
                    }
                }
            }
            // A rebirth that was asked for and answered long ago may be asked for again.
            for node in receiver.nodes.values_mut() { node.asked = None; }
        }
        prop_assert_eq!(&sink.numbers, &(1..=count).collect::<Vec<_>>());
    }

    #[test]
    fn any_bytes_on_any_topic_are_answered(topic in "\\PC{0,60}", bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let (mut receiver, mut sink) = (Receiver::new("plant"), Memory::default());
        for topic in [topic.as_str(), "spBv1.0/plant/NBIRTH/gw", "spBv1.0/plant/NDATA/gw", "spBv1.0/plant/XXX/gw", "spBv1.0/other/NDATA/gw"] {
            let _ = receiver.take(topic, &bytes, &mut sink).unwrap();
        }
        prop_assert!(sink.numbers.is_empty());
    }
}
