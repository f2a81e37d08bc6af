//! The box's own side: its commands, and its flash.

use super::link::{Piece, framed, head_words, pieces};
use crate::Target;
use firmware::store::Store;
use hal_sim::rig::{RigSetUp, SimBox, SimFlash, SimRig};
use rarma_box::settings::{SETTINGS, Settings, from_record, to_record};
use rarma_box::wire::{Answer, Command, Telemetry};

pub(super) const COMMANDS: Target = Target {
    name: "commands",
    reads: "the link of a whole box",
    run: commands,
    words: head_words,
};

pub(super) const STORE: Target = Target {
    name: "store",
    reads: "settings in flash, and one record",
    run: |bytes| {
        record(bytes);
        flash(bytes);
    },
    words: || vec!["RAF1".to_owned()],
};

/// What the host sends.
fn commands(bytes: &[u8]) {
    let mut all = SimBox::new(SimRig::new(RigSetUp::default(), std::iter::repeat(0.01)));
    // Nobody holds the enable contact, and no host is alive: nothing may switch on.
    all.host.heartbeat_us = None;
    for (k, piece) in pieces(bytes).into_iter().take(64).enumerate() {
        match piece {
            Piece::Bytes(bytes) => all.rig.link.host_sends(bytes),
            Piece::Body(body) => {
                let frame = framed(body, all.host.session(), k as u32);
                all.rig.link.host_sends(&frame.unwrap_or_default());
            }
            Piece::Pause(ms) => wait(&mut all, 1000 * u64::from(ms)),
        }
    }
    wait(&mut all, 2000);
    while all.rig.link.waiting() > 0 {
        step(&mut all);
    }
    // In step again at the next frame: a zero ends whatever stands there.
    all.rig.link.host_sends(&[0]);
    let to = all.send(&Command::Identify);
    wait(&mut all, 4000);
    let answered = all.host.heard.iter().any(|heard| {
        matches!(&heard.message, Telemetry::Reply(r)
            if r.to == to && matches!(r.answer, Answer::Identity(_)))
    });
    assert!(answered, "the box does not answer any more");
    assert_eq!(all.resets, 0, "the box was reset");
}

fn wait(all: &mut SimBox, us: u64) {
    let until = all.rig.world_us() + us;
    while all.rig.world_us() < until {
        step(all);
    }
}

fn step(all: &mut SimBox) {
    all.step();
    assert!(!all.rig.outputs_on(), "an output came on");
}

/// One record: refused, or it means what its bytes say.
fn record(bytes: &[u8]) {
    for setting in &SETTINGS {
        if let Ok(value) = from_record(setting, bytes) {
            assert_eq!(from_record(setting, &to_record(setting, value)), Ok(value));
            assert!(value.is_none_or(|value| setting.check(value).is_ok()));
        }
    }
}

/// A flash that holds these bytes: every setting is in its range, and the store works.
fn flash(bytes: &[u8]) {
    let mut flash = SimFlash::default();
    let range = flash.range();
    // A store that a box laid, and the bytes over it from where their head says.
    let _ = Store::load(&mut flash, range.clone(), &mut Settings::default());
    let (at, bytes) = match bytes {
        [low, high, bytes @ ..] => (usize::from(u16::from_le_bytes([*low, *high])), bytes),
        _ => (0, bytes),
    };
    flash.overwrite(at % range.end as usize, bytes);
    let mut settings = Settings::default();
    let (mut store, _) = Store::load(&mut flash, range.clone(), &mut settings);
    for setting in &SETTINGS {
        // A key that is not set has no value.
        if let Some(value) = settings.to_store(setting.number) {
            assert_eq!(setting.check(value), Ok(()), "{}", setting.name);
        }
    }
    let setting = &SETTINGS[0];
    let value = setting.default_value();
    let kept = store.write(&mut flash, range.clone(), setting, Some(value));
    assert!(kept.is_ok(), "a store that works: {kept:?}");
    let read = store.read(&mut flash, range, setting);
    assert_eq!(read, Ok(Ok(Some(value))));
}
