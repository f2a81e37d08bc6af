//! Promise: `rarma act` orders nothing where it must not, and says what to do instead; and where it is ended, or can log
//! no more, what is ordered is given back before it ends.
#![cfg(unix)]

use host_tests::acting::{Acting, RPM, acts, ends_given_back, log_lines};
use host_tests::component::Component;
use host_tests::files::Folder;
use host_tests::grbl::Grbl;
use host_tests::process::Ended;
use host_tests::rarma;
use std::path::{Path, PathBuf};

/// Overrides that the component takes.
const RANGE: [f64; 2] = [0.8, 1.2];
/// What is ordered first, percent: [`Acting`] hears the chatter of three-mode-chatter.
const FIRST: i32 = 88;

/// A Grbl, a component of LinuxCNC, and a recording of chatter.
struct Shop {
    grbl: Grbl,
    component: Component,
    folder: Folder,
    recording: PathBuf,
}

impl Shop {
    fn new() -> Self {
        let folder = Folder::default();
        let recording = folder.path().join("cut.wav");
        let name = recording.to_str().expect("a name");
        let made = rarma!().run(["simulate", "three-mode-chatter", "--out", name]);
        assert_eq!(made.code, Some(0), "{made:?}");
        Self {
            grbl: Grbl::running(RPM),
            component: Component::running(RPM, RANGE),
            folder,
            recording,
        }
    }

    fn log(&self) -> PathBuf {
        self.folder.path().join("act.jsonl")
    }

    /// `rarma act` with these words: `FILE` is the recording, `GRBL` and `LINUXCNC` are the controllers.
    fn act(&self, words: &str) -> Ended {
        let file = self.recording.display().to_string();
        let log = self.log().display().to_string();
        let word = |word: &str| match word {
            "FILE" => file.clone(),
            "GRBL" => format!("grbl:{}", self.grbl.port),
            "LINUXCNC" => format!("linuxcnc:{}", self.component.address),
            word => word.to_owned(),
        };
        let words = words.split_whitespace().map(word);
        let all = ["act".to_owned(), "--log".to_owned(), log];
        rarma!().run(all.into_iter().chain(words))
    }

    /// Refused as wrong usage, in words that say what to do, and nothing was ordered of anybody.
    fn refuses(&self, words: &str, says: &[&str]) {
        let ended = self.act(words);
        assert_eq!(ended.code, Some(2), "{words}: {ended:?}");
        for say in says {
            assert!(ended.stderr.contains(say), "{words}: `{say}`: {ended:?}");
        }
        assert!(!ended.stderr.contains("panicked"), "{words}: {ended:?}");
        self.has_ordered_nothing(words);
    }

    fn has_ordered_nothing(&self, words: &str) {
        assert!(asked_only(&self.grbl), "{words}");
        let state = self.component.state();
        assert!(state.orders().is_empty(), "{words}: {:?}", state.told);
        let acts = acts(&self.log());
        assert!(!acts.iter().any(|a| a == "ordered"), "{words}: {acts:?}");
    }
}

/// It was asked for reports, and that is all.
fn asked_only(grbl: &Grbl) -> bool {
    let state = grbl.state();
    let unturned = (state.spindle, state.feed, state.ends) == (100, 100, (100, 100));
    unturned && state.bytes.iter().all(|b| *b == b'?')
}

#[test]
fn leave_to_order_without_limits_is_refused() {
    let shop = Shop::new();
    for controller in ["GRBL", "LINUXCNC", "dry"] {
        for input in ["-", "FILE"] {
            let words = format!("{input} --teeth 3 --controller {controller} --act");
            // With what is missing named, nothing is opened.
            shop.refuses(&words, &["required", "--override <MIN:MAX>"]);
        }
    }
    assert!(shop.grbl.state().bytes.is_empty());
    assert_eq!(shop.component.state().peers, 0);
    assert!(!shop.log().exists());
    for none in ["5:120", "80:210", "101:120", "80:99", "100:100", "80"] {
        let words = format!("- --teeth 3 --controller GRBL --act --override {none}");
        shop.refuses(&words, &["--override <MIN:MAX>", "such as 80:120"]);
    }
}

#[test]
fn leave_to_order_of_nobody_is_refused() {
    let shop = Shop::new();
    let words = "FILE --teeth 3 --rpm 11000 --controller dry --override 80:120";
    let says = [
        "--act: there is nobody to order anything of",
        "name a controller, or leave out --act",
    ];
    shop.refuses(&format!("{words} --act"), &says);
    // As it says.
    let ended = shop.act(words);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stdout.contains("would order"), "{ended:?}");
    shop.has_ordered_nothing(words);
}

#[test]
fn leave_to_order_by_a_recording_is_refused() {
    let shop = Shop::new();
    for controller in ["GRBL", "LINUXCNC"] {
        let words = format!("FILE --teeth 3 --controller {controller} --override 80:120");
        let says = [
            "--act: a recording is over",
            "give the live sound on standard input (-), or leave out --act",
        ];
        shop.refuses(&format!("{words} --act"), &says);
    }
    // As it says, with a Grbl that nobody has spoken to yet.
    let shop = Shop::new();
    for controller in ["GRBL", "LINUXCNC"] {
        let words = format!("FILE --teeth 3 --controller {controller} --override 80:120");
        let ended = shop.act(&words);
        assert!(matches!(ended.code, Some(0 | 1)), "{words}: {ended:?}");
        shop.has_ordered_nothing(&words);
    }
}

#[test]
fn a_speed_beside_a_controller_that_tells_it_is_refused() {
    let shop = Shop::new();
    let speeds = shop.folder.file("speeds.csv", b"t_s,rpm\n0,11000\n");
    let speeds = speeds.display();
    for controller in ["GRBL", "LINUXCNC"] {
        for told in [
            "--rpm 11000",
            &format!("--speed-from {speeds}"),
            "--tacho 2",
        ] {
            for act in ["", "--act --override 80:120"] {
                let words = format!("- --teeth 3 --controller {controller} {told} {act}");
                let says = [
                    "--controller: the controller tells the speed",
                    "leave out --rpm, --speed-from and --tacho",
                ];
                shop.refuses(&words, &says);
            }
        }
    }
    assert!(shop.grbl.state().bytes.is_empty());
    assert_eq!(shop.component.state().peers, 0);
    let words = "FILE --teeth 3 --controller dry";
    shop.refuses(words, &["--controller dry: tells no speed: add --rpm"]);
}

#[test]
fn limits_beyond_what_the_controller_takes_are_refused() {
    let shop = Shop::new();
    for limits in ["70:120", "80:130", "50:150"] {
        for act in ["", "--act"] {
            let words = format!("- --teeth 3 --controller LINUXCNC --override {limits} {act}");
            let says = format!("--override {limits}: the controller takes 80 to 120 %");
            shop.refuses(&words, &[&says]);
        }
    }
    let words = "FILE --teeth 3 --controller LINUXCNC --override 80:120";
    let ended = shop.act(words);
    assert!(matches!(ended.code, Some(0 | 1)), "{ended:?}");
}

/// The program with leave to order of a simulated Grbl.
struct Ordering {
    grbl: Grbl,
    folder: Folder,
    acting: Acting,
}

impl Ordering {
    fn begin(folder: Folder, log: &Path) -> Self {
        let grbl = Grbl::running(RPM);
        let options = format!(
            "--controller grbl:{} --act --override 80:120 --log {}",
            grbl.port,
            log.display()
        );
        let acting = Acting::begin(rarma!(), folder.path(), &options);
        Self {
            grbl,
            folder,
            acting,
        }
    }

    /// With an order that has arrived.
    fn standing() -> (Self, PathBuf) {
        let folder = Folder::default();
        let log = folder.path().join("act.jsonl");
        let mut ordering = Self::begin(folder, &log);
        let arrived = || acts(&log).iter().any(|act| act == "arrived");
        ordering.acting.until("an order stands", arrived);
        let spindle = ordering.grbl.state().spindle;
        assert!((80..=95).contains(&spindle), "{spindle}");
        (ordering, log)
    }

    /// What Grbl has in force, percent: speed and feed.
    fn in_force(&self) -> (i32, i32) {
        let state = self.grbl.state();
        (state.spindle, state.feed)
    }
}

fn is_given_back_on(signal: &str) {
    let (mut ordering, log) = Ordering::standing();
    ordering.acting.signal(signal);
    let ended = ordering.acting.ended();
    // As a shell counts an interrupt, and no verdict: nobody has heard it out.
    assert_eq!(ended.code, Some(130), "{ended:?}");
    assert_eq!(ordering.in_force(), (100, 100), "{ended:?}");
    let lines = log_lines(&log);
    ends_given_back(&lines);
}

#[test]
fn an_interrupt_gives_back_before_it_ends() {
    is_given_back_on("INT");
}

#[test]
fn being_ended_by_the_system_gives_back_before_it_ends() {
    is_given_back_on("TERM");
}

/// Grbl has no dead man: docs/act.md says so, and it is so.
#[test]
fn a_killed_program_leaves_grbl_as_it_was_ordered() {
    let (mut ordering, _) = Ordering::standing();
    ordering.acting.signal("KILL");
    let ended = ordering.acting.ended();
    assert_eq!(ended.code, None, "{ended:?}");
    let left = ordering.in_force();
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(ordering.in_force(), left);
    assert!((80..=95).contains(&left.0), "{left:?}");
}

/// A log whose reader goes away after this act; the acts that it has read. The next line cannot be written.
fn log_until(log: &Path, last: &'static str) -> std::thread::JoinHandle<Vec<String>> {
    use std::io::{BufRead as _, BufReader};
    let made = std::process::Command::new("mkfifo").arg(log).status();
    assert!(made.expect("mkfifo").success());
    let log = log.to_owned();
    std::thread::spawn(move || {
        let mut read = Vec::new();
        // It opens when the other end does.
        let lines = BufReader::new(std::fs::File::open(log).expect("a pipe")).lines();
        for line in lines.map_while(Result::ok) {
            let line: serde_json::Value = serde_json::from_str(&line).expect("JSON");
            read.push(line["act"].as_str().expect("an act").to_owned());
            if line["act"] == last {
                break;
            }
        }
        read
    })
}

/// It has ended with a failure that names the log, though the sound goes on; what Grbl has then is as programmed.
fn ends_for_its_log(mut ordering: Ordering, log: &Path) -> Ordering {
    let ended = ordering.acting.ended();
    assert_eq!(ended.code, Some(4), "{ended:?}");
    let said = format!("rarma: {}: write: ", log.display());
    assert!(ended.stderr.contains(&said), "{ended:?}");
    assert_eq!(ordering.in_force(), (100, 100), "{ended:?}");
    ordering
}

#[test]
fn a_log_that_fails_while_an_order_stands_gives_back_and_ends_the_program() {
    let folder = Folder::default();
    let log = folder.path().join("act.jsonl");
    let reader = log_until(&log, "arrived");
    let ordering = ends_for_its_log(Ordering::begin(folder, &log), &log);
    let read = reader.join().expect("a reader");
    assert_eq!(read, ["begins", "proposed", "ordered", "arrived"]);
    // It had stood, and nothing else was ordered since.
    let ends = ordering.grbl.state().ends;
    assert_eq!(ends, (FIRST, 100));
}

#[test]
fn a_log_that_fails_on_the_way_gives_back_and_ends_the_program() {
    let folder = Folder::default();
    let log = folder.path().join("act.jsonl");
    // The next line says that the override has arrived.
    let reader = log_until(&log, "ordered");
    let ordering = ends_for_its_log(Ordering::begin(folder, &log), &log);
    assert_eq!(reader.join().expect("a reader").len(), 3);
    let ends = ordering.grbl.state().ends;
    assert_eq!(ends, (FIRST, 100));
}

#[test]
fn a_log_that_fails_before_the_first_order_lets_nothing_be_ordered() {
    let folder = Folder::default();
    let log = folder.path().join("act.jsonl");
    // The next line says what is proposed.
    let reader = log_until(&log, "begins");
    let ordering = ends_for_its_log(Ordering::begin(folder, &log), &log);
    assert_eq!(reader.join().expect("a reader"), ["begins"]);
    assert!(asked_only(&ordering.grbl), "{:?}", ordering.grbl.state());
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_on_a_full_disk_lets_nothing_begin() {
    let log = Path::new("/dev/full");
    let ordering = ends_for_its_log(Ordering::begin(Folder::default(), log), log);
    let said = std::fs::read_to_string(ordering.folder.path().join("stderr.txt"));
    assert!(said.expect("a file").contains("the disk is full"));
    assert!(asked_only(&ordering.grbl), "{:?}", ordering.grbl.state());
}

/// However much sound there is still to be heard.
#[cfg(target_os = "linux")]
#[test]
fn a_log_on_a_full_disk_ends_a_run_that_orders_nothing_too() {
    let options =
        "act - --raw s16 --fs 48000 --rpm 11000 --teeth 3 --controller dry --log /dev/full";
    let fed = rarma!().fed(options.split_whitespace(), false, |pipe| {
        loop {
            pipe.write_all(&[0, 1, 0, 255, 7, 1])?;
        }
    });
    let ended = fed.ended;
    assert_eq!(ended.code, Some(4), "{ended:?}");
    assert!(ended.stderr.contains("/dev/full: write: the disk is full"));
}

/// The whole way to LinuxCNC but LinuxCNC; with it: `act_linuxcnc`.
#[test]
fn a_component_is_ordered_of_and_left() {
    let component = Component::running(RPM, RANGE);
    let folder = Folder::default();
    let log = folder.path().join("act.jsonl");
    let options = format!(
        "--controller linuxcnc:{} --act --override 80:120 --log {}",
        component.address,
        log.display()
    );
    let mut acting = Acting::begin(rarma!(), folder.path(), &options);
    acting.until("an order stands", || {
        component.state().factor.is_some_and(|f| f < 0.95)
    });
    acting.end_sound();
    let ended = acting.ended();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    let state = component.state();
    let inside = |factor: &f64| (RANGE[0]..=RANGE[1]).contains(factor);
    assert!(state.orders().iter().all(inside), "{:?}", state.told);
    assert_eq!(state.told.last(), Some(&serde_json::json!({"leave": true})));
    assert_eq!((state.factor, state.peers), (None, 1));
    let acts = acts(&log);
    for act in ["begins", "proposed", "ordered", "ends", "returned"] {
        assert!(acts.iter().any(|a| a == act), "{act}: {acts:?}");
    }
}
