//! Promise: every frame says which run of the box it belongs to, and a command counts in the
//! run it was made for only.

use hal_sim::rig::{RigSetUp, SimBox, SimRig};
use host_tests::rig::{answer, quiet};
use rarma_box::guard::Mode;
use rarma_box::wire::{Answer, Command, MAX_FRAME, NO_SESSION, Order, Refused, Started, Telemetry};
use rarma_box::wire::{encode_order, head};
use std::collections::BTreeSet;

fn frame(command: &Command, session: u32, sequence: u32) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let order = Order {
        by: 12,
        command: *command,
    };
    let bytes = encode_order(&order, session, sequence, None, &mut buffer);
    bytes.expect("a command fits a frame").to_vec()
}

fn fresh(seed: u64) -> SimBox {
    let set_up = RigSetUp {
        seed,
        ..RigSetUp::default()
    };
    SimBox::new(SimRig::new(set_up, quiet(seed)))
}

#[test]
fn every_frame_of_a_run_names_it_and_another_run_is_another() {
    let mut sessions = BTreeSet::new();
    for seed in 0..50 {
        let mut all = fresh(seed);
        let mut bytes = Vec::new();
        for _ in 0..200 {
            bytes.extend(all.step_and_take());
        }
        let frames = bytes.split(|byte| *byte == 0).filter(|f| !f.is_empty());
        let heads: Vec<_> = frames.map(|f| head(f).expect("a whole frame")).collect();
        assert!(!heads.is_empty());
        let named: BTreeSet<u32> = heads.iter().map(|head| head.session).collect();
        assert_eq!(named.len(), 1, "seed {seed}: {named:?}");
        assert!(!named.contains(&NO_SESSION));
        sessions.extend(named);
    }
    assert_eq!(sessions.len(), 50, "two boxes of one number");
}

#[test]
fn a_reset_is_a_session_of_its_own_and_its_numbers_begin_again() {
    let mut all = fresh(3);
    all.run_for(0.3);
    let first = all.host.session();
    all.rig.add_fault(hal_sim::rig::FaultEvent {
        kind: hal_sim::rig::FaultKind::Panic,
        place: 0,
        from_us: all.rig.world_us(),
        to_us: u64::MAX,
    });
    all.run_for(0.3);
    assert_eq!(all.resets, 1);
    let second = all.host.session();
    assert_ne!(first, second);
    let of_second: Vec<_> = all
        .host
        .heard
        .iter()
        .skip_while(|heard| heard.session == first)
        .collect();
    assert!(of_second.iter().all(|heard| heard.session == second));
    assert_eq!(of_second[0].sequence, 0);
    assert!(
        matches!(&of_second[0].message, Telemetry::Hello(id) if id.started == Started::Software)
    );
    assert_eq!(all.host.missing, 0, "a new session is no gap");
}

#[test]
fn a_command_for_another_session_is_refused_by_name_and_changes_nothing() {
    let mut all = fresh(4);
    all.run_for(0.1);
    let own = all.host.session();
    let mode = all.app.supervisor().mode();
    assert_ne!(mode, Mode::Safe);
    for (sequence, session) in [
        (901, own ^ 1),
        (902, NO_SESSION),
        (903, own.wrapping_add(7)),
    ] {
        for command in [Command::Start(Mode::Safe), Command::Status, Command::Stop] {
            all.host.heard.clear();
            let bytes = frame(&command, session, sequence);
            all.rig.link.host_sends(&bytes);
            all.run_for(0.01);
            let refused = Some(Answer::Refused(Refused::Session));
            assert_eq!(answer(&all, sequence), refused, "{command:?}");
            assert_eq!(all.app.supervisor().mode(), mode);
        }
    }
}

#[test]
fn who_does_not_know_the_session_asks_who_the_box_is_and_reads_it_off_the_answer() {
    let mut all = fresh(5);
    all.run_for(0.1);
    all.host.heard.clear();
    let bytes = frame(&Command::Identify, NO_SESSION, 77);
    all.rig.link.host_sends(&bytes);
    all.run_for(0.01);
    let answered = all
        .host
        .heard
        .iter()
        .find(|heard| matches!(&heard.message, Telemetry::Reply(reply) if reply.to == 77));
    let answered = answered.expect("an answer");
    assert!(matches!(
        &answered.message,
        Telemetry::Reply(reply) if matches!(reply.answer, Answer::Identity(_))
    ));
    assert_eq!(answered.session, all.host.session());
}
