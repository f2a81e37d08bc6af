//! A second implementation (pysparkplug) reads what the gateway says, and writes a speed. The rules are
//! those of Sparkplug 3.0 for edge nodes; each assertion names its own.

use super::boxes::{Plan, SimulatedBox};
use super::broker::{Broker, is_there};
use super::gateway::{Child, Places};
use super::here::until;
use super::store::Store;
use rarma_fleet::record::Record;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

fn python() -> Option<PathBuf> {
    let found = std::env::var_os("RARMA_SPARKPLUG_PYTHON").map(PathBuf::from);
    if found.is_none() {
        assert!(
            std::env::var_os("RARMA_REQUIRE_BROKER").is_none(),
            "RARMA_SPARKPLUG_PYTHON does not name a Python with the packages of tests/plant/requirements.txt"
        );
        eprintln!("SKIPPED: RARMA_SPARKPLUG_PYTHON does not name a Python with pysparkplug");
    }
    found
}

fn second(python: &Path, broker: &Path, port: u16, what: &str, user: &str) -> Command {
    let mut command = Command::new(python);
    command
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/plant/sparkplug_reader.py"))
        .args([what, "localhost", &port.to_string()])
        .arg(broker.join("ca.pem"))
        .args([user, &format!("{user}-word")])
        .env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

#[test]
fn a_second_implementation_reads_births_data_and_deaths_and_writes_a_speed() {
    let Some(python) = python().filter(|_| is_there()) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("broker");
    let mut broker = Broker::start(&at);
    let stop = Arc::new(AtomicBool::new(false));
    let plan = Plan {
        seconds: 40_000,
        every_s: 1,
        row: 10,
        pause: Duration::from_millis(20),
    };
    // One of them dies before the others.
    let dies = Arc::new(AtomicBool::new(false));
    let mut boxes: Vec<SimulatedBox> = [&stop, &stop, &dies]
        .into_iter()
        .zip(0..)
        .map(|(stop, seed)| SimulatedBox::start(seed, plan, stop))
        .collect();
    let places = Places::make(folder.path(), &boxes, broker.port, 60.0, false);

    let mut reader = second(&python, &at, broker.port, "read", "screen")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines: Arc<Mutex<Vec<Value>>> = Arc::default();
    let (kept, out) = (Arc::clone(&lines), reader.stdout.take().unwrap());
    let reading = thread::spawn(move || {
        for line in BufReader::new(out).lines().map_while(Result::ok) {
            kept.lock()
                .unwrap()
                .push(serde_json::from_str(&line).unwrap());
        }
    });
    let count = |kind: &str| {
        lines
            .lock()
            .unwrap()
            .iter()
            .filter(|l| l["kind"] == kind)
            .count()
    };
    until("the reader", || count("HERE") > 0);

    // Without its primary host the gateway is not born.
    let child = Child::start(&places);
    thread::sleep(Duration::from_secs(2));
    assert_eq!(count("NBIRTH"), 0, "born without its primary host");
    let store = Store::start(folder.path(), broker.port, &stop);
    until("births", || count("DBIRTH") >= 3);
    until("records", || store.count() > 20);

    // A controller writes a speed; it reaches the box and comes back in its verdicts.
    let written = second(&python, &at, broker.port, "write", "controller")
        .args(["box-1", "Spindle/Speed", "6120"])
        .status()
        .unwrap();
    assert!(written.success());
    until("the speed at the box", || {
        *boxes[1].told_rpm.lock().unwrap() == Some(6120.0)
    });
    assert_eq!(*boxes[0].told_rpm.lock().unwrap(), None);
    // Nobody but the controller may, and nothing but speed and teeth.
    for (user, metric) in [
        ("screen", "Spindle/Speed"),
        ("controller", "Box/Arm"),
        ("controller", "ldbb.most"),
    ] {
        let written = second(&python, &at, broker.port, "write", user)
            .args(["box-2", metric, "1"])
            .status()
            .unwrap();
        assert!(written.success());
    }
    until("the speed at the screen", || {
        let lines = lines.lock().unwrap();
        let mut data = lines
            .iter()
            .filter(|l| l["kind"] == "DDATA" && l["device"] == "box-1");
        data.any(|l| {
            metric(l, "Spindle/Speed").is_some_and(|m| {
                m["value"]
                    .as_f64()
                    .is_some_and(|v| (v - 6120.0).abs() < 0.5)
            })
        })
    });
    assert_eq!(*boxes[2].told_rpm.lock().unwrap(), None);
    until("the refusal", || {
        child.said().contains("Box/Arm") && child.said().contains("ldbb.most")
    });

    // A tool goes into records, and to no box.
    let written = second(&python, &at, broker.port, "write", "controller")
        .args(["box-1", "Spindle/Tool", "T12"])
        .status()
        .unwrap();
    assert!(written.success());
    until("the tool at the screen", || {
        let lines = lines.lock().unwrap();
        let mut data = lines.iter().filter(|l| l["kind"] == "DDATA");
        data.any(|l| metric(l, "Spindle/Tool").is_some_and(|m| m["value"] == "T12"))
    });

    // A box dies; and a host asks for births: of those that are there.
    dies.store(true, Ordering::Relaxed);
    boxes[2].join();
    until("the box's death", || count("DDEATH") == 1);
    let asked = second(&python, &at, broker.port, "rebirth", "store")
        .status()
        .unwrap();
    assert!(asked.success());
    until("births that were asked for", || {
        count("NBIRTH") == 2 && count("DBIRTH") >= 5
    });

    // Killed: the broker tells its death; started again it goes on with the next bdSeq.
    let mut child = child;
    child.kill();
    until("the will", || count("NDEATH") == 1);
    let child = child.again(&places);
    until("births again", || count("DBIRTH") >= 7);
    thread::sleep(Duration::from_secs(2));
    child.end();
    until("its own death", || count("NDEATH") == 2);
    drop(reader.stdin.take());
    reader.wait().unwrap();
    reading.join().unwrap();
    stop.store(true, Ordering::Relaxed);
    for one in &mut boxes {
        one.join();
    }
    let (stored, receiver) = store.end();
    broker.kill();
    conforms(&lines.lock().unwrap());
    let with_tool = |(_, r): &(u64, Record)| r.tool.as_ref().is_some_and(|t| t.as_str() == "T12");
    let of: BTreeSet<&str> = stored
        .iter()
        .filter(|one| with_tool(one))
        .map(|(_, r)| r.id.sender.as_str())
        .collect();
    assert_eq!(of, BTreeSet::from(["box-1"]), "whose records have the tool");
    assert!(receiver.refused.is_empty(), "{:?}", receiver.refused);
}

fn metric<'a>(line: &'a Value, name: &str) -> Option<&'a Value> {
    line["metrics"]
        .as_array()?
        .iter()
        .find(|m| m["name"] == name)
}

fn conforms(lines: &[Value]) {
    let of = |kind: &'static str| lines.iter().filter(move |l| l["kind"] == kind);
    let bd = |line: &Value| {
        metric(line, "bdSeq")
            .and_then(|m| m["value"].as_i64())
            .unwrap()
    };
    let births: Vec<i64> = of("NBIRTH").map(bd).collect();
    // The second one was asked for: in the connection of the first.
    assert_eq!(births, [0, 0, 1], "topics-nbirth-bdseq-increment");
    assert_eq!(
        of("NDEATH").map(bd).collect::<Vec<_>>(),
        [0, 1],
        "payloads-ndeath-bdseq"
    );
    for death in of("NDEATH") {
        assert_eq!(death["seq"], Value::Null, "payloads-ndeath-seq");
        assert_eq!(
            death["metrics"].as_array().unwrap().len(),
            1,
            "topics-ndeath-payload"
        );
        assert_eq!(death["qos"], 1, "payloads-ndeath-will-message-qos");
    }
    let mut seq: Option<u64> = None;
    let mut born: BTreeSet<String> = BTreeSet::new();
    let mut aliases: BTreeMap<u64, String> = BTreeMap::new();
    let (mut historical, mut records) = (0, 0);
    for line in lines.iter().filter(|l| l["kind"] != "HERE") {
        let kind = line["kind"].as_str().unwrap();
        assert_eq!(
            line["retain"], false,
            "no message of an edge node is retained"
        );
        if kind == "NDEATH" {
            (seq, born) = (None, BTreeSet::new());
            continue;
        }
        assert_eq!(line["qos"], 0, "{kind}: births and data go at most once");
        assert!(
            line["timestamp"]
                .as_u64()
                .is_some_and(|t| t > 1_600_000_000_000),
            "{kind}: payload timestamp, UTC"
        );
        let number = line["seq"]
            .as_u64()
            .expect("payloads-sequence-num-always-included");
        if kind == "NBIRTH" {
            assert_eq!(number, 0, "payloads-nbirth-seq");
            aliases.clear();
            born.clear();
        } else {
            let before = seq.unwrap_or_else(|| panic!("{kind} before NBIRTH"));
            assert_eq!(
                number,
                (before + 1) % 256,
                "payloads-sequence-num-incrementing"
            );
        }
        seq = Some(number);
        let device = line["device"].as_str().unwrap_or_default().to_owned();
        let metrics = line["metrics"].as_array().unwrap();
        match kind {
            "NBIRTH" | "DBIRTH" => {
                for m in metrics {
                    assert!(
                        m["name"].is_string() && m["datatype"] != "UNKNOWN",
                        "payloads-name-birth-data-requirement: {m}"
                    );
                    let name = m["name"].as_str().unwrap();
                    if matches!(name, "bdSeq" | "Node Control/Rebirth") {
                        assert_eq!(m["alias"], Value::Null, "rebirth-name-aliases");
                    } else {
                        let alias = m["alias"].as_u64().unwrap();
                        let known = aliases.insert(alias, format!("{device}/{name}"));
                        assert_eq!(known, None, "payloads-alias-uniqueness: {alias}");
                    }
                }
                if kind == "NBIRTH" {
                    assert_eq!(
                        metric(line, "Node Control/Rebirth").unwrap()["value"],
                        false,
                        "payloads-nbirth-rebirth-req"
                    );
                } else {
                    born.insert(device);
                }
            }
            "DDATA" | "DDEATH" => {
                assert!(
                    born.contains(&device),
                    "{kind} of {device} before its DBIRTH"
                );
                if kind == "DDEATH" {
                    born.remove(&device);
                }
            }
            _ => {}
        }
        for m in metrics
            .iter()
            .filter(|_| kind == "NDATA" || kind == "DDATA")
        {
            assert!(
                aliases.contains_key(&m["alias"].as_u64().unwrap()),
                "an alias that was not born: {m}"
            );
            historical += usize::from(m["historical"] == true);
            records += usize::from(m["name"] == "Record/Line");
        }
    }
    assert!(
        records > 20 && historical > 0,
        "{records} records, {historical} historical"
    );
    assert_eq!(of("DBIRTH").count(), 7);
    let died: Vec<&Value> = of("DDEATH").map(|l| &l["device"]).collect();
    assert_eq!(died, ["box-2"]);
    println!(
        "{} messages, {records} records, {historical} historical metrics, all in order",
        lines.len()
    );
}
