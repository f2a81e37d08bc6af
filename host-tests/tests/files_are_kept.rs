//! Promise: no command spoils a file: not what it reads, not what another program records, not
//! what is there before it is known that the command works. Records grow; everything else is
//! replaced whole.
#![cfg(unix)]

use host_tests::every_command::{Inputs, parts};
use host_tests::files::Folder;
use host_tests::frames::Sender;
use host_tests::process::{Ended, Rarma};
use host_tests::rarma;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn program() -> Rarma {
    rarma!()
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a name")
}

fn assert_kept(path: &Path, before: &[u8]) {
    assert_eq!(fs::read(path).expect("the file"), before, "{}", text(path));
}

/// A record of one run of a box, so many blocks long.
fn frames(session: u32, blocks: u64) -> Vec<u8> {
    let mut sender = Sender::new(session);
    let mut bytes = sender.started(8000.0);
    for k in 0..blocks {
        bytes.extend(sender.raw(120 * k, &[k as i16; 120]));
    }
    bytes
}

const QUIET: &[u8] = b"name = \"quiet\"\nabout = \"waits\"\nduration_s = 60.0\nhears = \"quiet\"\n";
const SHORT: &[u8] = b"name = \"short\"\nabout = \"streams\"\nduration_s = 0.5\nhears = \"quiet\"\nhost = [{ at_s = 0.05, say = \"stream 0.4\" }]\n";

#[test]
fn nothing_is_written_onto_what_is_read() {
    let inputs = Inputs::new(program());
    let folder = Folder::default();
    let record = folder.file("k.frames", &frames(1, 10));
    let scenario = folder.file("s.toml", SHORT);
    let [hard, soft, far] = ["hard", "soft", "far"].map(|name| folder.path().join(name));
    fs::hard_link(&record, &hard).expect("a hard link");
    symlink("k.frames", &soft).expect("a link");
    symlink("soft", &far).expect("a link to a link");
    let bar = inputs.at("bar").join("run-01.csv");
    let table = fs::read_dir(inputs.at("bar"))
        .expect("a folder")
        .filter_map(Result::ok);
    let table = table.map(|entry| entry.path());
    let table = table
        .into_iter()
        .find(|p| p.extension().is_some_and(|e| e == "csv"));
    fs::copy(table.expect("a table"), &bar).expect("a copy");
    let of = |name: &str| inputs.at(name).display().to_string();
    let (k, s) = (text(&record), text(&scenario));
    let tool = of("tool.uff");
    let (cers, signals, setup) = (of("cers"), of("cers/signals.wav"), of("cers/record.toml"));
    let below = format!(
        "{}/../{}/k.frames",
        text(folder.path()),
        folder
            .path()
            .file_name()
            .and_then(|n| n.to_str())
            .expect("a name")
    );
    let cases: Vec<(Vec<&str>, &Path)> = vec![
        (vec!["decode", k, "--wav", k], &record),
        (vec!["decode", k, "--wav", text(&hard)], &record),
        (vec!["decode", k, "--wav", text(&soft)], &record),
        (vec!["decode", text(&far), "--wav", text(&hard)], &record),
        (vec!["decode", k, "--wav", &below], &record),
        (vec!["connect", k, "--record", k], &record),
        (vec!["connect", k, "--record", text(&soft)], &record),
        (vec!["box", "--sim", s, "--record", s], &scenario),
        (vec!["simulate", s, "--out", s], &scenario),
        (vec!["simulate", s, "--truth", s], &scenario),
        (vec!["choose-order", s, "--settings", s], &scenario),
        (vec!["els", "model", s, "--uff", s], &scenario),
        (
            vec!["els", "limit", &tool, "--uff", &tool],
            Path::new(&tool),
        ),
        (
            vec!["ldbb", "analyse", text(&bar), "--save", text(&bar)],
            &bar,
        ),
        (
            vec!["cers", "analyse", &cers, "--csv", &signals],
            Path::new(&signals),
        ),
        (
            vec!["cers", "analyse", &cers, "--uff", &setup],
            Path::new(&setup),
        ),
    ];
    for (words, file) in cases {
        let before = fs::read(file).expect("the input");
        let ended = program().run(&words);
        assert_eq!(ended.code, Some(2), "{words:?}: {ended:?}");
        assert!(
            ended.stderr.contains("it is what is read"),
            "{words:?}: {ended:?}"
        );
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        assert_kept(file, &before);
    }
    // Two outputs in one file are none.
    let out = folder.path().join("out");
    let ended = program().run([
        "simulate",
        "turning-980",
        "--out",
        text(&out),
        "--truth",
        text(&out),
    ]);
    assert_eq!(ended.code, Some(2), "{ended:?}");
    assert!(ended.stderr.contains("--out writes it, too"), "{ended:?}");
    assert!(!out.exists());
}

#[test]
fn a_command_that_does_not_come_to_work_touches_no_record() {
    let folder = Folder::default();
    let before = frames(1, 10);
    let record = folder.file("k.frames", &before);
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").to_string();
    let nobody = {
        let free = TcpListener::bind("127.0.0.1:0").expect("a port");
        format!("tcp:{}", free.local_addr().expect("an address"))
    };
    let scenario = folder.file("s.toml", SHORT);
    let broken = folder.file("b.toml", b"name = 3\n");
    let new = folder.path().join("new.frames");
    for record in [&record, &new] {
        let r = text(record);
        for words in [
            vec![
                "box",
                "--sim",
                text(&scenario),
                "--listen",
                &port,
                "--record",
                r,
            ],
            vec!["box", "--sim", text(&broken), "--record", r],
            vec!["box", "--sim", "no-such-scenario", "--record", r],
            vec!["connect", &nobody, "--record", r],
            vec!["connect", "/dev/no-such-port", "--record", r],
            vec!["connect", &nobody, "--say", "nonsense", "--record", r],
        ] {
            let ended = program().run(&words);
            assert!(matches!(ended.code, Some(2 | 3)), "{words:?}: {ended:?}");
        }
    }
    assert_kept(&record, &before);
    assert!(!new.exists());
    // Nor is a file that is no record taken for one.
    let song = folder.file("song.wav", &[7; 5000]);
    let ended = program().run(["box", "--sim", text(&scenario), "--record", text(&song)]);
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert!(ended.stderr.contains("no record of a box"), "{ended:?}");
    assert_kept(&song, &[7; 5000]);
}

#[test]
fn a_record_is_appended_to_by_session() {
    let folder = Folder::default();
    let scenario = folder.file("s.toml", SHORT);
    let record = folder.path().join("k.frames");
    let box_runs = |seed: &str| -> Vec<u8> {
        let ended = program().run([
            "box",
            "--sim",
            text(&scenario),
            "--seed",
            seed,
            "--record",
            text(&record),
        ]);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        fs::read(&record).expect("a record")
    };
    let first = box_runs("1");
    let both = box_runs("2");
    assert_eq!(both[..first.len()], first);
    assert!((first.len() as f64 / (both.len() - first.len()) as f64 - 1.0).abs() < 0.05);
    let ended = program().on("decode", &record, "--json");
    assert!(
        ended.stderr.contains("0 broken, 0 missing, of 2 runs"),
        "{ended:?}"
    );
    // One that was cut short within a frame: that frame is lost, and no other.
    fs::write(&record, &both[..both.len() - 5]).expect("a record");
    let cut = fs::read(&record).expect("a record");
    let all = box_runs("3");
    assert_eq!(all[..cut.len()], cut);
    let ended = program().on("decode", &record, "--json");
    assert!(
        ended.stderr.contains("1 broken, 0 missing, of 3 runs"),
        "{ended:?}"
    );
}

struct Served {
    child: Child,
    address: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A box on a socket that records.
fn serve(scenario: &Path, record: &Path) -> Served {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(["box", "--sim", text(scenario), "--listen", "127.0.0.1:0"])
        .args(["--record", text(record)])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    let mut line = String::new();
    let out = child.stdout.take().expect("its output");
    BufReader::new(out).read_line(&mut line).expect("a line");
    let address = line.trim().rsplit(' ').next().expect("an address");
    Served {
        address: address.to_owned(),
        child,
    }
}

/// Waits for a file of at least so many bytes.
fn grown(path: &Path, least: u64) {
    let begun = Instant::now();
    while fs::metadata(path).map_or(0, |meta| meta.len()) < least {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "{} does not grow",
            text(path)
        );
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_record_in_progress_is_nobody_elses() {
    let folder = Folder::default();
    let scenario = folder.file("quiet.toml", QUIET);
    let record = folder.path().join("live.frames");
    let served = serve(&scenario, &record);
    grown(&record, 200);
    let short = folder.file("s.toml", SHORT);
    let other = folder.file("other.frames", &frames(1, 10));
    let link = folder.path().join("link");
    symlink("live.frames", &link).expect("a link");
    let inode = fs::metadata(&record).expect("the record").ino();
    let port = format!("tcp:{}", served.address);
    for name in [&record, &link] {
        let r = text(name);
        for words in [
            vec!["box", "--sim", text(&short), "--record", r],
            vec!["connect", &port, "--seconds", "1", "--record", r],
            vec!["decode", text(&other), "--wav", r],
            vec!["simulate", "turning-980", "--out", r],
        ] {
            let ended = program().run(&words);
            assert_eq!(ended.code, Some(4), "{words:?}: {ended:?}");
            assert!(
                ended
                    .stderr
                    .contains("another program is recording into it"),
                "{ended:?}"
            );
        }
    }
    assert_eq!(fs::metadata(&record).expect("the record").ino(), inode);
    // It may be read while it grows.
    let ended = program().on("decode", &record, "--json");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    // With its recorder the lock is gone.
    drop(served);
    let ended = program().run(["box", "--sim", text(&short), "--record", text(&record)]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
}

#[test]
fn a_recorder_that_is_killed_loses_no_whole_frame() {
    let folder = Folder::default();
    let record = folder.path().join("k.frames");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = format!("tcp:{}", listener.local_addr().expect("an address"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args([
            "connect",
            &port,
            "--look",
            "--json",
            "--record",
            text(&record),
        ])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("a program");
    let (mut socket, _): (TcpStream, _) = listener.accept().expect("a connection");
    let sent = frames(1, 50);
    // All of it, and half a frame more.
    socket.write_all(&sent).expect("a socket");
    socket.write_all(&frames(1, 1)[..10]).expect("a socket");
    grown(&record, sent.len() as u64);
    child.kill().expect("a program");
    child.wait().expect("its end");
    assert_eq!(fs::read(&record).expect("a record")[..sent.len()], sent);
    let wav = folder.path().join("k.wav");
    let ended = program().on("decode", &record, &format!("--json --wav {}", text(&wav)));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let samples = hound::WavReader::open(&wav).expect("a WAV").len();
    assert_eq!(samples, 50 * 120);
}

#[test]
fn a_file_is_replaced_whole_and_keeps_its_rights_and_links() {
    let folder = Folder::default();
    let old = folder.file("old.json", b"old");
    let link = folder.path().join("link.json");
    let other = folder.path().join("other.json");
    symlink("old.json", &link).expect("a link");
    fs::hard_link(&old, &other).expect("a hard link");
    fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).expect("rights");
    let written =
        |to: &Path| -> Ended { program().run(["simulate", "turning-980", "--truth", text(to)]) };
    assert_eq!(written(&link).code, Some(0));
    let truth = fs::read(&old).expect("the file");
    assert!(truth.len() > 1000);
    assert!(fs::symlink_metadata(&link).expect("the link").is_symlink());
    let mode = fs::metadata(&old).expect("the file").permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    // What another name held stays: the file is a new one.
    assert_kept(&other, b"old");
    // A new file has the rights that any has.
    let (new, plain) = (folder.path().join("new.json"), folder.file("plain", b""));
    assert_eq!(written(&new).code, Some(0));
    let mode = |path: &Path| fs::metadata(path).expect("the file").permissions().mode();
    assert_eq!(mode(&new), mode(&plain));
    // Killed in the middle: the old one stands.
    let sound = folder.file("old.wav", b"old");
    let mut child = Command::new(env!("CARGO_BIN_EXE_rarma-under-test"))
        .args(["simulate", "slender-bar", "--out", text(&sound)])
        .stdout(Stdio::null())
        .spawn()
        .expect("a program");
    let begun = Instant::now();
    while parts(folder.path()).is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("a program");
    child.wait().expect("its end");
    assert_kept(&sound, b"old");
    // Folders that are not there, and names that are folders, are told at once.
    for (name, says) in [("no/such/x.json", "no such folder"), ("", "is a folder")] {
        let ended = written(&folder.path().join(name));
        assert_eq!(ended.code, Some(4), "{ended:?}");
        assert!(ended.stderr.contains(says), "{ended:?}");
    }
}

#[test]
fn a_report_that_does_not_fit_leaves_the_old_one() {
    let inputs = Inputs::new(program());
    let folder = Folder::default();
    let sound = inputs.at("sound.wav");
    let page = folder.path().join("index.html");
    let report = |limit: &str| {
        let script = format!("trap '' XFSZ; ulimit -f {limit}; exec \"$0\" \"$@\"");
        let status = Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_rarma-under-test")])
            .args(["monitor", text(&sound), "--report", text(folder.path())])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .expect("a shell");
        status.code()
    };
    assert_eq!(report("unlimited"), Some(0));
    let good = fs::read(&page).expect("a page");
    assert!(good.ends_with(b"</html>\n") || good.len() > 10_000);
    // Room for a quarter of it, in blocks of 512 bytes.
    let quarter = (good.len() / 2048).to_string();
    assert_eq!(report(&quarter), Some(4));
    assert_kept(&page, &good);
    assert!(parts(folder.path()).is_empty());
}
