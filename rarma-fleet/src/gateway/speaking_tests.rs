//! What a box hears of a controller, told by a box of three rules: one host in control, its answers, its mode.

use super::*;
use crate::gateway::link::Counts;
use rarma_box::guard::Stage;
use rarma_box::settings::SettingValue;
use rarma_box::wire::{
    ControlMessage, Deframer, Handed, Identity, NOBODY, Reply, Started, Status, VERSION, open,
};

/// The other end: keeps what is said, and answers when it is asked to.
struct Desk {
    said: Vec<(u32, u32, Command)>,
    answered: usize,
    holder: ControlMessage,
    mode: Mode,
    refuses: Option<Refused>,
}

impl Link for Desk {
    fn listen(&mut self, _: &mut dyn FnMut(Head, Telemetry)) -> Result<bool, String> {
        Ok(true)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), String> {
        let mut deframer = Deframer::default();
        for &byte in frame {
            if let Some(Ok(stuffed)) = deframer.collect(byte) {
                let mut plain = [0; MAX_FRAME];
                let opened = open(stuffed, &mut plain).unwrap();
                let (order, _) = opened.order().unwrap();
                self.said
                    .push((opened.head.sequence, order.by, order.command));
            }
        }
        Ok(())
    }

    fn answers(&self) -> bool {
        true
    }

    fn counts(&self) -> Counts {
        Counts::default()
    }
}

const OTHER: u32 = 0xBEEF;

fn head() -> Head {
    Head {
        version: VERSION,
        session: 7,
        sequence: 0,
        crc: 0,
    }
}

impl Desk {
    fn new(mode: Mode) -> Self {
        Self {
            said: Vec::new(),
            answered: 0,
            holder: ControlMessage {
                turn: 1,
                by: NOBODY,
                why: Handed::Start,
                key: false,
            },
            mode,
            refuses: None,
        }
    }

    fn held_by(&mut self, by: u32, why: Handed) -> Telemetry {
        let turn = self.holder.turn + 1;
        self.holder = ControlMessage {
            turn,
            by,
            why,
            key: false,
        };
        Telemetry::Control(self.holder)
    }

    fn status(&self) -> Telemetry {
        Telemetry::Status(Status {
            now_us: 0,
            mode: self.mode,
            stage: Stage::Off,
            energised: false,
            contacts: (false, true),
            fault: None,
            current_a: [0.0; 4],
            heat: 0.0,
            gap_m: [0.0; 2],
            pressure_pa: 0.0,
            gauge_m: 0.0,
            supply_v: 0.0,
            limiting: false,
            press_again: false,
            control: self.holder,
        })
    }

    /// What it says to the last command that it has not answered.
    fn answer(&mut self) -> Vec<Telemetry> {
        let Some(&(to, by, command)) = self.said.get(self.answered) else {
            return Vec::new();
        };
        self.answered += 1;
        let refused = self.refuses.map(Answer::Refused);
        let mut says = Vec::new();
        let answer = match (command, refused) {
            (Command::Identify, _) => Answer::Identity(Identity {
                board: "desk".try_into().unwrap(),
                version: "0".try_into().unwrap(),
                schema: 1,
                settings: 1,
                sample_rate_hz: 48_000.0,
                loop_rate_hz: 48_000.0,
                started: Started::PowerOn,
                before: None,
                control: self.holder,
            }),
            (_, Some(refused)) => refused,
            (Command::Take { .. }, _) => {
                says.push(self.held_by(by, Handed::Taken));
                Answer::Done
            }
            (Command::Release, _) => {
                says.push(self.held_by(NOBODY, Handed::GivenUp));
                Answer::Done
            }
            _ => Answer::Done,
        };
        says.push(Telemetry::Reply(Reply { by, to, answer }));
        says
    }
}

struct Bench {
    speaking: Speaking,
    desk: Desk,
    news: Vec<News>,
}

impl Bench {
    /// Both know each other, and no question is open.
    fn new(mode: Mode) -> Self {
        let mut bench = Self {
            speaking: Speaking::new(77, None),
            desk: Desk::new(mode),
            news: Vec::new(),
        };
        bench.go();
        let status = bench.desk.status();
        bench.hears(&status);
        bench.speaking.questions.clear();
        assert_eq!(bench.said(), [Command::Identify]);
        bench
    }

    fn hears(&mut self, message: &Telemetry) {
        self.speaking.hears(&head(), message, &mut self.news);
    }

    /// One command and its answer.
    fn go(&mut self) {
        self.speaking.go_on(&mut self.desk, &mut self.news).unwrap();
        for message in self.desk.answer() {
            self.hears(&message);
        }
    }

    fn said(&mut self) -> Vec<Command> {
        self.desk.answered = 0;
        self.desk.said.drain(..).map(|(.., said)| said).collect()
    }

    fn tell(&mut self, told: Told) {
        self.speaking.tell(told, Instant::now());
    }
}

fn teeth(teeth: u32) -> Command {
    Command::Set {
        setting: MONITOR_TEETH.number(),
        value: SettingValue::Whole(teeth),
    }
}

fn hz(hz: f32) -> Command {
    Command::Set {
        setting: MONITOR_SPINDLE.number(),
        value: SettingValue::Real(hz),
    }
}

#[test]
fn speed_and_teeth_are_told_in_one_turn_which_is_given_up() {
    let mut bench = Bench::new(Mode::Monitor);
    bench.tell(Told::Teeth(4));
    bench.tell(Told::Speed(6000.0));
    for _ in 0..8 {
        bench.go();
    }
    let take = Command::Take { turn: 1 };
    let said = [
        take,
        hz(100.0),
        teeth(4),
        Command::Start(Mode::Monitor),
        Command::Release,
    ];
    assert_eq!(bench.said(), said);
    let taken = [
        News::Taken(Told::Speed(6000.0)),
        News::Taken(Told::Teeth(4)),
    ];
    assert_eq!(bench.news, taken);
    assert!(bench.speaking.rest().is_empty());
}

#[test]
fn a_box_that_does_not_monitor_is_not_started() {
    let mut bench = Bench::new(Mode::Cers);
    bench.tell(Told::Teeth(3));
    for _ in 0..6 {
        bench.go();
    }
    let take = Command::Take { turn: 1 };
    assert_eq!(bench.said(), [take, teeth(3), Command::Release]);
}

/// Between the number of teeth and the start somebody else takes the box, and gives it back in another mode.
#[test]
fn what_is_cut_off_is_begun_anew_and_by_the_mode_of_then() {
    let mut bench = Bench::new(Mode::Monitor);
    bench.tell(Told::Teeth(4));
    bench.go();
    bench.go();
    assert_eq!(bench.said(), [Command::Take { turn: 1 }, teeth(4)]);
    assert!(bench.news.is_empty(), "not done yet: {:?}", bench.news);
    let taken = bench.desk.held_by(OTHER, Handed::Taken);
    bench.hears(&taken);
    bench.go();
    assert!(bench.said().is_empty(), "the box is another host's");
    bench.desk.mode = Mode::Ldbb;
    let status = bench.desk.status();
    bench.hears(&status);
    let free = bench.desk.held_by(NOBODY, Handed::GivenUp);
    bench.hears(&free);
    for _ in 0..4 {
        bench.go();
    }
    let take = Command::Take { turn: 4 };
    assert_eq!(bench.said(), [take, teeth(4), Command::Release]);
    assert_eq!(bench.news, [News::Taken(Told::Teeth(4))]);
}

#[test]
fn what_overtakes_a_value_on_its_way_is_told_too() {
    let mut bench = Bench::new(Mode::Monitor);
    bench.tell(Told::Speed(6000.0));
    bench.go();
    bench
        .speaking
        .go_on(&mut bench.desk, &mut bench.news)
        .unwrap();
    bench.tell(Told::Speed(9000.0));
    for message in bench.desk.answer() {
        bench.hears(&message);
    }
    bench.go();
    bench.go();
    let take = Command::Take { turn: 1 };
    let said = [take, hz(100.0), hz(150.0), Command::Release];
    assert_eq!(bench.said(), said);
    let taken = [6000.0, 9000.0].map(|rpm| News::Taken(Told::Speed(rpm)));
    assert_eq!(bench.news, taken);
}

#[test]
fn another_hosts_box_is_waited_for_but_not_for_ever() {
    let mut bench = Bench::new(Mode::Monitor);
    let taken = bench.desk.held_by(OTHER, Handed::Taken);
    bench.hears(&taken);
    bench.tell(Told::Speed(6000.0));
    bench.go();
    assert!(bench.said().is_empty() && bench.news.is_empty());
    // The one before it came long ago, and nobody asks for it any more.
    let long_ago = Instant::now().checked_sub(FRESH + Duration::from_secs(1));
    bench.speaking.tell(Told::Teeth(4), long_ago.unwrap());
    bench.go();
    let why = "not told: 4 teeth: host 0000beef is in control of the box".to_owned();
    assert_eq!(bench.news, [News::Refused(why)]);
    let free = bench.desk.held_by(NOBODY, Handed::GivenUp);
    bench.hears(&free);
    for _ in 0..3 {
        bench.go();
    }
    let take = Command::Take { turn: 3 };
    assert_eq!(bench.said(), [take, hz(100.0), Command::Release]);
}

#[test]
fn a_value_that_is_overtaken_all_the_time_is_said_to_wait() {
    let mut bench = Bench::new(Mode::Monitor);
    let taken = bench.desk.held_by(OTHER, Handed::Taken);
    bench.hears(&taken);
    let ago = |s| Instant::now().checked_sub(Duration::from_secs(s)).unwrap();
    bench.speaking.tell(Told::Speed(1.0), ago(11));
    bench.speaking.tell(Told::Speed(2.0), ago(0));
    bench.go();
    let why = "not told: host 0000beef is in control of the box".to_owned();
    assert_eq!(bench.news, [News::Refused(why)]);
    assert_eq!(bench.speaking.told.first(), Some(&Told::Speed(2.0)));
}

#[test]
fn a_box_without_a_key_and_one_with_another_say_so() {
    for (refused, says) in [(Refused::NoKey, "no key"), (Refused::Seal, "the key is")] {
        let mut bench = Bench::new(Mode::Monitor);
        bench.desk.refuses = Some(refused);
        bench.tell(Told::Teeth(4));
        for _ in 0..3 {
            bench.go();
        }
        assert_eq!(bench.said(), [Command::Take { turn: 1 }], "asked once");
        let [News::Refused(why)] = &bench.news[..] else {
            panic!("{:?}", bench.news);
        };
        assert!(why.starts_with("not told: ") && why.contains(says), "{why}");
    }
}
