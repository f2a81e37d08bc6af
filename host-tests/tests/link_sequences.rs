//! Promise: what has been said once does not count twice, nobody changes anything whose turn it
//! is not, and nothing comes on again after a trip by itself. The table in docs/box.md is what
//! this run makes: sequences of frames, and what the box did.
//!
//! `cargo test --release -p host-tests --test link_sequences`

use firmware::board::Origin;
use hal_sim::rig::{FaultEvent, FaultKind};
use host_tests::link_bench::{Bench, Frame, KEY};
use rarma_box::guard::{Denial, Stage};
use rarma_box::settings::{LINK_KEY, SettingValue};
use rarma_box::wire::{Answer, Command, Handed, LinkKey, Refused, Telemetry};
use rarma_cli::frames::answer_words;
use std::path::Path;

/// A bench, and what has happened on it so far.
struct Story {
    bench: Bench,
    happened: Vec<String>,
}

impl Story {
    fn new(bench: Bench) -> Self {
        Self {
            bench,
            happened: Vec::new(),
        }
    }

    /// The first host is in control and its outputs are on.
    fn armed(bench: Bench) -> Self {
        let mut story = Self::new(bench);
        story.bench.armed();
        story.note("A has armed");
        story
    }

    fn note(&mut self, text: &str) {
        self.happened.push(text.to_owned());
    }

    fn answered(&mut self, what: &str, answer: &Answer) {
        self.happened
            .push(format!("{what} → {}", answer_words(answer)));
    }

    /// A host says something that `expected` comes of.
    #[track_caller]
    fn say(&mut self, host: u32, words: &str, command: Command, expected: &Answer) {
        let name = if host == 1 { "A" } else { "B" };
        let answer = self.bench.ask(host, command);
        self.answered(&format!("{name} `{words}`"), &answer);
        assert_eq!(&answer, expected, "{:?}", self.happened);
    }

    /// A frame comes, whatever its age.
    #[track_caller]
    fn comes(&mut self, what: &str, frame: &Frame, expected: &Answer) {
        let answer = self.bench.come(frame);
        self.answered(what, &answer);
        assert_eq!(&answer, expected, "{:?}", self.happened);
    }

    /// The outputs are on or off, and stay so.
    #[track_caller]
    fn outputs(&mut self, on: bool) {
        self.bench.run(0.4);
        assert_eq!(self.bench.is_on(), on, "{:?}", self.happened);
        assert_eq!(self.bench.all.rig.outputs_on(), on);
        self.note(if on { "outputs on" } else { "outputs off" });
    }

    fn stop(&mut self) {
        self.say(1, "stop", Command::Stop, &DONE);
        self.bench.run(0.4);
    }
}

const DONE: Answer = Answer::Done;
const TAKE: Command = Command::Take { turn: 0 };
const ENABLE_HELD: Answer = Answer::Refused(Refused::Denied(Denial::EnableHeld));

const fn refused(why: Refused) -> Answer {
    Answer::Refused(why)
}

/// Everything that the host in control may say and that could put energy into the outputs.
fn repeats() -> Vec<(&'static str, Story)> {
    let mut rows = Vec::new();

    let mut story = Story::new(Bench::default());
    let arm = story.bench.take_and_arm();
    story.note("A has armed");
    story.bench.run(0.4);
    story.stop();
    story.say(1, "status", Command::Status, &DONE);
    story.comes("copy of `arm`", &arm, &DONE);
    story.note("answered from what was answered, not carried out");
    story.outputs(false);
    rows.push(("`arm`, `stop`, another frame, a copy of `arm`", story));

    let mut story = Story::new(Bench::default());
    let arm = story.bench.take_and_arm();
    story.bench.run(0.4);
    story.stop();
    for _ in 0..3 {
        story.say(1, "quiet", Command::Quiet, &DONE);
    }
    story.comes("copy of `arm`", &arm, &refused(Refused::Repeated));
    story.outputs(false);
    rows.push(("the same, after its answer is not kept any more", story));

    let mut story = Story::new(Bench::default());
    let arm = story.bench.take_and_arm();
    story.stop();
    story.bench.run(7.0);
    story.note("70 heartbeats");
    story.comes("copy of `arm`", &arm, &refused(Refused::Old));
    story.outputs(false);
    rows.push(("a copy of `arm`, more than 64 frames late", story));

    let mut story = Story::new(Bench::default());
    story.say(1, "take", TAKE, &DONE);
    story.bench.beats = true;
    let arm = story.bench.make(1, Command::Arm);
    story.note("`arm` held back");
    story.stop();
    story.comes("`arm` comes", &arm, &refused(Refused::Overtaken));
    story.outputs(false);
    rows.push(("an `arm` that a `stop` has overtaken", story));

    let mut story = Story::new(Bench::default());
    story.say(1, "take", TAKE, &DONE);
    let stop = story.bench.make(1, Command::Stop);
    story.note("`stop` held back");
    story.bench.armed();
    story.note("A has armed");
    story.comes("`stop` comes", &stop, &DONE);
    story.outputs(false);
    rows.push(("a `stop` that an `arm` has overtaken", story));

    let mut story = Story::armed(Bench::default());
    story.stop();
    story.say(1, "release", Command::Release, &DONE);
    let before = story.bench.said.clone();
    story.say(1, "take", TAKE, &DONE);
    story.bench.run(0.2);
    story.replay("the whole of A's last turn again", before);
    story.outputs(false);
    rows.push(("a turn that is over, replayed in the next one", story));

    let mut story = Story::armed(Bench::default());
    let before = story.bench.said.clone();
    story.bench.restart();
    story.note("the box restarts");
    story.bench.press_again(100);
    story.say(1, "take", TAKE, &DONE);
    story.say(1, "clear", Command::Clear, &DONE);
    let mode = rarma_box::guard::Mode::Cers;
    story.say(1, "start cers", Command::Start(mode), &DONE);
    story.bench.beats = true;
    story.replay("the whole session before it again", before);
    story.outputs(false);
    rows.push(("a session, replayed after a restart", story));
    rows
}

impl Story {
    /// Everything that was said, once more, in order. Nothing may come on in it.
    fn replay(&mut self, what: &str, frames: Vec<Vec<u8>>) {
        let mut counts = std::collections::BTreeMap::<String, u32>::new();
        for bytes in &frames {
            self.bench.all.host.heard.clear();
            self.bench.all.rig.link.host_sends(bytes);
            self.bench.run(0.01);
            assert!(!self.bench.is_on(), "{:?}", self.happened);
            for heard in &self.bench.all.host.heard {
                if let Telemetry::Reply(reply) = &heard.message
                    && matches!(reply.answer, Answer::Refused(_))
                {
                    *counts.entry(answer_words(&reply.answer)).or_default() += 1;
                }
            }
        }
        assert!(!counts.is_empty(), "nothing of it is refused");
        let words: Vec<_> = counts.into_keys().collect();
        self.happened.push(format!("{what} → {}", words.join("; ")));
    }
}

/// Two hosts.
fn hands() -> Vec<(&'static str, Story)> {
    let mut rows = Vec::new();

    let mut story = Story::armed(Bench::default());
    let not = refused(Refused::NotInControl);
    story.say(2, "status", Command::Status, &DONE);
    for (words, command) in [
        ("arm", Command::Arm),
        ("current 1.5", Command::Current { a: 1.5 }),
        ("heartbeat", Command::Heartbeat),
    ] {
        story.say(2, words, command, &not);
    }
    story.outputs(true);
    rows.push(("a second host that has not taken control", story));

    let mut story = Story::armed(Bench::default());
    let late = story.bench.make(1, Command::Arm);
    story.say(2, "take", TAKE, &DONE);
    assert_eq!(story.bench.all.app.supervisor().stage(), Stage::Stopping);
    assert!(!story.bench.all.host.speaker.in_control() && story.bench.second.speaker.in_control());
    story.bench.beats = false;
    story.note("both are told");
    story.bench.run(0.4);
    assert!(!story.bench.is_on());
    story.comes("A's `arm` comes", &late, &not);
    story.say(1, "arm", Command::Arm, &not);
    story.say(2, "heartbeat", Command::Heartbeat, &DONE);
    story.say(2, "arm", Command::Arm, &ENABLE_HELD);
    story.outputs(false);
    story.bench.press_again(100);
    story.note("released and pressed");
    story.say(2, "heartbeat", Command::Heartbeat, &DONE);
    story.say(2, "arm", Command::Arm, &DONE);
    rows.push(("a second host takes over while outputs are on", story));

    let mut story = Story::new(Bench::default());
    let (a, b) = (story.bench.make(1, TAKE), story.bench.make(2, TAKE));
    story.comes("A `take`", &a, &DONE);
    story.comes(
        "B `take`, made at the same time",
        &b,
        &refused(Refused::Turn),
    );
    story.comes("copy of A's `take`", &a, &refused(Refused::Turn));
    assert!(story.bench.all.host.speaker.in_control());
    story.outputs(false);
    rows.push(("both take control at once", story));

    let mut story = Story::armed(Bench::default());
    let late = story.bench.make(1, Command::Arm);
    story.say(2, "stop", Command::Stop, &DONE);
    story.bench.run(0.4);
    story.comes("A's `arm` comes", &late, &not);
    story.outputs(false);
    let why = story.bench.all.host.speaker.control().map(|c| c.why);
    assert_eq!(why, Some(Handed::Stopped));
    rows.push(("a second host says `stop`, an `arm` is on its way", story));

    let mut story = Story::armed(Bench::default());
    let (beat, arm) = (
        story.bench.make(1, Command::Heartbeat),
        story.bench.make(1, Command::Arm),
    );
    story.bench.beats = false;
    story.note("A is cut off");
    story.bench.run(0.7);
    let fault = story.bench.all.app.supervisor().fault().expect("a trip");
    story.note(&format!("{} after 0.5 s", fault.code.name()));
    story.outputs(false);
    story.comes("what it had on its way: heartbeat", &beat, &not);
    story.comes("`arm`", &arm, &not);
    story.say(1, "take", TAKE, &DONE);
    story.say(1, "clear", Command::Clear, &DONE);
    story.say(1, "heartbeat", Command::Heartbeat, &DONE);
    story.say(1, "arm", Command::Arm, &ENABLE_HELD);
    story.outputs(false);
    rows.push(("the connection of the host in control is cut", story));

    let mut story = Story::armed(Bench::default());
    story.say(1, "release", Command::Release, &DONE);
    story.bench.beats = false;
    story.say(1, "arm", Command::Arm, &not);
    story.outputs(false);
    rows.push(("the host in control goes", story));
    rows
}

/// Trips.
fn edges() -> Vec<(&'static str, Story)> {
    let mut rows = Vec::new();

    let mut story = Story::armed(Bench::default());
    story.bench.all.rig.contacts.stop_chain = false;
    story.bench.run(0.1);
    story.note("emergency stop pressed");
    story.bench.all.rig.contacts.stop_chain = true;
    story.bench.run(0.1);
    story.note("and pulled out");
    story.say(1, "clear", Command::Clear, &DONE);
    story.say(1, "arm", Command::Arm, &ENABLE_HELD);
    story.outputs(false);
    story.bench.press_again(100);
    story.note("released and pressed");
    story.say(1, "arm", Command::Arm, &DONE);
    story.outputs(true);
    rows.push(("emergency stop, `arm` with the enable input held", story));

    let mut story = Story::armed(Bench::default());
    let from_us = story.bench.all.rig.world_us();
    story.bench.all.rig.add_fault(FaultEvent {
        kind: FaultKind::CurrentSurge,
        place: 0,
        from_us,
        to_us: from_us + 100_000,
    });
    story.bench.run(0.3);
    let fault = story.bench.all.app.supervisor().fault().expect("a trip");
    story.note(fault.code.name());
    story.say(1, "clear", Command::Clear, &DONE);
    story.say(1, "arm", Command::Arm, &ENABLE_HELD);
    story.bench.press_again(20);
    story.note("open for 20 ms");
    story.say(1, "arm", Command::Arm, &ENABLE_HELD);
    story.outputs(false);
    story.bench.press_again(100);
    story.note("released and pressed");
    story.say(1, "arm", Command::Arm, &DONE);
    story.outputs(true);
    rows.push(("a trip, `arm` with the enable input held", story));
    rows
}

/// The key.
fn keys() -> Vec<(&'static str, Story)> {
    let mut rows = Vec::new();
    let other = LinkKey([7; 32]);
    let set = |key| Command::Set {
        setting: LINK_KEY.number(),
        value: SettingValue::Key(key),
    };
    let read = Command::Read {
        setting: LINK_KEY.number(),
    };

    let mut story = Story::new(Bench::new(None, Origin::Network));
    story.say(1, "take", TAKE, &refused(Refused::NoKey));
    story.say(1, "arm", Command::Arm, &refused(Refused::NoKey));
    story.say(1, "set link.key", set(KEY), &refused(Refused::OwnPort));
    story.say(1, "status", Command::Status, &DONE);
    story.say(1, "stop", Command::Stop, &DONE);
    story.outputs(false);
    rows.push(("over a network, the box has no key", story));

    let mut story = Story::new(Bench::new(Some(KEY), Origin::Network));
    for (name, key) in [("no seal", None), ("another key", Some(other))] {
        story.bench.all.host.speaker.set_key(key);
        story.note(name);
        story.say(1, "take", TAKE, &refused(Refused::Seal));
        story.say(1, "arm", Command::Arm, &refused(Refused::Seal));
    }
    story.outputs(false);
    rows.push(("over a network, the wrong key", story));

    let mut story = Story::armed(Bench::new(Some(KEY), Origin::Network));
    story.outputs(true);
    let first = story.bench.said.clone();
    let shown = story.bench.ask(1, read);
    assert!(
        matches!(&shown, Answer::Setting(s) if s.value == SettingValue::Hidden(true)
            && s.stored == Some(SettingValue::Hidden(true))),
        "{shown:?}"
    );
    story.answered("A `read link.key`", &shown);
    story.say(1, "set link.key", set(other), &refused(Refused::OwnPort));
    story.stop();
    story.bench.run(0.2);
    story.replay("everything sealed so far again", first.clone());
    story.outputs(false);
    rows.push((
        "over a network, the right key; sealed frames replayed",
        story,
    ));

    let mut story = Story::armed(Bench::new(Some(KEY), Origin::Network));
    let before = story.bench.said.clone();
    story.bench.restart();
    story.note("the box restarts, the key is in its flash");
    story.bench.press_again(100);
    story.say(1, "take", TAKE, &DONE);
    story.say(1, "clear", Command::Clear, &DONE);
    let mode = rarma_box::guard::Mode::Cers;
    story.say(1, "start cers", Command::Start(mode), &DONE);
    story.replay("the sealed session before it again", before);
    story.bench.beats = true;
    story.bench.run(0.1);
    story.say(1, "arm", Command::Arm, &DONE);
    story.outputs(true);
    rows.push(("sealed frames of the session before", story));

    let mut story = Story::armed(Bench::new(Some(KEY), Origin::Network));
    let (n, mut changed) = story.bench.make(1, Command::Current { a: 1.0 });
    reseal(&mut changed);
    let answer = story.bench.come(&(n, changed));
    story.answered("A's `current 1.0`, changed to 2.0 on its way", &answer);
    assert_eq!(answer, refused(Refused::Seal));
    story.outputs(true);
    rows.push(("a sealed frame, changed, its CRC made right", story));

    let mut story = Story::new(Bench::new(Some(KEY), Origin::OwnPort));
    story.bench.all.host.speaker.set_key(None);
    story.say(1, "take", TAKE, &refused(Refused::Seal));
    story.bench.all.rig.contacts.stop_chain = false;
    story.bench.run(0.1);
    story.note("emergency stop held");
    story.say(1, "take", TAKE, &DONE);
    let answer = story.bench.ask(1, set(other));
    assert!(matches!(answer, Answer::Setting(_)), "{answer:?}");
    story.answered("A `set link.key`", &answer);
    story.bench.all.rig.contacts.stop_chain = true;
    story.bench.run(0.1);
    story.note("and pulled out");
    story.say(1, "clear", Command::Clear, &refused(Refused::Seal));
    story.bench.all.host.speaker.set_key(Some(other));
    story.say(1, "clear, sealed", Command::Clear, &DONE);
    story.outputs(false);
    rows.push(("at its own port, the key is lost", story));
    rows
}

/// Makes the current of a sealed frame 2 A, and its CRC right again.
fn reseal(frame: &mut Vec<u8>) {
    let mut plain = vec![0; frame.len()];
    let n = cobs_decode(&frame[..frame.len() - 1], &mut plain);
    plain.truncate(n);
    let (one, two) = (1.0f32.to_le_bytes(), 2.0f32.to_le_bytes());
    let at = plain.windows(4).position(|w| w == one).expect("1 A");
    plain[at..at + 4].copy_from_slice(&two);
    let end = plain.len() - 2;
    let crc = crc16(&plain[..end]).to_le_bytes();
    plain[end..].copy_from_slice(&crc);
    *frame = cobs_encode(&plain);
}

/// CRC-16/IBM-SDLC, bit by bit.
fn crc16(bytes: &[u8]) -> u16 {
    let step = |crc: u16| (crc >> 1) ^ (0x8408 * (crc & 1));
    let crc = bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| step(crc))
    });
    !crc
}

fn cobs_decode(stuffed: &[u8], plain: &mut [u8]) -> usize {
    let (mut at, mut used) = (0, 0);
    while at < stuffed.len() {
        let code = usize::from(stuffed[at]);
        for &byte in &stuffed[at + 1..at + code] {
            plain[used] = byte;
            used += 1;
        }
        at += code;
        if code < 255 && at < stuffed.len() {
            plain[used] = 0;
            used += 1;
        }
    }
    used
}

/// For plain bytes shorter than 254.
fn cobs_encode(plain: &[u8]) -> Vec<u8> {
    let parts = plain.split(|byte| *byte == 0);
    let mut out: Vec<u8> = parts
        .flat_map(|part| std::iter::once(part.len() as u8 + 1).chain(part.iter().copied()))
        .collect();
    out.push(0);
    out
}

fn written(table: &str) {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/box.md");
    let text = std::fs::read_to_string(&page).expect("docs/box.md");
    let (head, rest) = text.split_once("<!-- sequences -->\n").expect("a marker");
    let (old, tail) = rest.split_once("<!-- end -->").expect("a marker");
    if std::env::var_os("RARMA_WRITE_TABLE").is_some() {
        let new = format!("{head}<!-- sequences -->\n{table}<!-- end -->{tail}");
        std::fs::write(&page, new).expect("docs/box.md");
        return;
    }
    assert_eq!(old, table, "RARMA_WRITE_TABLE=1 writes it");
}

#[test]
fn sequences_and_what_the_box_does() {
    let mut table = String::from("| sequence | the box |\n|---|---|\n");
    for (name, story) in [repeats(), hands(), edges(), keys()].into_iter().flatten() {
        table += &format!("| {name} | {} |\n", story.happened.join("; "));
    }
    println!("{table}");
    written(&table);
}
