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

/// The whole firmware cuts into chatter; an agent of MTConnect hears of it line by line.
#[test]
fn an_agent_hears_of_a_real_boxs_chatter() {
    let folder = tempfile::tempdir().unwrap();
    let mut the_box = rarma();
    the_box.args(["box", "--sim", "chatter-onset", "--listen", "127.0.0.1:0"]);
    let mut the_box = Ends(
        the_box
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap(),
    );
    let said = lines(the_box.0.stdout.take().unwrap());
    let port = until("the box's address", || {
        let said = said.lock().unwrap();
        let address = said
            .iter()
            .find_map(|line| line.split("127.0.0.1:").nth(1))?;
        let digits: String = address.chars().take_while(char::is_ascii_digit).collect();
        (!digits.is_empty()).then_some(digits)
    });
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
