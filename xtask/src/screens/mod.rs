//! `cargo xtask screens [DIR]`: the live screen of `rarma` as pictures, of real programs in real
//! terminals. `cargo verify` makes those of one size, with a sound card (stage `sound card`).

mod svg;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::tmux::{self, Terminal};
use crate::{Failure, Result, Workspace, process, sound};

/// Terminals that are shown.
const SIZES: [(u16, u16); 2] = [(80, 24), (160, 50)];
/// A program has its picture after this long.
const PATIENCE: Duration = Duration::from_secs(30);
/// Where the pictures go.
const FOLDER: &str = "target/screens";
/// What the monitor and the microphone hear.
const CUT: &str = "chatter-onset";
const SPEED: &str = "--rpm 1680 --teeth 6";
/// What the box hears: there is time to type before it chatters.
const LONG_CUT: &str = include_str!("long_cut.toml");
/// The key of that box, which is nobody's.
const KEY: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff\n";
/// A session: what is typed to the box.
const SESSION: [&str; 10] = [
    "identify",
    "status",
    "read monitor.threshold",
    "set monitor.spindle 28",
    "set monitor.teeth 6",
    "start monitor",
    "stream 60",
    "set monitor.threshold 9",
    "fly",
    "save monitor.teeth",
];

/// Makes them.
///
/// # Errors
/// A program is missing, or does not come to what is to be seen.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let (mut folder, mut program) = (folder(workspace), None);
    let mut arguments = arguments.iter();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--program" => program = arguments.next().map(PathBuf::from),
            option if option.starts_with('-') => {
                return Err(Failure::usage(format!(
                    "`screens` takes a folder and `--program FILE`, not `{option}`"
                )));
            }
            given => folder = PathBuf::from(given),
        }
    }
    tmux::ensure()?;
    let program = match program {
        Some(program) => program,
        None => build(workspace)?,
    };
    let studio = Studio::open(program, folder)?;
    let cards = studio.has_sound_cards();
    if !cards {
        eprintln!("no picture of a microphone: this `rarma` was built without sound cards");
    }
    for size in SIZES {
        studio.of_all(size, cards)?;
    }
    studio.of_a_small_terminal()?;
    Ok(0)
}

/// Where the pictures go unless told otherwise.
pub fn folder(workspace: &Workspace) -> PathBuf {
    workspace.root().join(FOLDER)
}

/// Those of a usual terminal, by a program that was built with sound cards.
///
/// # Errors
/// As [`main`], or it was built without.
pub fn usual(workspace: &Workspace, program: PathBuf) -> Result<()> {
    tmux::ensure()?;
    Studio::open(program, folder(workspace))?.of_all(SIZES[0], true)
}

/// `rarma`, with sound cards where it can be built so.
fn build(workspace: &Workspace) -> Result<PathBuf> {
    let mut build = process::host_cargo(workspace);
    build.args(["build", "--release", "--package", "rarma-cli"]);
    match sound::ensure_card_library() {
        Ok(()) => drop(build.args(["--features", "sound-card"])),
        Err(failure) => eprintln!("{failure}"),
    }
    process::run(&mut build)?;
    Ok(workspace.root().join("target/release/rarma"))
}

/// Where pictures are made.
struct Studio {
    rarma: PathBuf,
    folder: PathBuf,
}

impl Studio {
    fn open(program: PathBuf, folder: PathBuf) -> Result<Self> {
        fs::create_dir_all(&folder).map_err(|why| {
            Failure::new(format!("cannot make {}", folder.display())).because(why)
        })?;
        let folder = folder
            .canonicalize()
            .map_err(|why| Failure::new("no folder for the pictures").because(why))?;
        let rarma = program.canonicalize().map_err(|why| {
            Failure::new(format!("no program {}", program.display())).because(why)
        })?;
        let studio = Self { rarma, folder };
        let mut simulate = Command::new(&studio.rarma);
        simulate
            .args(["simulate", CUT, "--out"])
            .arg(studio.sound())
            .arg("--truth")
            .arg(studio.folder.join("cut.json"));
        process::output(&mut simulate)?;
        Ok(studio)
    }

    fn of_all(&self, size: (u16, u16), cards: bool) -> Result<()> {
        self.of_a_box(size)?;
        self.of_a_recording(size)?;
        if cards {
            self.of_a_microphone(size)?;
        }
        Ok(())
    }

    /// Whether it was built so.
    fn has_sound_cards(&self) -> bool {
        let mut list = Command::new(&self.rarma);
        process::output(list.args(["listen", "--list"])).is_ok()
    }

    fn sound(&self) -> PathBuf {
        self.folder.join("cut.wav")
    }

    fn file(&self, name: &str, text: &str) -> Result<PathBuf> {
        let path = self.folder.join(name);
        fs::write(&path, text)
            .map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))?;
        Ok(path)
    }

    fn rarma(&self) -> String {
        quoted(&self.rarma)
    }

    /// What is seen now.
    fn take(&self, terminal: &Terminal, name: &str, size: (u16, u16)) -> Result<()> {
        let name = format!("{name}-{}x{}.svg", size.0, size.1);
        let path = self.file(&name, &svg::picture(&terminal.coloured()?, size))?;
        println!("{}", path.display());
        Ok(())
    }

    /// A box that is talked to, command by command, until it calls chatter.
    fn of_a_box(&self, size: (u16, u16)) -> Result<()> {
        let (mut serving, address) = self.serve()?;
        let done = (|| {
            let terminal = Terminal::open(size)?;
            let key = quoted(&self.folder.join("box.key"));
            terminal.enter(&format!(
                "{} connect tcp:{address} --key {key}",
                self.rarma()
            ))?;
            terminal.wait_for("rarma connect", PATIENCE)?;
            terminal.wait_for("in control", PATIENCE)?;
            for line in SESSION {
                terminal.enter(line)?;
                std::thread::sleep(Duration::from_millis(300));
            }
            terminal.press(&["s", "e", "t", "Space", "m", "o", "n", "Tab"])?;
            terminal.wait_for("monitor.order", PATIENCE)?;
            self.take(&terminal, "box-session", size)?;
            terminal.press(&["C-u"])?;
            terminal.wait_for("CHATTER called", PATIENCE)?;
            std::thread::sleep(Duration::from_secs(2));
            self.take(&terminal, "box-chatter", size)?;
            terminal.press(&["F1"])?;
            terminal.wait_for("Keys", PATIENCE)?;
            self.take(&terminal, "box-help", size)?;
            terminal.press(&["F1"])?;
            terminal.enter("quit")
        })();
        let _ = serving.kill().and_then(|()| serving.wait());
        done
    }

    /// A simulated box that hears the cut, which begins later and lasts longer, and where it
    /// listens.
    fn serve(&self) -> Result<(Child, String)> {
        use std::io::{BufRead, BufReader};
        let mut command = Command::new(&self.rarma);
        // With a key, a host over a network may change something.
        command
            .args(["box", "--listen", "127.0.0.1:0", "--sim"])
            .arg(self.file("cut.toml", LONG_CUT)?)
            .arg("--key")
            .arg(self.file("box.key", KEY)?)
            .stdout(Stdio::piped());
        let mut child = command
            .spawn()
            .map_err(|why| process::cannot_start(&command, &why))?;
        let mut line = String::new();
        if let Some(output) = child.stdout.take() {
            let _ = BufReader::new(output).read_line(&mut line);
        }
        match line.trim().rsplit(' ').next() {
            Some(address) if address.contains(':') => Ok((child, address.to_owned())),
            _ => Err(Failure::new("the box does not listen").because(line)),
        }
    }

    /// A recording, played.
    fn of_a_recording(&self, size: (u16, u16)) -> Result<()> {
        let terminal = Terminal::open(size)?;
        let sound = quoted(&self.sound());
        let line = format!("{} monitor {sound} --screen on {SPEED}", self.rarma());
        self.hear(&terminal, &line, "monitor", size)
    }

    fn hear(&self, terminal: &Terminal, line: &str, name: &str, size: (u16, u16)) -> Result<()> {
        terminal.enter(line)?;
        terminal.wait_for("stable:", PATIENCE)?;
        std::thread::sleep(Duration::from_secs(1));
        self.take(terminal, &format!("{name}-stable"), size)?;
        terminal.wait_for("CHATTER called", PATIENCE)?;
        std::thread::sleep(Duration::from_secs(2));
        self.take(terminal, &format!("{name}-chatter"), size)?;
        terminal.press(&["q"])?;
        terminal.wait_for("Chatter at", PATIENCE)?;
        self.take(terminal, &format!("{name}-after"), size)
    }

    /// The same through a sound card, which is a pipe.
    fn of_a_microphone(&self, size: (u16, u16)) -> Result<()> {
        let home = sound::PipeCard::open(&self.sound())?;
        let terminal = Terminal::open(size)?;
        let line = format!(
            "HOME={} {} listen --device {} {SPEED}",
            quoted(home.folder()),
            self.rarma(),
            sound::PipeCard::NAME
        );
        self.hear(&terminal, &line, "microphone", size)
    }

    fn of_a_small_terminal(&self) -> Result<()> {
        let size = (40, 10);
        let terminal = Terminal::open(size)?;
        let sound = quoted(&self.sound());
        terminal.enter(&format!("{} monitor {sound} --screen on", self.rarma()))?;
        terminal.wait_for("too small", PATIENCE)?;
        self.take(&terminal, "small", size)
    }
}

/// A path for a shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}
