//! `rarma gateway` with the whole box on simulated hardware, its own file, SHDR, and what is refused.
// Files of the tests.
#![allow(clippy::disallowed_methods)]
#![cfg(feature = "fleet")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

fn rarma() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rarma"))
}

struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn file(folder: &Path, boxes: &str, more: &str) -> std::path::PathBuf {
    let path = folder.join("gateway.toml");
    let head = "group = \"plant\"\nnode = \"gw\"\njournal = \"records.db\"\n";
    fs::write(&path, format!("{head}{more}{boxes}")).unwrap();
    path
}

/// Lines of a child's output, as they come.
fn lines(from: impl Read + Send + 'static) -> Arc<Mutex<Vec<String>>> {
    let lines: Arc<Mutex<Vec<String>>> = Arc::default();
    let kept = Arc::clone(&lines);
    thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            kept.lock().unwrap().push(line);
        }
    });
    lines
}

fn until<T>(what: &str, mut is: impl FnMut() -> Option<T>) -> T {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        if let Some(found) = is() {
            return found;
        }
        assert!(Instant::now() < until, "waited for: {what}");
        thread::sleep(Duration::from_millis(50));
    }
}

/// `rarma box` on a network, with these words besides; and its port.
fn box_of(words: &[&str]) -> (Ends, String) {
    let mut the_box = rarma();
    the_box.args(["box", "--listen", "127.0.0.1:0"]).args(words);
    let child = the_box.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut the_box = Ends(child.spawn().unwrap());
    let said = lines(the_box.0.stdout.take().unwrap());
    let port = until("the box's address", || {
        let said = said.lock().unwrap();
        let address = said
            .iter()
            .find_map(|line| line.split("127.0.0.1:").nth(1))?;
        let digits: String = address.chars().take_while(char::is_ascii_digit).collect();
        (!digits.is_empty()).then_some(digits)
    });
    (the_box, port)
}

/// The whole firmware cuts into chatter; an agent of MTConnect hears of it line by line.
#[test]
fn an_agent_hears_of_a_real_boxs_chatter() {
    let folder = tempfile::tempdir().unwrap();
    let (_box, port) = box_of(&["--sim", "chatter-onset"]);
    let boxes =
        format!("[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nport = \"tcp:127.0.0.1:{port}\"\n");
    let config = file(folder.path(), &boxes, "shdr = \"127.0.0.1:0\"\n");
    let mut gateway = rarma();
    gateway
        .arg("gateway")
        .arg(&config)
        .args(["--every", "0.2", "--json"]);
    let mut gateway = Ends(
        gateway
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let told = lines(gateway.0.stderr.take().unwrap());
    let standing = lines(gateway.0.stdout.take().unwrap());
    let address = until("the address of SHDR", || {
        told.lock()
            .unwrap()
            .iter()
            .find_map(|line| line.strip_prefix("SHDR at ").map(str::to_owned))
    });
    let mut agent = TcpStream::connect(&address).unwrap();
    agent.write_all(b"* PING\n").unwrap();
    let heard = lines(agent.try_clone().unwrap());
    let hears = |what: &str| {
        until(what, || {
            heard
                .lock()
                .unwrap()
                .iter()
                .any(|line| line.contains(what))
                .then_some(())
        })
    };
    hears("* PONG 10000");
    hears("|box-1_avail|AVAILABLE");
    hears("|box-1_chatter|NORMAL||||");
    hears("|box-1_chatter|FAULT|chatter|||");
    let records = until("records", || {
        let last = standing.lock().unwrap().last().cloned()?;
        let last: serde_json::Value = serde_json::from_str(&last).unwrap();
        last["last"].as_u64().filter(|&n| n > 2)
    });
    assert!(records > 2);
    let line = heard
        .lock()
        .unwrap()
        .iter()
        .find(|l| l.contains("FAULT"))
        .cloned()
        .unwrap();
    assert_eq!(line.matches('|').count(), 6, "{line}");
    assert!(
        line[..20].starts_with("20") && line.contains("Hz"),
        "{line}"
    );
}

/// A broker in clear on a port of its own; none where there is none.
fn broker(folder: &Path) -> Option<(Ends, u16)> {
    let program = ["/usr/sbin/mosquitto", "/usr/bin/mosquitto"]
        .into_iter()
        .find(|path| Path::new(path).exists());
    let Some(program) = program else {
        assert!(
            std::env::var_os("RARMA_REQUIRE_BROKER").is_none(),
            "mosquitto is missing (apt-get install mosquitto)"
        );
        eprintln!("SKIPPED: no broker; `apt-get install mosquitto`");
        return None;
    };
    let port = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = port.local_addr().unwrap().port();
    let config = folder.join("mosquitto.conf");
    fs::write(
        &config,
        format!("listener {port} 127.0.0.1\nallow_anonymous true\n"),
    )
    .unwrap();
    let mut child = Command::new(program);
    child.arg("-c").arg(&config);
    child.stdout(Stdio::null()).stderr(Stdio::null());
    let child = Ends(child.spawn().unwrap());
    until("the broker", || {
        TcpStream::connect(("127.0.0.1", port)).ok()
    });
    Some((child, port))
}

/// A controller of three messages, which shares no line with the gateway: CONNECT, and PUBLISH of a payload
/// with one metric.
struct Controller(TcpStream);

impl Controller {
    fn connect(port: u16) -> Self {
        let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
        // MQTT 3.1.1, a clean session, no heartbeat, the name "plc".
        let connect = b"\x10\x0f\x00\x04MQTT\x04\x02\x00\x00\x00\x03plc";
        socket.write_all(connect).unwrap();
        let mut taken = [0; 4];
        socket.read_exact(&mut taken).unwrap();
        assert_eq!(taken, [0x20, 2, 0, 0]);
        Self(socket)
    }

    fn write(&mut self, device: &str, metric: &str, value: f64) {
        // Protocol buffers: name (1), datatype (4) 10, a double, and the value (13).
        let mut inside = vec![0x0a, metric.len() as u8];
        inside.extend(metric.bytes());
        inside.extend([0x20, 10, 0x69]);
        inside.extend(value.to_le_bytes());
        // The payload's metric (2), behind the topic.
        let topic = format!("spBv1.0/plant/DCMD/gw/{device}");
        let mut packet = vec![0, topic.len() as u8];
        packet.extend(topic.bytes());
        packet.extend([0x12, inside.len() as u8]);
        packet.extend(inside);
        assert!(packet.len() < 128);
        let mut out = vec![0x30, packet.len() as u8];
        out.extend(packet);
        self.0.write_all(&out).unwrap();
    }
}

/// The whole firmware, on a network and with a key: what a controller writes counts there. docs/plant.md has the
/// times.
#[test]
fn a_controller_tells_a_box_with_a_key_its_speed_and_teeth() {
    let folder = tempfile::tempdir().unwrap();
    let Some((_broker, port)) = broker(folder.path()) else {
        return;
    };
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::write(at("box.key"), "5a".repeat(32)).unwrap();
    let quiet = "name = \"quiet\"\nabout = \"nothing is heard\"\nduration_s = 120\n";
    fs::write(at("quiet.toml"), quiet).unwrap();
    let (_box, box_port) = box_of(&["--sim", &at("quiet.toml"), "--key", &at("box.key")]);
    let box_port = format!("tcp:127.0.0.1:{box_port}");
    let boxes = format!(
        "[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nport = {box_port:?}\nkey = \"box.key\"\n"
    );
    let more = format!(
        "stretch_s = 1\n[broker]\nhost = \"127.0.0.1\"\nport = {port}\nin_clear = true\nacknowledge = \"broker\"\n"
    );
    let mut gateway = rarma();
    gateway
        .arg("gateway")
        .arg(file(folder.path(), &boxes, &more))
        .args(["--every", "0.2", "--json"]);
    let child = gateway.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut gateway = Ends(child.spawn().unwrap());
    let standing = lines(gateway.0.stdout.take().unwrap());
    let told = lines(gateway.0.stderr.take().unwrap());
    // Everything the box says, to somebody else.
    let mut decode = rarma();
    decode.args(["decode", &box_port, "--json"]);
    let mut decode = Ends(decode.stdout(Stdio::piped()).spawn().unwrap());
    let says = lines(decode.0.stdout.take().unwrap());
    let messages = |from: usize, kind: &str| -> Vec<(usize, serde_json::Value)> {
        let says = says.lock().unwrap();
        let of = says.iter().enumerate().skip(from).filter_map(|(k, line)| {
            let line: serde_json::Value = serde_json::from_str(line).ok()?;
            Some((k, line["message"].get(kind)?.clone()))
        });
        of.collect()
    };
    until("the broker's first acknowledgement", || {
        let last = standing.lock().unwrap().last().cloned()?;
        let last: serde_json::Value = serde_json::from_str(&last).unwrap();
        last["acknowledged"].as_u64().filter(|&n| n > 0)
    });

    let mut controller = Controller::connect(port);
    for rpm in [6120.0, 9000.0] {
        let written = Instant::now();
        controller.write("box-1", "Spindle/Speed", rpm);
        until("the speed in a verdict", || {
            let verdicts = messages(0, "Verdict");
            let spindle = &verdicts.last()?.1["spindle"];
            let is = spindle["hz"] == rpm / 60.0 && spindle["source"] == "Told";
            is.then_some(())
        });
        println!(
            "a speed counts after {:.2} s",
            written.elapsed().as_secs_f64()
        );
    }
    let before = says.lock().unwrap().len();
    let written = Instant::now();
    controller.write("box-1", "Spindle/Teeth", 6.0);
    until("a verdict of a monitor that was started anew", || {
        let (started, _) = *messages(before, "Started").first()?;
        messages(started, "Verdict").first().map(drop)
    });
    println!("teeth count after {:.2} s", written.elapsed().as_secs_f64());
    let mut asks = rarma();
    asks.args(["connect", &box_port, "--look", "--seconds", "1"]);
    let asked = asks.args(["--say", "read monitor.teeth"]).output().unwrap();
    let said = String::from_utf8(asked.stdout).unwrap();
    assert!(said.contains("monitor.teeth = 6"), "{said}");
    // Nobody was left in control.
    let status = until("a status", || messages(before, "Status").pop());
    assert_eq!(status.1["control"]["by"], 0, "{status:?}");
    let told = told.lock().unwrap();
    assert!(
        !told.iter().any(|line| line.contains("not told")),
        "{told:?}"
    );
}

/// What a box has said goes through gateway and broker into a store, once: the same from another
/// journal is known by its names, and a store that was away misses nothing.
#[test]
fn a_store_takes_what_gateways_send_once() {
    let folder = tempfile::tempdir().unwrap();
    let Some((_broker, port)) = broker(folder.path()) else {
        return;
    };
    let frames = folder.path().join("box.frames");
    let mut says = rarma();
    says.args(["box", "--sim", "chatter-onset", "--record"]);
    let said = says.arg(&frames).output().unwrap();
    // Chatter was called.
    assert_eq!(said.status.code(), Some(1), "{said:?}");
    let in_clear = format!("[broker]\nhost = \"127.0.0.1\"\nport = {port}\nin_clear = true\n");
    let host = folder.path().join("store.toml");
    fs::write(
        &host,
        format!("group = \"plant\"\nhost = \"store\"\n{in_clear}"),
    )
    .unwrap();
    let store = folder.path().join("plant.db");
    let receive = || {
        let mut receive = rarma();
        receive.args(["store", "receive", "--json"]).arg(&host);
        receive.arg("--store").arg(&store);
        let child = receive.stdout(Stdio::piped()).stderr(Stdio::null());
        Ends(child.spawn().unwrap())
    };
    // Ctrl-C, and what it says last.
    let end = |mut receiver: Ends| {
        let told = lines(receiver.0.stdout.take().unwrap());
        let pid = receiver.0.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-INT", &pid])
                .status()
                .unwrap()
                .success()
        );
        assert!(receiver.0.wait().unwrap().success());
        until("the last line", || {
            let last = told.lock().unwrap().last().cloned()?;
            serde_json::from_str::<serde_json::Value>(&last).ok()
        })
    };
    let boxes = format!(
        "[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nstarted = \"2026-03-01T12:00:00Z\"\nport = {:?}\n",
        frames.to_str().unwrap()
    );
    let primary = format!("{in_clear}primary_host = \"store\"\n");
    let config = file(folder.path(), &boxes, &primary);
    let gateway = |config: &Path| {
        let mut gateway = rarma();
        let child = gateway.arg("gateway").arg(config).stdout(Stdio::null());
        Ends(child.stderr(Stdio::null()).spawn().unwrap())
    };
    // The store is away at first: the gateway waits for it, and then ends with its recording.
    let mut first = gateway(&config);
    thread::sleep(Duration::from_millis(500));
    assert!(first.0.try_wait().unwrap().is_none(), "it waits");
    let receiver = receive();
    until("the gateway's end", || first.0.try_wait().unwrap());
    let taken = end(receiver);
    let new = taken["new"].as_u64().unwrap();
    assert!(
        new > 3 && taken["same"] == 0 && taken["refused"] == 0,
        "{taken}"
    );

    // A new journal, the same recording: every name is known.
    fs::remove_file(folder.path().join("records.db")).unwrap();
    let receiver = receive();
    let mut second = gateway(&config);
    until("the second gateway's end", || second.0.try_wait().unwrap());
    let again = end(receiver);
    assert_eq!((&again["new"], &again["same"]), (&0.into(), &new.into()));

    let mut show = rarma();
    show.args(["store", "export", "--store"]).arg(&store);
    let shown = String::from_utf8(show.output().unwrap().stdout).unwrap();
    assert_eq!(shown.lines().count() as u64, new);
    assert!(shown.contains("\"kind\":\"alarm-called\""), "{shown}");
}

#[test]
fn what_is_wrong_is_said_in_one_line_and_nothing_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let boxes = "[[box]]\nname = \"b\"\nmachine = \"M\"\nport = \"tcp:127.0.0.1:1\"\n";
    for (boxes, more, says) in [
        (boxes.to_owned(), "broker = 1\n", "line 4"),
        (
            boxes.to_owned(),
            "[broker]\nhost = \"h\"\nca = \"none.pem\"\n",
            "none.pem",
        ),
        (format!("{boxes}key = \"none.key\"\n"), "", "none.key"),
        (String::new(), "", "box"),
    ] {
        let config = file(folder.path(), &boxes, more);
        let output = rarma()
            .arg("gateway")
            .arg(&config)
            .arg("--check")
            .output()
            .unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(
            text.contains(says) && text.trim_end().lines().count() == 1,
            "{text}"
        );
        assert!(!folder.path().join("records.db").exists());
    }
}

/// What a program says on standard error until it has said `last` there, and a line on standard output.
fn says_until(mut command: Command, last: &str, and_stdout: bool) -> Vec<String> {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Ends(child.spawn().unwrap());
    let told = lines(child.0.stderr.take().unwrap());
    let printed = lines(child.0.stdout.take().unwrap());
    until(last, || {
        let there = told.lock().unwrap().iter().any(|line| line.contains(last));
        (there && (!and_stdout || !printed.lock().unwrap().is_empty())).then_some(())
    });
    let told = told.lock().unwrap();
    told.clone()
}

#[test]
fn quiet_leaves_out_notices_and_no_errors() {
    let folder = tempfile::tempdir().unwrap();
    // Nobody listens there.
    let port = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let boxes =
        format!("[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nport = \"tcp:127.0.0.1:{port}\"\n");
    let config = file(folder.path(), &boxes, "shdr = \"127.0.0.1:0\"\n");
    let host = folder.path().join("store.toml");
    let broker = format!("[broker]\nhost = \"localhost\"\nport = {port}\nin_clear = true\n");
    fs::write(
        &host,
        format!("group = \"plant\"\nhost = \"store\"\n{broker}"),
    )
    .unwrap();
    for quiet in [false, true] {
        let of = |words: &[&str]| {
            let mut command = rarma();
            command.args(words).args(quiet.then_some("--quiet"));
            command
        };
        let gateway = of(&["gateway", config.to_str().unwrap(), "--every", "0.2"]);
        let told = says_until(gateway, "it is tried again", true);
        let notices = told
            .iter()
            .filter(|line| line.starts_with("SHDR at "))
            .count();
        assert_eq!(notices, usize::from(!quiet), "{told:?}");
        assert!(
            told.iter().any(|line| line.starts_with("box-1: ")),
            "{told:?}"
        );

        let store = folder.path().join("a.db");
        let mut receive = of(&["store", "receive", host.to_str().unwrap()]);
        receive.arg("--store").arg(store);
        let told = says_until(receive, &format!("broker localhost:{port}: "), false);
        let notices = told
            .iter()
            .filter(|line| line.contains("records go to"))
            .count();
        assert_eq!(notices, usize::from(!quiet), "{told:?}");
    }
}
