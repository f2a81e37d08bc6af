//! Links that fail, and what was told meanwhile.

use super::*;
use crate::gateway::link::Counts;
use std::path::Path;
use std::sync::atomic::AtomicUsize;

/// Opens links that do what it says, and counts them.
struct Opens {
    opened: Arc<AtomicUsize>,
    link: fn() -> Result<Fake, String>,
}

#[derive(Clone)]
struct Fake {
    answers: bool,
    listens: Result<bool, String>,
    sent: Arc<AtomicUsize>,
}

impl Open for Opens {
    fn open(&self, _: &str, _: u32) -> Result<Box<dyn Link>, String> {
        self.opened.fetch_add(1, Ordering::Relaxed);
        (self.link)().map(|link| Box::new(link) as Box<dyn Link>)
    }

    fn key(&self, _: &Path) -> Result<LinkKey, String> {
        Err("no keys here".to_owned())
    }
}

impl Link for Fake {
    fn listen(&mut self, _: &mut dyn FnMut(Head, Telemetry)) -> Result<bool, String> {
        self.listens.clone()
    }

    fn send(&mut self, _: &[u8]) -> Result<(), String> {
        self.sent.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    fn answers(&self) -> bool {
        self.answers
    }

    fn counts(&self) -> Counts {
        Counts::default()
    }
}

/// A box with links of this kind for some seconds, which a controller tells something at the
/// beginning: how often it was opened, what was said, what it has still to be told.
fn run(
    link: fn() -> Result<Fake, String>,
    seconds: u64,
    told: Vec<(Told, Instant)>,
) -> (usize, Vec<String>, Vec<Told>, Option<Value>) {
    let opened = Arc::new(AtomicUsize::new(0));
    let opens = Opens {
        opened: Arc::clone(&opened),
        link,
    };
    let said: Arc<Mutex<Vec<String>>> = Arc::default();
    let kept = Arc::clone(&said);
    let shared = Arc::new(Shared {
        live: Mutex::default(),
        told: Mutex::default(),
    });
    for (one, at) in told {
        assert!(shared.told().put(one, at));
    }
    let (batches, _taken) = std::sync::mpsc::sync_channel(1000);
    let stop = Arc::new(AtomicBool::new(false));
    let config = "group = \"g\"\nnode = \"n\"\njournal = \"j\"\n[[box]]\nname = \"box-1\"\nmachine = \"M1\"\nport = \"x\"\n";
    let mut config = crate::gateway::config::Config::parse(config, Path::new("")).unwrap();
    let thread = BoxThread {
        config: config.boxes.remove(0),
        key: None,
        stretch_s: 60.0,
        keep: Duration::from_secs(1),
        before: None,
        shared: Arc::clone(&shared),
        batches,
        notices: Notices::new(Arc::new(move |_, line| {
            kept.lock().unwrap().push(line.to_owned());
        })),
        stop: Arc::clone(&stop),
    };
    let running = std::thread::spawn(move || thread.run(&opens));
    std::thread::sleep(Duration::from_secs(seconds));
    stop.store(true, Ordering::Relaxed);
    running.join().unwrap();
    let said = said.lock().unwrap().clone();
    let left = shared.told().drain().into_iter().map(|(told, _)| told);
    let tool = shared.live().get(OfBox::Tool).cloned();
    (opened.load(Ordering::Relaxed), said, left.collect(), tool)
}

fn fake(answers: bool, listens: Result<bool, &str>) -> Fake {
    Fake {
        answers,
        listens: listens.map_err(str::to_owned),
        sent: Arc::default(),
    }
}

/// Opened at 0, 1 and 3 s, and not as fast as it goes.
#[test]
fn a_link_that_opens_and_fails_at_once_is_opened_again_after_a_pause() {
    let link = || Ok(fake(true, Err("the box is gone")));
    let (opened, said, ..) = run(link, 4, Vec::new());
    assert!((2..=3).contains(&opened), "opened {opened} times");
    assert_eq!(said, ["box-1: the box is gone"]);
}

#[test]
fn what_was_told_to_a_box_that_is_away_is_dropped_and_said_once_it_is_old() {
    let link = || Err("nobody there".to_owned());
    let now = Instant::now();
    let old = now.checked_sub(Duration::from_secs(11)).unwrap();
    let tool = Told::Tool(Some(Name::new("T12").unwrap()));
    let told = vec![
        (Told::Speed(6000.0), old),
        (Told::Teeth(4), now),
        (tool.clone(), old),
    ];
    let (_, said, left, _) = run(link, 1, told);
    assert_eq!(left, [Told::Teeth(4), tool]);
    let why = "box-1: not told: the speed 6000 1/min: the box is away".to_owned();
    assert_eq!(said.get(1), Some(&why), "{said:?}");
}

/// What the box has not taken when its link fails waits for the next link; the tool needs no box.
#[test]
fn what_a_link_did_not_take_is_kept_and_a_tool_counts_at_once() {
    let link = || Ok(fake(true, Err("the box is gone")));
    let tool = Told::Tool(Some(Name::new("T12").unwrap()));
    let told = vec![(Told::Teeth(4), Instant::now()), (tool, Instant::now())];
    let (_, _, left, shown) = run(link, 1, told);
    assert_eq!(left, [Told::Teeth(4)]);
    assert_eq!(shown, Some(Value::Text("T12".to_owned())));
}

#[test]
fn a_recording_is_told_nothing_and_it_is_said() {
    let link = || Ok(fake(false, Ok(false)));
    let told = vec![(Told::Speed(6000.0), Instant::now())];
    let (opened, said, left, _) = run(link, 1, told);
    assert_eq!((opened, left.len()), (1, 0));
    assert_eq!(said, ["box-1: not told: it is a recording"]);
}
