//! Promise: on a terminal `monitor -` and `connect` have a live screen; what is typed to a box is
//! answered; however it ends, the terminal is as it was, nothing recorded is lost, and the exit code
//! says what happened.
//!
//! Seen through tmux. Without it these are skipped, loudly; `RARMA_REQUIRE_TMUX=1` makes that a
//! failure.

use host_tests::files::Folder;
use host_tests::process::Rarma;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use xtask::process::find_program;
use xtask::tmux::Terminal;

const PATIENCE: Duration = Duration::from_secs(30);
const KEY: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff\n";

const PROGRAM: &str = env!("CARGO_BIN_EXE_rarma-under-test");

fn program() -> Rarma {
    Rarma::at(PROGRAM)
}

/// A terminal, or none where that is allowed.
fn terminal(test: &str, size: (u16, u16)) -> Option<Terminal> {
    if find_program("tmux").is_none() {
        let required = std::env::var("RARMA_REQUIRE_TMUX").is_ok_and(|value| value == "1");
        assert!(
            !required,
            "{test}: no tmux, and skipping is not allowed here"
        );
        eprintln!("SKIPPED: {test}: no tmux on this machine");
        return None;
    }
    Some(Terminal::open(size).expect("a terminal"))
}

/// A command line that tells the exit code as `code=N`, and whether the modes of the terminal are
/// what they were: `modes=same`. (What is typed is to be seen, too, but not so.)
fn told(line: &str) -> String {
    format!("m=$(stty -g); {line}; echo code=$?; [ \"$m\" = \"$(stty -g)\" ] && echo modes'=same'")
}

fn assert_ended(terminal: &Terminal, code: u8) -> String {
    let code = format!("code={code}\n");
    let waited = terminal.wait_until(PATIENCE, &code, |seen| {
        seen.contains(&code) && seen.contains("modes=same")
    });
    let seen = waited.expect("ended, its terminal as it was");
    assert!(terminal.is_for_lines().expect("there"), "{seen}");
    terminal.all_seen().expect("there")
}

/// A simulated box on a socket.
struct Served {
    child: Child,
    address: String,
}

impl Served {
    fn start(sim: &str, key: &Path) -> Self {
        let mut child = Command::new(PROGRAM)
            .args(["box", "--sim", sim, "--listen", "127.0.0.1:0", "--key"])
            .arg(key)
            .stdout(Stdio::piped())
            .spawn()
            .expect("a box");
        let mut line = String::new();
        let output = child.stdout.take().expect("its output");
        BufReader::new(output).read_line(&mut line).expect("a line");
        let address = line
            .trim()
            .rsplit(' ')
            .next()
            .expect("an address")
            .to_owned();
        Self { child, address }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.child
            .kill()
            .and_then(|()| self.child.wait())
            .expect("an end");
    }
}

/// A box that listens to noise for as long as any test takes.
const QUIET_BOX: &str =
    "name = \"quiet\"\nabout = \"a box that hears noise\"\nduration_s = 300.0\nhears = \"quiet\"\n";

#[test]
fn ten_commands_are_typed_to_a_box_and_answered() {
    let test = "ten commands";
    let Some(terminal) = terminal(test, (140, 34)) else {
        return;
    };
    let folder = Folder::default();
    let key = folder.file("box.key", KEY.as_bytes());
    let sim = folder.file("quiet.toml", QUIET_BOX.as_bytes());
    let served = Served::start(&sim.display().to_string(), &key);
    let rarma = PROGRAM;
    let line = format!(
        "{rarma} connect tcp:{} --key {}",
        served.address,
        key.display()
    );
    terminal.enter(&told(&line)).expect("typed");
    terminal
        .wait_for("this host is in control", PATIENCE)
        .expect("in control");
    for (said, answer) in [
        ("identify", "firmware"),
        ("status", "done"),
        ("read monitor.teeth", "monitor.teeth = 0"),
        ("set monitor.teeth 6", "monitor.teeth = 6"),
        ("set monitor.threshold 9", "refused:"),
        ("fly", "`fly` is no command"),
        ("start ldbb", "ldbb off"),
        ("start monitor", "monitor off"),
        ("stream 1", "spectrum, 50 dB"),
        ("reset monitor.teeth", "monitor.teeth = 0 1 (not stored)"),
    ] {
        terminal.enter(said).expect("typed");
        let seen = terminal.wait_for(answer, PATIENCE);
        seen.unwrap_or_else(|why| panic!("{said}: {why}"));
    }
    // Completion and history.
    terminal.press(&["s", "a", "v", "Tab"]).expect("pressed");
    terminal.wait_for("> save ", PATIENCE).expect("completed");
    terminal.press(&["C-u", "Up", "Up"]).expect("pressed");
    // The form of the command beside it: the log has the line, too.
    terminal
        .wait_for("stream SECONDS", PATIENCE)
        .expect("recalled");
    terminal.press(&["C-u", "F1"]).expect("pressed");
    terminal.wait_for("Commands", PATIENCE).expect("help");
    terminal.press(&["Escape"]).expect("pressed");
    terminal.enter("quit").expect("typed");
    assert_ended(&terminal, 0);
}

#[test]
fn a_box_that_goes_away_is_not_0_and_its_record_is_whole() {
    let Some(terminal) = terminal("a box that goes away", (80, 24)) else {
        return;
    };
    let folder = Folder::default();
    let key = folder.file("box.key", KEY.as_bytes());
    let sim = folder.file("quiet.toml", QUIET_BOX.as_bytes());
    let served = Served::start(&sim.display().to_string(), &key);
    let record = folder.path().join("kept.frames");
    let rarma = PROGRAM;
    let line = format!(
        "{rarma} connect tcp:{} --record {}",
        served.address,
        record.display()
    );
    terminal.enter(&told(&line)).expect("typed");
    terminal.wait_for("stable", PATIENCE).expect("listening");
    let begun = Instant::now();
    let kept = |record: &Path| std::fs::metadata(record).map_or(0, |meta| meta.len());
    while kept(&record) < 4096 {
        assert!(begun.elapsed() < PATIENCE, "the box says nothing");
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(served);
    let seen = assert_ended(&terminal, 4);
    assert!(
        seen.contains("the other end closed the connection"),
        "{seen}"
    );
    let decoded = program().run(["decode", &record.display().to_string(), "--json"]);
    assert_eq!(decoded.code, Some(0), "{decoded:?}");
    assert!(decoded.json_lines().len() > 10);
}

/// Noise for a second, then nothing more comes, and the pipe stays open.
struct Stalled {
    folder: Folder,
    _pipe: File,
}

impl Stalled {
    fn begin() -> Self {
        let folder = Folder::default();
        let path = folder.path().join("pipe");
        let made = Command::new("mkfifo").arg(&path).status();
        assert!(made.expect("mkfifo").success());
        // For reading, too: it does not wait for the other end.
        let both = File::options().read(true).write(true).open(&path);
        let pipe = both.expect("a pipe");
        let noise = |n: u32| (n.wrapping_mul(2_654_435_761) >> 20) as u8;
        let bytes: Vec<u8> = (0..96_000).map(noise).collect();
        let mut writes = pipe.try_clone().expect("the same pipe");
        // More than a pipe holds: the rest goes as it is read.
        std::thread::spawn(move || writes.write_all(&bytes));
        Self {
            folder,
            _pipe: pipe,
        }
    }

    /// Listens to it; the number of the process is in the file `pid`.
    fn line(&self) -> String {
        let at = |name: &str| self.folder.path().join(name).display().to_string();
        format!(
            "sh -c 'echo $$ > {}; exec {PROGRAM} monitor - --raw s16 --fs 48000 < {}'",
            at("pid"),
            at("pipe")
        )
    }

    fn pid(&self) -> String {
        let pid = std::fs::read_to_string(self.folder.path().join("pid"));
        pid.expect("a number").trim().to_owned()
    }
}

#[test]
fn a_stream_that_stalls_is_said_and_can_be_left() {
    let Some(terminal) = terminal("a stream that stalls", (80, 24)) else {
        return;
    };
    let stalled = Stalled::begin();
    terminal.enter(&told(&stalled.line())).expect("typed");
    terminal
        .wait_for("no samples: nothing has come for", PATIENCE)
        .expect("said");
    terminal.press(&["q"]).expect("pressed");
    let seen = assert_ended(&terminal, 0);
    assert!(seen.contains("No chatter in 1.00 s."), "{seen}");
}

#[test]
fn being_ended_leaves_the_terminal_as_it_was() {
    let Some(terminal) = terminal("SIGTERM", (80, 24)) else {
        return;
    };
    for signal in ["TERM", "INT"] {
        let stalled = Stalled::begin();
        terminal.enter("clear").expect("typed");
        terminal.enter(&told(&stalled.line())).expect("typed");
        terminal
            .wait_for("no samples:", PATIENCE)
            .expect("listening");
        let sent = Command::new("kill")
            .args([format!("-{signal}"), stalled.pid()])
            .status();
        assert!(sent.expect("kill").success());
        assert_ended(&terminal, 0);
    }
}

/// As when the line to a far machine breaks.
#[test]
fn a_terminal_that_is_gone_ends_the_program() {
    let Some(terminal) = terminal("a terminal that is gone", (80, 24)) else {
        return;
    };
    let stalled = Stalled::begin();
    terminal.enter(&stalled.line()).expect("typed");
    terminal
        .wait_for("no samples:", PATIENCE)
        .expect("listening");
    let process = Path::new("/proc").join(stalled.pid());
    assert!(process.exists());
    drop(terminal);
    let begun = Instant::now();
    while process.exists() {
        assert!(begun.elapsed() < PATIENCE, "it goes on without a terminal");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_terminal_that_cannot_be_drawn_on_has_lines() {
    let Some(terminal) = terminal("TERM=dumb", (80, 24)) else {
        return;
    };
    let folder = Folder::default();
    let rarma = PROGRAM;
    let hear = "simulate chatter-onset --out cut.wav --truth cut.json";
    let cd = format!("cd {}", folder.path().display());
    terminal
        .enter(&format!("{cd}; {rarma} {hear}; echo made'=it'"))
        .expect("typed");
    terminal.wait_for("made=it", PATIENCE).expect("a cut");
    let line = format!("TERM=dumb {rarma} monitor - < cut.wav");
    terminal.enter(&told(&line)).expect("typed");
    let seen = assert_ended(&terminal, 1);
    assert!(
        seen.contains("CHATTER called") && seen.contains("Chatter at"),
        "{seen}"
    );
    terminal.enter("clear").expect("typed");
    let line = format!("TERM=dumb {rarma} monitor cut.wav --screen on");
    terminal.enter(&told(&line)).expect("typed");
    let seen = assert_ended(&terminal, 2);
    assert!(seen.contains("TERM is dumb"), "{seen}");
    // No terminal at all.
    terminal.enter("clear").expect("typed");
    let line = format!("{rarma} monitor cut.wav --screen on | cat");
    terminal.enter(&told(&line)).expect("typed");
    let seen = terminal.wait_for("standard output is no terminal", PATIENCE);
    seen.expect("said");
}

#[test]
fn a_terminal_that_is_too_small_says_so_until_it_is_larger() {
    let Some(terminal) = terminal("20×5", (20, 5)) else {
        return;
    };
    let stalled = Stalled::begin();
    terminal.enter(&stalled.line()).expect("typed");
    terminal
        .wait_for("This terminal is too", PATIENCE)
        .expect("said");
    terminal.resize((80, 24)).expect("resized");
    terminal.wait_for("q end", PATIENCE).expect("drawn");
    terminal
        .wait_for("standard input", PATIENCE)
        .expect("drawn");
    terminal.press(&["q"]).expect("pressed");
    terminal.wait_for("No chatter in", PATIENCE).expect("ended");
    assert!(terminal.is_for_lines().expect("there"));
}

#[test]
fn a_reader_of_standard_output_and_of_errors_gets_what_it_is_for() {
    let Some(terminal) = terminal("redirected", (80, 24)) else {
        return;
    };
    let stalled = Stalled::begin();
    let errors = stalled.folder.path().join("errors");
    let line = format!("{} 2> {}", stalled.line(), errors.display());
    terminal.enter(&told(&line)).expect("typed");
    terminal
        .wait_for("no samples:", PATIENCE)
        .expect("listening");
    terminal.press(&["C-c"]).expect("pressed");
    assert_ended(&terminal, 0);
    let errors = std::fs::read_to_string(errors).expect("a file");
    assert!(!errors.contains('\u{1b}'), "{errors:?}");
}
