//! What a gateway, a host and a broker agree on beside the usual: a later schema, a broker that acknowledges,
//! a host that is said to be away, certificates on both sides, a store that is killed.

use super::boxes::{Plan, SimulatedBox};
use super::broker::{Broker, Wire, authority, is_there, signed};
use super::here::{Here, until};
use super::store::{Killed, Store};
use rarma_fleet::gateway::journal::{Entry, Journal, Limits};
use rumqttc::{Client, Event, MqttOptions, Packet, QoS, Transport};
use std::collections::BTreeSet;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

const PLANTS: &str = "ca = \"broker/ca.pem\"\n";

fn boxes(count: u64, seconds: u64, stop: &Arc<AtomicBool>) -> Vec<SimulatedBox> {
    let plan = Plan {
        seconds,
        every_s: 1,
        row: 10,
        pause: Duration::from_millis(10),
    };
    (0..count)
        .map(|seed| SimulatedBox::start(seed, plan, stop))
        .collect()
}

fn ports(boxes: &[SimulatedBox]) -> Vec<u16> {
    boxes.iter().map(|b| b.port).collect()
}

/// 5999 records of a schema that the store knows and, as the tenth, one that it does not.
#[test]
fn a_record_of_a_later_schema_stays_in_the_journal_and_holds_no_other_up() {
    if !is_there() {
        return;
    }
    const COUNT: u64 = 6000;
    let folder = tempfile::tempdir().unwrap();
    let broker = Broker::start(&folder.path().join("broker"));
    let journal = || Journal::open(&folder.path().join("records.db"), Limits::default()).unwrap();
    let line = |seq: u64| {
        let schema = if seq == 10 { 2 } else { 1 };
        format!(
            r#"{{"schema":{schema},"box":"box-1","session":9,"seq":{seq},"machine":"M1","time":"2026-03-01T12:00:00Z","kind":"alarm-called","body":{{"f_hz":980.5,"zeta":-0.012}}}}"#
        )
    };
    let entries: Vec<Entry> = (1..=COUNT)
        .map(|seq| Entry {
            sender: "box-1".to_owned(),
            verdict: false,
            line: line(seq),
        })
        .collect();
    journal().append(&entries, &[]).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let store = Store::start(folder.path(), broker.port, &stop);
    let told = format!("{PLANTS}primary_host = \"store\"\n");
    let gateway = Here::start(folder.path(), broker.port, &told, &[1]);
    until("all that is known at the store", || {
        store.count() as u64 == COUNT - 1
    });
    // Beyond the time after which a silent store is sent everything again.
    thread::sleep(Duration::from_secs(6));
    let standing = gateway.standing();
    assert_eq!((standing.last, standing.acknowledged), (COUNT, 9));
    for said in [gateway.said(), store.said()] {
        assert_eq!(said.matches("record 10").count(), 1, "{said}");
    }
    gateway.stop();
    stop.store(true, Ordering::Relaxed);
    let (stored, receiver) = store.end();
    let numbers: Vec<u64> = stored.iter().map(|(n, _)| *n).collect();
    let all: Vec<u64> = (1..=COUNT).filter(|&n| n != 10).collect();
    assert_eq!(numbers, all, "each once and in order");
    assert_eq!(receiver.refused["a record of a later schema"], 1);
    let kept = journal().after(9, COUNT as usize).unwrap();
    assert_eq!(kept.len() as u64, COUNT - 9);
}

/// A host that is another program, which acknowledges nothing: the broker does, through a cut of the network.
#[test]
fn a_broker_that_acknowledges_has_each_record_and_hands_it_on() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let broker = Broker::start(&folder.path().join("broker"));
    let wire = Wire::to(broker.port);
    let stop = Arc::new(AtomicBool::new(false));
    // It may read and not write: what it says, STATE included, the broker drops.
    let other = Store::start_as("screen", folder.path(), broker.port, &stop);
    thread::sleep(Duration::from_secs(1));
    let mut boxes = boxes(2, 6000, &stop);
    let told = format!("{PLANTS}acknowledge = \"broker\"\n");
    let gateway = Here::start(folder.path(), wire.port, &told, &ports(&boxes));
    let at = |s| move |one: &SimulatedBox| one.at_s.load(Ordering::Relaxed) >= s;
    until("half of it", || boxes.iter().all(at(3000)));
    wire.cut(true);
    thread::sleep(Duration::from_secs(1));
    let before = gateway.standing();
    assert!(before.acknowledged < before.last, "{before:?}");
    wire.cut(false);
    until("the end", || {
        boxes.iter().all(at(6000)) && gateway.is_done()
    });
    let last = gateway.standing().last;
    until("the last record at the host", || {
        other.count() as u64 >= last
    });
    gateway.stop();
    stop.store(true, Ordering::Relaxed);
    boxes.iter_mut().for_each(SimulatedBox::join);
    let (stored, receiver) = other.end();
    let numbers: Vec<u64> = stored.iter().map(|(n, _)| *n).collect();
    assert_eq!(numbers, (1..=last).collect::<Vec<_>>());
    println!(
        "acknowledged by the broker: {last} records, each once and in order; {} came again",
        receiver.repeated
    );
}

/// Sparkplug 3.0, message-flow-hid-sparkplug-state-message-delivered.
#[test]
fn a_host_that_is_said_to_be_away_says_at_once_that_it_is_there() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("broker");
    let broker = Broker::start(&at);
    let stop = Arc::new(AtomicBool::new(false));
    let mut options = MqttOptions::new("somebody", "localhost", broker.port);
    options
        .set_credentials("store", "store-word")
        .set_transport(Transport::tls(
            fs::read(at.join("ca.pem")).unwrap(),
            None,
            None,
        ));
    let (client, mut connection) = Client::new(options, 10);
    let topic = "spBv1.0/STATE/store";
    client.subscribe(topic, QoS::AtLeastOnce).unwrap();
    let mut hears = |online: bool| {
        let until = Instant::now() + Duration::from_secs(10);
        let says = format!(r#"{{"online":{online},"#);
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let event = connection.recv_timeout(left).expect(&says).expect(&says);
            if let Event::Incoming(Packet::Publish(publish)) = event
                && publish.payload.starts_with(says.as_bytes())
            {
                return;
            }
        }
    };
    let store = Store::start(folder.path(), broker.port, &stop);
    hears(true);
    let away = r#"{"online":false,"timestamp":1}"#;
    client.publish(topic, QoS::AtLeastOnce, true, away).unwrap();
    hears(false);
    hears(true);
    stop.store(true, Ordering::Relaxed);
    hears(false);
    let (_, receiver) = store.end();
    assert!(receiver.refused.is_empty(), "{:?}", receiver.refused);
}

#[test]
fn a_broker_of_somebody_else_gets_nothing() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let broker = Broker::start(&folder.path().join("broker"));
    // Of another name, and of the same one.
    for (name, reason) in [("other", "UnknownIssuer"), ("plant", "BadSignature")] {
        let home = folder.path().join(name);
        fs::create_dir(&home).unwrap();
        authority(&home, name);
        let told = format!("ca = \"{name}/ca.pem\"\nacknowledge = \"broker\"\n");
        let gateway = Here::start(folder.path(), broker.port, &told, &[1]);
        let line = format!("broker localhost:{}: ", broker.port);
        until("the refusal", || {
            let said = gateway.said();
            said.contains(&line) && said.contains(reason)
        });
        gateway.stop();
    }
}

#[test]
fn a_broker_that_wants_a_certificate_gets_it_and_nobody_gets_in_without() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("broker");
    let broker = Broker::start_with(&at, "require_certificate true\n");
    signed(&at, "own", "gateway", "extendedKeyUsage=clientAuth\n");
    let stop = Arc::new(AtomicBool::new(false));
    let mut boxes = boxes(1, 100, &stop);
    let told = format!("{PLANTS}acknowledge = \"broker\"\n");
    let gateway = Here::start(folder.path(), broker.port, &told, &ports(&boxes));
    until("the refusal", || {
        gateway
            .said()
            .contains(&format!("broker localhost:{}: ", broker.port))
    });
    until("records", || gateway.standing().last > 5);
    assert_eq!(gateway.standing().acknowledged, 0, "{}", gateway.said());
    gateway.stop();
    let own = "certificate = \"broker/own.pem\"\ncertificate_key = \"broker/own.key\"\n";
    let gateway = Here::start(folder.path(), broker.port, &format!("{told}{own}"), &[1]);
    until("the broker's acknowledgement", || gateway.is_done());
    gateway.stop();
    stop.store(true, Ordering::Relaxed);
    boxes.iter_mut().for_each(SimulatedBox::join);
}

/// The store's own process, SIGKILL in the middle of taking records in, five times.
#[test]
fn a_store_that_is_killed_has_each_record_once() {
    if !is_there() {
        return;
    }
    const SECONDS: u64 = 12_000;
    let folder = tempfile::tempdir().unwrap();
    let broker = Broker::start(&folder.path().join("broker"));
    let stop = Arc::new(AtomicBool::new(false));
    let mut boxes = boxes(4, SECONDS, &stop);
    let told = format!("{PLANTS}primary_host = \"store\"\n");
    let mut store = Killed::start(folder.path(), broker.port);
    let gateway = Here::start(folder.path(), broker.port, &told, &ports(&boxes));
    for kill in 1..=5 {
        let at = |one: &SimulatedBox| one.at_s.load(Ordering::Relaxed) >= kill * SECONDS / 6;
        until("boxes", || boxes.iter().all(at));
        store.kill();
        let standing = gateway.standing();
        assert!(standing.acknowledged > 0, "{standing:?}");
        store = Killed::start(folder.path(), broker.port);
    }
    let done = |one: &SimulatedBox| one.at_s.load(Ordering::Relaxed) >= SECONDS;
    until("the end", || boxes.iter().all(done) && gateway.is_done());
    let last = gateway.standing().last;
    gateway.stop();
    stop.store(true, Ordering::Relaxed);
    boxes.iter_mut().for_each(SimulatedBox::join);
    let said = store.end();
    let lines = store.lines();
    let kept = Journal::open(&folder.path().join("records.db"), Limits::default())
        .unwrap()
        .after(0, 1 << 20)
        .unwrap();
    let sent: BTreeSet<String> = kept.into_iter().map(|k| k.line).collect();
    let there: BTreeSet<String> = lines.iter().cloned().collect();
    assert_eq!((lines.len(), there.len()), (last as usize, last as usize));
    assert_eq!(there, sent);
    println!("the store killed 5 times: {last} records, each once; in its last run {said}");
}
