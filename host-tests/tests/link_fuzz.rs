//! Promise: no bytes whatever make the box fall over, switch an output on, or lose step
//! for longer than one frame.
//!
//! Always: some hundred thousand frames' worth. For ten minutes each:
//! `cargo test --release -p host-tests --test link_fuzz -- --ignored --nocapture`.

use hal_sim::rig::{RigSetUp, SimBox, SimRig};
use host_tests::rig::{answer, quiet, working};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::Mode;
use rarma_box::settings::SettingValue;
use rarma_box::wire::{
    Answer, Command, Deframer, MAX_FRAME, Order, Refused, Telemetry, decode, encode, encode_order,
    head, open,
};
use std::time::{Duration, Instant};

fn value() -> impl Strategy<Value = SettingValue> {
    prop_oneof![
        any::<u32>().prop_map(SettingValue::Whole),
        any::<u32>().prop_map(|bits| SettingValue::Real(f32::from_bits(bits))),
    ]
}

fn mode() -> impl Strategy<Value = Mode> {
    prop_oneof![
        Just(Mode::Safe),
        Just(Mode::Monitor),
        Just(Mode::Cers),
        Just(Mode::Ldbb)
    ]
}

/// Every command but those that could rightly switch an output on.
fn command() -> impl Strategy<Value = Command> {
    let setting = || prop_oneof![0u16..90, any::<u16>()];
    let real = || any::<u32>().prop_map(f32::from_bits);
    prop_oneof![
        Just(Command::Identify),
        Just(Command::Stop),
        Just(Command::Clear),
        Just(Command::Status),
        Just(Command::Arm),
        Just(Command::Release),
        any::<u32>().prop_map(|turn| Command::Take { turn }),
        setting().prop_map(|setting| Command::Read { setting }),
        setting().prop_map(|setting| Command::Save { setting }),
        setting().prop_map(|setting| Command::Reset { setting }),
        (setting(), value()).prop_map(|(setting, value)| Command::Set { setting, value }),
        mode().prop_map(Command::Start),
        real().prop_map(|seconds| Command::Stream { seconds }),
        real().prop_map(|pa| Command::Pressure { pa }),
        real().prop_map(|a| Command::Current { a }),
    ]
}

fn frame(order: &Order, session: u32, sequence: u32) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    encode_order(order, session, sequence, None, &mut buffer)
        .expect("fits")
        .to_vec()
}

/// One stretch of a hostile link.
#[derive(Debug, Clone)]
enum Piece {
    Garbage(Vec<u8>),
    Whole(Command, u32),
    Cut(Command, u32, usize),
    Flipped(Command, u32, usize),
    Doubled(Command, u32),
}

fn piece() -> impl Strategy<Value = Piece> {
    prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..400).prop_map(Piece::Garbage),
        (command(), any::<u32>()).prop_map(|(c, s)| Piece::Whole(c, s)),
        (command(), any::<u32>(), 0usize..30).prop_map(|(c, s, n)| Piece::Cut(c, s, n)),
        (command(), any::<u32>(), 0usize..200).prop_map(|(c, s, n)| Piece::Flipped(c, s, n)),
        (command(), any::<u32>()).prop_map(|(c, s)| Piece::Doubled(c, s)),
    ]
}

/// The bytes of a piece; one frame in eight is for another session, one in five by somebody
/// whose turn it is not.
fn bytes(piece: &Piece, session: u32, turn: u32) -> Vec<u8> {
    let frame = |c: &Command, s: u32| {
        let by = turn ^ u32::from(s.is_multiple_of(5));
        let command = *c;
        let session = session ^ u32::from(s.is_multiple_of(8));
        frame(&Order { by, command }, session, 1 + s % 300)
    };
    match piece {
        Piece::Garbage(bytes) => bytes.clone(),
        Piece::Whole(c, s) => frame(c, *s),
        Piece::Cut(c, s, n) => {
            let whole = frame(c, *s);
            whole[..*n % whole.len()].to_vec()
        }
        Piece::Flipped(c, s, n) => {
            let mut whole = frame(c, *s);
            let bit = n % (8 * whole.len());
            whole[bit / 8] ^= 1 << (bit % 8);
            whole
        }
        Piece::Doubled(c, s) => [frame(c, *s), frame(c, *s)].concat(),
    }
}

/// The parser alone: any bytes, and the next whole frame after a zero is read.
fn parse(bytes: &[u8]) {
    let _ = head(bytes);
    let _ = open(bytes, &mut [0; MAX_FRAME]).map(|frame| frame.order().is_ok());
    let _ = decode::<Order>(bytes);
    let _ = decode::<Telemetry>(bytes);
    let mut deframer = Deframer::default();
    let mut last = None;
    let identify = Order {
        by: 6,
        command: Command::Identify,
    };
    let good = frame(&identify, 5, 77);
    for &b in bytes.iter().chain(&[0]).chain(&good) {
        if let Some(result) = deframer.push::<Order>(b) {
            last = Some(result);
        }
    }
    let (head, command) = last.expect("a frame").expect("a whole one");
    assert_eq!((head.session, head.sequence), (5, 77));
    assert_eq!(command, identify);
}

fn parser_for(cases: u32, time: Option<Duration>) -> u64 {
    let begun = Instant::now();
    let mut runs = 0u64;
    loop {
        let mut runner = TestRunner::new(Config {
            cases,
            failure_persistence: None,
            ..Config::default()
        });
        runner
            .run(&proptest::collection::vec(piece(), 1..4), |pieces| {
                let all: Vec<u8> = pieces.iter().flat_map(|p| bytes(p, 5, 6)).collect();
                parse(&all);
                // A body of any bytes inside a sound frame.
                let mut rng = ChaCha8Rng::seed_from_u64(all.len() as u64);
                let mut body = all.clone();
                body.truncate(200);
                let _ = decode::<Order>(&body);
                if let Some(b) = body.first_mut() {
                    *b = rng.random();
                }
                parse(&body);
                Ok(())
            })
            .expect("no case fails");
        runs += u64::from(cases);
        if time.is_none_or(|t| begun.elapsed() > t) {
            return runs;
        }
    }
}

/// The whole box without an enable input and heartbeats: nothing may switch an output on.
fn box_for(cases: u32, time: Option<Duration>) -> (u64, u64) {
    let begun = Instant::now();
    let (mut runs, mut carried_out) = (0u64, 0u64);
    loop {
        let mut runner = TestRunner::new(Config {
            cases,
            failure_persistence: None,
            max_shrink_iters: 50,
            ..Config::default()
        });
        let mut all = SimBox::new(SimRig::new(RigSetUp::default(), quiet(5)));
        all.host.heartbeat_us = None;
        let all = std::cell::RefCell::new(all);
        runner
            .run(&proptest::collection::vec(piece(), 1..12), |pieces| {
                let mut all = all.borrow_mut();
                all.host.heard.clear();
                // A turn of its own, so that the numbers of the last stream are not old.
                all.send(&Command::Take { turn: 0 });
                all.run_for(0.001);
                let session = all.host.session();
                let turn = all.host.speaker.control().map_or(0, |c| c.turn);
                for p in &pieces {
                    all.rig.link.host_sends(&bytes(p, session, turn));
                }
                let until = all.rig.world_us() + 2_000;
                while all.rig.world_us() < until || all.rig.link.waiting() > 0 {
                    all.step();
                    prop_assert!(!all.rig.outputs_on(), "an output came on");
                }
                // In step again at the next frame: a zero ends whatever stands there.
                all.rig.link.host_sends(&[0]);
                let to = all.send(&Command::Identify);
                all.run_for(0.002);
                let got = answer(&all, to);
                prop_assert!(matches!(got, Some(Answer::Identity(_))), "{:?}", got);
                Ok(())
            })
            .expect("no case fails");
        runs += u64::from(cases);
        let all = all.borrow();
        prop_counts(&all, &mut carried_out);
        if time.is_none_or(|t| begun.elapsed() > t) {
            return (runs, carried_out);
        }
    }
}

fn prop_counts(all: &SimBox, carried_out: &mut u64) {
    let health = all.app.health(0);
    assert_eq!(all.rig.last_on_us(), None);
    assert_eq!(all.resets, 0);
    assert!(
        health.garbage > 0 && health.refused > 0 && health.doubled > 0,
        "{health:?}"
    );
    *carried_out += u64::from(health.commands);
}

#[test]
fn parser_takes_any_bytes() {
    let runs = parser_for(200_000, None);
    println!("{runs} streams");
}

#[test]
fn box_takes_any_bytes_and_switches_nothing_on() {
    let (runs, commands) = box_for(20_000, None);
    println!("{runs} streams, {commands} commands answered");
}

#[test]
#[ignore = "ten minutes"]
fn parser_takes_any_bytes_long() {
    let runs = parser_for(50_000, Some(Duration::from_secs(600)));
    println!("{runs} streams in ten minutes");
}

#[test]
#[ignore = "ten minutes"]
fn box_takes_any_bytes_and_switches_nothing_on_long() {
    let (runs, commands) = box_for(5_000, Some(Duration::from_secs(600)));
    println!("{runs} streams in ten minutes, {commands} commands answered");
}

#[test]
fn every_command_is_answered_once_and_bad_ones_with_a_reason() {
    let mut all = working(Mode::Monitor, RigSetUp::default());
    let mut ask = |command: Command| {
        let to = all.send(&command);
        all.run_for(0.005);
        answer(&all, to).unwrap_or_else(|| panic!("{command:?} has no answer"))
    };
    assert!(matches!(ask(Command::Identify), Answer::Identity(_)));
    assert_eq!(ask(Command::Heartbeat), Answer::Done);
    let refused = [
        Command::Arm,
        Command::Read { setting: 4711 },
        Command::Set {
            setting: 13,
            value: SettingValue::Real(0.5),
        },
        Command::Set {
            setting: 13,
            value: SettingValue::Real(f32::NAN),
        },
        Command::Set {
            setting: 13,
            value: SettingValue::Whole(1),
        },
        Command::Save { setting: 4711 },
        Command::Stream { seconds: -1.0 },
        Command::Stream { seconds: f32::NAN },
        Command::Pressure { pa: 1e5 },
        Command::Current { a: 1.0 },
    ];
    for command in refused {
        let got = ask(command);
        assert!(matches!(got, Answer::Refused(_)), "{command:?}: {got:?}");
    }
    let set = ask(Command::Set {
        setting: 13,
        value: SettingValue::Real(0.02),
    });
    assert!(
        matches!(set, Answer::Setting(s) if s.value == SettingValue::Real(0.02) && s.stored.is_none())
    );
    let saved = ask(Command::Save { setting: 13 });
    assert!(matches!(saved, Answer::Setting(s) if s.stored == Some(SettingValue::Real(0.02))));
    let reset = ask(Command::Reset { setting: 13 });
    assert!(
        matches!(reset, Answer::Setting(s) if s.value == SettingValue::Real(0.01) && s.stored.is_none())
    );
}

#[test]
fn a_doubled_command_is_carried_out_once_and_a_strange_one_is_refused_by_its_number() {
    let mut all = working(Mode::Monitor, RigSetUp::default());
    let (to, bytes) = all.host.command(&Command::Stream { seconds: 0.05 });
    all.rig.link.host_sends(&bytes);
    all.rig.link.host_sends(&bytes);
    all.run_for(0.2);
    let answers = all.host.heard.iter().filter(
        |h| matches!(&h.message, Telemetry::Reply(r) if r.to == to && r.answer == Answer::Done),
    );
    assert_eq!(answers.count(), 2);
    let samples: usize = all
        .host
        .heard
        .iter()
        .map(|h| match &h.message {
            Telemetry::Raw(raw) => raw.len(),
            _ => 0,
        })
        .sum();
    assert_eq!(samples, 2400);
    assert_eq!(all.app.health(0).doubled, 1);
    // A whole frame whose body is no command.
    let mut buffer = [0; MAX_FRAME];
    let body = [200u8; 4];
    let frame = encode(&body, all.host.session(), 4243, &mut buffer)
        .expect("fits")
        .to_vec();
    all.rig.link.host_sends(&frame);
    all.run_for(0.01);
    assert_eq!(
        answer(&all, 4243),
        Some(Answer::Refused(Refused::NotACommand))
    );
}
