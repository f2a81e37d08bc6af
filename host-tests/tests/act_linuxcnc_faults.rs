//! Promise: with LinuxCNC, whatever fails while an order stands gives back; the operator wins; HAL
//! lets nothing beyond its limits.
//!
//! Run like act_linuxcnc, and skipped like it.
#![cfg(target_os = "linux")]

use host_tests::acting::{Acting, acts};
use host_tests::files::Folder;
use host_tests::linuxcnc::{COMPONENT, LinuxCnc};
use host_tests::rarma;
use rarma_cli::controller::{self, Actor, Chatter, What};
use rarma_core::act::ActConfig;
use std::io::Write as _;
use std::net::TcpStream;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::{Duration, Instant};

const RPM: f64 = 11_000.0;
/// Chatter of three-mode-chatter: 88 % is proposed.
const CHATTER_HZ: f64 = 1007.0;
const LIMITS: (f64, f64) = (0.8, 1.2);
/// The larger limit in HAL, as [`LinuxCnc::start`] sets it.
const HAL_MOST: f64 = 1.5;

/// Somebody who listens and orders.
struct Hand {
    actor: Actor,
    begun: Instant,
    chatter_hz: Option<f64>,
    said: Vec<What>,
}

impl Hand {
    /// LinuxCNC runs a program, and its spindle turns.
    fn on(mill: &mut LinuxCnc) -> Self {
        mill.say(&format!("run {RPM} 60"));
        let port = controller::LinuxCnc::open(COMPONENT, true).expect("it listens");
        let about = Chatter {
            teeth: 3,
            ..Chatter::default()
        };
        let config = ActConfig::limits(true, LIMITS.0, LIMITS.1);
        let mut hand = Self {
            actor: Actor::new(Box::new(port), config, about, None).expect("in range"),
            begun: Instant::now(),
            chatter_hz: None,
            said: Vec::new(),
        };
        let turns = |hand: &Self| {
            let reading = hand.actor.reading();
            reading.is_some_and(|r| {
                r.actual_hz
                    .is_some_and(|hz| (60.0 * hz - RPM).abs() < 100.0)
            })
        };
        while !turns(&hand) {
            let last = hand.actor.reading();
            assert!(hand.begun.elapsed() < Duration::from_secs(10), "{last:?}");
            hand.go(0.1);
        }
        hand
    }

    /// Chatter was called, and an order is on its way.
    fn ordering(mill: &mut LinuxCnc) -> Self {
        let mut hand = Self::on(mill);
        hand.chatter_hz = Some(CHATTER_HZ);
        hand.go(0.1);
        assert_eq!(hand.orders(), 1);
        hand
    }

    /// It has arrived, and the chatter has ended.
    fn ordered(mill: &mut LinuxCnc) -> Self {
        let mut hand = Self::ordering(mill);
        hand.chatter_hz = None;
        hand.go(1.2);
        let arrived = |what: &What| matches!(what, What::Arrived { .. });
        assert!(hand.said.iter().any(arrived), "{:#?}", hand.said);
        assert!(hand.in_force() < 0.95);
        hand
    }

    /// By the clock. Nothing beyond the limits is ever in force.
    fn go(&mut self, seconds: f64) {
        let end = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < end {
            let t_s = self.begun.elapsed().as_secs_f64();
            self.actor.heard(t_s, self.chatter_hz);
            let step = self.actor.step(t_s, |record| self.said.push(record.what));
            step.expect("no log");
            if let Some(reading) = self.actor.reading() {
                let ours = reading.overrides.spindle / reading.operator.unwrap_or(1.0);
                assert!(
                    (LIMITS.0 - 1e-6..=LIMITS.1 + 1e-6).contains(&ours),
                    "{ours}"
                );
            }
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn in_force(&self) -> f64 {
        self.actor.reading().expect("a report").overrides.spindle
    }

    fn orders(&self) -> usize {
        let ordered = |what: &&What| matches!(what, What::Ordered { .. });
        self.said.iter().filter(ordered).count()
    }

    fn ends(&self) -> Vec<&str> {
        let ends = self.said.iter().filter_map(|what| match what {
            What::Ends { why, .. } => Some(*why),
            _ => None,
        });
        ends.collect()
    }

    /// It ended for this reason, is given back, and no chatter brings another order.
    fn given_back(mut self, mill: &mut LinuxCnc, why: &str) {
        self.go(0.5);
        assert_eq!(self.ends(), [why], "{:#?}", self.said);
        assert!(
            (self.in_force() - 1.0).abs() < 0.001,
            "{why}: {}",
            self.in_force()
        );
        assert!(self.said.contains(&What::Returned), "{:#?}", self.said);
        self.chatter_hz = Some(CHATTER_HZ);
        self.go(0.5);
        assert_eq!(self.orders(), 1, "{why}: {:#?}", self.said);
        drop(self);
        mill.say("abort");
    }
}

/// Waits until HAL's factor is 1 again; how long that took, s.
fn back(mill: &mut LinuxCnc) -> f64 {
    let begun = Instant::now();
    loop {
        let factor = mill.factor();
        if (factor - 1.0).abs() < 1e-9 {
            return begun.elapsed().as_secs_f64();
        }
        assert!((LIMITS.0..=HAL_MOST).contains(&factor), "{factor}");
        assert!(begun.elapsed() < Duration::from_secs(3), "{factor}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// A fault by its name: what it does to a LinuxCNC that runs, and what comes of it.
type Fault = (&'static str, fn(&mut LinuxCnc));

/// One after the other with one LinuxCNC, which takes seconds to start; the last one ends its component.
const FAULTS: [Fault; 12] = [
    ("the operator turns the override", the_operator_wins),
    ("emergency stop", an_emergency_stop_gives_back),
    ("the program ends", the_end_of_the_program_gives_back),
    ("a second alarm during the change", a_second_alarm_waits),
    (
        "the override is clamped in mid-course",
        a_clamped_override_is_given_back,
    ),
    ("the override is refused", a_refused_override_is_given_back),
    (
        "the drive does not follow",
        a_speed_that_is_not_reached_is_given_back,
    ),
    ("the link is cut in mid-course", a_cut_link_gives_back),
    (
        "rarma says nothing any more",
        a_program_that_hangs_gives_back,
    ),
    (
        "orders beyond the limits of HAL",
        hal_keeps_its_limits_and_its_rate,
    ),
    ("rarma is killed", a_killed_program_gives_back),
    ("the component is killed", a_killed_component_gives_back),
];

#[test]
fn whatever_fails_gives_back() {
    if std::env::var_os("RARMA_REQUIRE_LINUXCNC").is_none() {
        println!("SKIPPED: faults with LinuxCNC: run `cargo verify --only \"loop with LinuxCNC\"`");
        return;
    }
    let folder = Folder::default();
    let mut mill = LinuxCnc::start(folder.path());
    for (name, fault) in FAULTS {
        println!("fault: {name}");
        let held = catch_unwind(AssertUnwindSafe(|| fault(&mut mill)));
        assert!(held.is_ok(), "fault: {name}: see what was said above");
    }
}

/// It is left as he set it.
fn the_operator_wins(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordered(mill);
    mill.say("override 105");
    hand.go(0.5);
    assert_eq!(hand.ends(), ["operator"]);
    hand.chatter_hz = Some(CHATTER_HZ);
    hand.go(1.0);
    assert_eq!(hand.orders(), 1);
    let in_force = hand.in_force();
    assert!((in_force - 1.05).abs() < 0.001, "{in_force}");
    drop(hand);
    mill.say("abort");
}

fn an_emergency_stop_gives_back(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordered(mill);
    mill.say("estop");
    hand.go(1.0);
    // LinuxCNC switches the machine off before it ends the program, and the component looks at the program first: where that
    // has ended, the machine is seen to be off.
    assert_eq!(hand.ends(), ["stopped"]);
    assert!((hand.in_force() - 1.0).abs() < 0.001);
    // Nothing is ordered of a machine that has stopped.
    hand.chatter_hz = Some(CHATTER_HZ);
    hand.go(0.5);
    let last = hand.actor.reading().expect("a report");
    assert!(last.stopped, "{last:?}");
    assert_eq!(hand.orders(), 1, "{:#?}", hand.said);
}

/// The next one may be ordered of again.
fn the_end_of_the_program_gives_back(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordered(mill);
    mill.say("abort");
    hand.go(0.5);
    assert_eq!(hand.ends(), ["program-end"]);
    assert!((hand.in_force() - 1.0).abs() < 0.001);
}

fn a_second_alarm_waits(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordering(mill);
    hand.chatter_hz = None;
    hand.go(0.04);
    hand.chatter_hz = Some(1.01 * CHATTER_HZ);
    hand.go(0.1);
    assert_eq!((hand.orders(), hand.ends()), (1, vec![]));
    drop(hand);
    mill.say("abort");
    back(mill);
}

fn a_clamped_override_is_given_back(mill: &mut LinuxCnc) {
    an_override_that_stays_is_given_back(mill, 0.95);
}

fn a_refused_override_is_given_back(mill: &mut LinuxCnc) {
    an_override_that_stays_is_given_back(mill, 1.0);
}

/// HAL takes none below this.
fn an_override_that_stays_is_given_back(mill: &mut LinuxCnc, least: f64) {
    let mut hand = Hand::on(mill);
    mill.say(&format!("hal sets rarma-least {least}"));
    hand.chatter_hz = Some(CHATTER_HZ);
    hand.go(0.1);
    hand.chatter_hz = None;
    hand.go(2.0);
    hand.given_back(mill, "refused");
    mill.say("hal sets rarma-least 0.5");
}

fn a_speed_that_is_not_reached_is_given_back(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordered(mill);
    mill.say("hal setp limit_speed.max 9000");
    hand.go(2.0);
    mill.say("hal setp limit_speed.max 100000");
    hand.given_back(mill, "speed");
}

/// HAL gives back by itself.
fn a_cut_link_gives_back(mill: &mut LinuxCnc) {
    let hand = Hand::ordering(mill);
    assert!(mill.factor() < 1.0);
    drop(hand);
    println!("link cut: back after {:.2} s", back(mill));
    mill.say("abort");
}

/// The link stands.
fn a_program_that_hangs_gives_back(mill: &mut LinuxCnc) {
    let hand = Hand::ordered(mill);
    println!("nothing said: back after {:.2} s", back(mill));
    drop(hand);
    mill.say("abort");
}

/// Whatever is said to it.
fn hal_keeps_its_limits_and_its_rate(mill: &mut LinuxCnc) {
    mill.say("run 11000 60");
    let mut raw = TcpStream::connect(COMPONENT).expect("it listens");
    let begun = Instant::now();
    let mut before = (0.0, 1.0);
    while begun.elapsed() < Duration::from_secs(1) {
        raw.write_all(b"{\"factor\":{\"spindle\":5.0,\"feed\":false}}\n")
            .expect("said");
        let now = (begun.elapsed().as_secs_f64(), mill.factor());
        let most = before.1 + (now.0 - before.0) + 0.1;
        assert!(
            now.1 <= HAL_MOST + 1e-9 && now.1 <= most,
            "{now:?}, {before:?}"
        );
        before = now;
        thread::sleep(Duration::from_millis(20));
    }
    assert!((before.1 - HAL_MOST).abs() < 1e-6, "{before:?}");
    drop(raw);
    println!(
        "sent 5: HAL took {HAL_MOST}, back after {:.2} s",
        back(mill)
    );
    mill.say("abort");
}

/// The program itself, which cannot give back any more: HAL does.
fn a_killed_program_gives_back(mill: &mut LinuxCnc) {
    let folder = Folder::default();
    let mut acting = ordering_program(mill, &folder);
    acting.signal("KILL");
    println!("rarma killed: back after {:.2} s", back(mill));
    let ended = acting.ended();
    assert_eq!(ended.code, None, "{ended:?}");
    let acts = acts(&folder.path().join("act.jsonl"));
    assert!(!acts.iter().any(|act| act == "ends"), "{acts:?}");
    mill.say("abort");
}

/// Which ends the link: said, and HAL gives back after the time that is shipped.
fn a_killed_component_gives_back(mill: &mut LinuxCnc) {
    let mut hand = Hand::ordered(mill);
    let ordered = mill.factor();
    assert!(ordered < 0.95, "{ordered}");
    let shipped_s = mill.dead_man_as_shipped();
    let killed = Instant::now();
    mill.say("kill");
    let begins_s = loop {
        if mill.factor() > ordered + 0.001 {
            break killed.elapsed().as_secs_f64();
        }
        assert!(killed.elapsed() < Duration::from_secs(3), "{ordered}");
        thread::sleep(Duration::from_millis(5));
    };
    println!(
        "component killed: HAL goes back after {begins_s:.2} s, is back {:.2} s later",
        back(mill)
    );
    // The last beat is 0.02 s older at most; what is added is a busy computer, and less than the longer time would be.
    assert!(
        (shipped_s - 0.02..shipped_s + 0.4).contains(&begins_s),
        "{begins_s} s, shipped: {shipped_s} s"
    );
    hand.go(3.0);
    let gone = |what: &What| matches!(what, What::Gone { .. });
    assert!(hand.said.iter().any(gone), "{:#?}", hand.said);
    assert!(!hand.actor.holds());
}

/// `rarma act` with an order in force.
fn ordering_program(mill: &mut LinuxCnc, folder: &Folder) -> Acting {
    mill.run_up(RPM);
    let log = folder.path().join("act.jsonl");
    let options = format!(
        "--controller linuxcnc --act --override 80:120 --log {}",
        log.display()
    );
    let mut acting = Acting::begin(rarma!(), folder.path(), &options);
    acting.until("an order stands", || mill.factor() < 0.95);
    acting
}
