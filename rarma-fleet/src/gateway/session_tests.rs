//! Births, numbers, deaths and commands, read with the generated types and not with our own.

use super::super::metrics::{Live, OfNode, box_alias};
use super::*;
use proptest::prelude::*;

fn session(primary: Option<&str>) -> Session {
    let devices = vec!["box-1".to_owned(), "box-2".to_owned()];
    Session::new("plant", "gw", devices, primary.map(str::to_owned))
}

fn decoded(out: &Outgoing) -> Payload {
    Payload::decode(out.payload.as_slice()).unwrap()
}

fn command(metrics: Vec<Metric>) -> Vec<u8> {
    Payload {
        timestamp: Some(1),
        metrics,
        ..Payload::default()
    }
    .encode_to_vec()
}

fn named(name: &str, value: metric::Value) -> Metric {
    let mut metric = Metric::new();
    metric.set_name(name.to_owned());
    metric.set_value(value);
    metric
}

#[test]
fn births_come_before_data_and_numbers_go_round() {
    let mut session = session(None);
    let will = session.connects(7, 1);
    assert!(will.at_least_once && will.topic == "spBv1.0/plant/NDEATH/gw");
    assert_eq!(decoded(&will).seq, None);
    assert_eq!(
        session.data(Vec::new(), 1),
        None,
        "no data before the birth"
    );
    let birth = session.birth(&[(OfNode::Version, Value::Text("1".into()))], 5);
    let payload = decoded(&birth);
    assert_eq!((payload.seq, birth.at_least_once), (Some(0), false));
    let bd = |p: &Payload| {
        p.metrics
            .iter()
            .find(|m| m.name.as_deref() == Some("bdSeq"))
            .unwrap()
            .value
            .clone()
    };
    assert_eq!(bd(&payload), bd(&decoded(&will)));
    let rebirth = payload
        .metrics
        .iter()
        .find(|m| m.name.as_deref() == Some(REBIRTH))
        .unwrap();
    assert_eq!(rebirth.alias, None);
    let born = session
        .device_birth(1, Live::default().births(1, 5), 5)
        .unwrap();
    assert_eq!(born.topic, "spBv1.0/plant/DBIRTH/gw/box-2");
    let numbers: Vec<u64> = (0..600)
        .map(|_| decoded(&session.data(Vec::new(), 6).unwrap()).seq.unwrap())
        .collect();
    assert_eq!(numbers[0], 2);
    assert!(numbers.windows(2).all(|w| w[1] == (w[0] + 1) % 256));
    session.leaves();
    assert_eq!(session.device_data(1, Vec::new(), 7), None);
    assert_eq!(session.device_birth(2, Vec::new(), 7), None, "no such box");
}

#[test]
fn a_primary_host_is_waited_for_and_its_old_will_is_not_believed() {
    let mut session = session(Some("store"));
    let _ = session.connects(0, 1);
    let topic = "spBv1.0/STATE/store";
    let mut says = |text: &str| session.hears_state(topic, text.as_bytes());
    assert_eq!(says(r#"{"online":false,"timestamp":5}"#), HostSays::Nothing);
    assert_eq!(says("OFFLINE"), HostSays::Nothing);
    assert_eq!(says(r#"{"online":true,"timestamp":100}"#), HostSays::Online);
    assert_eq!(
        says(r#"{"online":false,"timestamp":99}"#),
        HostSays::Nothing
    );
    assert_eq!(
        says(r#"{"online":false,"timestamp":100}"#),
        HostSays::Offline
    );
    assert!(!session.may_be_born());
    assert_eq!(
        session.hears_state("spBv1.0/STATE/other", br#"{"online":true,"timestamp":200}"#),
        HostSays::Nothing
    );
    assert!(!session.may_be_born());
}

#[test]
fn commands_are_read_by_name_and_by_alias() {
    let session = session(None);
    let speed = |m: Metric| session.hears_command("spBv1.0/plant/DCMD/gw/box-2", &command(vec![m]));
    let wanted = [Wanted::Write {
        device: "box-2".into(),
        metric: "Spindle/Speed".into(),
        value: Value::Number(6000.0),
    }];
    assert_eq!(
        speed(named("Spindle/Speed", metric::Value::FloatValue(6000.0))),
        wanted
    );
    let mut by_alias = Metric::new();
    by_alias.set_alias(box_alias(1, metrics::OfBox::Speed));
    by_alias.set_value(metric::Value::IntValue(6000));
    assert_eq!(speed(by_alias), wanted);
    let rebirth = command(vec![named(REBIRTH, metric::Value::BooleanValue(true))]);
    assert_eq!(
        session.hears_command("spBv1.0/plant/NCMD/gw", &rebirth),
        [Wanted::Rebirth]
    );
    let acknowledged = command(vec![
        named("Journal/Identity", metric::Value::StringValue("77".into())),
        named("Journal/Acknowledged", metric::Value::LongValue(12)),
    ]);
    let wanted = |number, come| {
        [Wanted::Acknowledged {
            identity: "77".into(),
            number,
            come,
        }]
    };
    assert_eq!(
        session.hears_command("spBv1.0/plant/NCMD/gw", &acknowledged),
        wanted(12, 12)
    );
    let beyond = command(vec![
        named("Journal/Identity", metric::Value::StringValue("77".into())),
        named("Journal/Acknowledged", metric::Value::LongValue(12)),
        named("Journal/Come", metric::Value::LongValue(900)),
    ]);
    assert_eq!(
        session.hears_command("spBv1.0/plant/NCMD/gw", &beyond),
        wanted(12, 900)
    );
    let tool = named("Spindle/Tool", metric::Value::StringValue("T12".into()));
    assert_eq!(
        speed(tool),
        [Wanted::Write {
            device: "box-2".into(),
            metric: "Spindle/Tool".into(),
            value: Value::Text("T12".into()),
        }]
    );
}

#[test]
fn foreign_topics_and_payloads_are_named_and_do_nothing() {
    let session = session(None);
    let ok = command(vec![named(
        "Spindle/Speed",
        metric::Value::DoubleValue(1.0),
    )]);
    for (topic, payload, says) in [
        ("spBv1.0/other/NCMD/gw", &ok[..], "not this gateway's"),
        ("spBv1.0/plant/NCMD/gw2", &ok, "not this gateway's"),
        ("spAv1.0/plant/DCMD/gw/box-1", &ok, "not this gateway's"),
        ("spBv1.0/plant/DCMD/gw/box-9", &ok, "no box of this name"),
        ("spBv1.0/plant/DCMD/gw/box-1", b"\xff\xff\xff", "no payload"),
        (
            "spBv1.0/plant/DCMD/gw/box-1",
            &command(vec![named(
                "Spindle/Speed",
                metric::Value::BooleanValue(true),
            )]),
            "no number",
        ),
        (
            "spBv1.0/plant/DCMD/gw/box-1",
            &command(vec![Metric::new()]),
            "without a name",
        ),
        (
            "spBv1.0/plant/NCMD/gw",
            &command(vec![named(
                "Node Control/Reboot",
                metric::Value::BooleanValue(true),
            )]),
            "no metric",
        ),
        (
            "spBv1.0/plant/NCMD/gw",
            &command(vec![named(
                "Journal/Acknowledged",
                metric::Value::LongValue(3),
            )]),
            "without Journal/Identity",
        ),
        (
            "spBv1.0/plant/NCMD/gw",
            &command(vec![
                named("Journal/Acknowledged", metric::Value::LongValue(3)),
                named("Journal/Come", metric::Value::LongValue(2)),
            ]),
            "Journal/Come",
        ),
    ] {
        let wanted = session.hears_command(topic, payload);
        assert!(
            matches!(&wanted[..], [Wanted::Foreign(why)] if why.contains(says)),
            "{topic}: {wanted:?}"
        );
    }
}

proptest! {
    #[test]
    fn any_bytes_on_any_topic_are_answered(topic in "\\PC{0,60}", bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut session = session(Some("store"));
        let _ = session.hears_state(&topic, &bytes);
        let _ = session.hears_state("spBv1.0/STATE/store", &bytes);
        for topic in [topic.as_str(), "spBv1.0/plant/NCMD/gw", "spBv1.0/plant/DCMD/gw/box-1"] {
            for wanted in session.hears_command(topic, &bytes) {
                if let Wanted::Foreign(why) = wanted {
                    prop_assert!(!why.contains('\n') && why.len() < 600);
                }
            }
        }
    }
}
