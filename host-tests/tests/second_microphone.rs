//! Promise: with two microphones, one that fails is dropped and named, and the box goes on
//! listening with the other; with one, nothing is changed over.

use hal_sim::rig::{FaultEvent, FaultKind, RigSetUp, SimBox, SimRig};
use host_tests::rig::{quiet, set};
use rarma_box::guard::{FaultCode, Mode};
use rarma_box::settings::SettingValue;
use rarma_box::wire::{Command, Telemetry};
use rarma_core::decide::State;

const FROM_US: u64 = 1_000_025;

/// A fault of the first microphone at 1 s; what was told of it until 3 s.
fn heard(kind: FaultKind, microphones: u32) -> (Option<(f32, u64)>, usize, usize) {
    let set_up = RigSetUp {
        faults: vec![FaultEvent {
            kind,
            place: 0,
            from_us: FROM_US,
            to_us: u64::MAX,
        }],
        ..RigSetUp::default()
    };
    let mut all = SimBox::new(SimRig::new(set_up, quiet(7)));
    all.run_to(100_000);
    set(
        &mut all,
        "monitor.microphones",
        SettingValue::Whole(microphones),
    );
    all.send(&Command::Start(Mode::Monitor));
    all.run_to(3_000_000);
    let dropped = all.host.heard.iter().find_map(|h| match &h.message {
        Telemetry::Fault(f) if f.record.code == FaultCode::MicrophoneDropped => {
            Some((f.record.value, h.at_us - FROM_US))
        }
        _ => None,
    });
    let late = all.host.heard.iter().filter(|h| h.at_us > 2_000_000);
    let (mut sound, mut bad) = (0, 0);
    for h in late {
        if let Telemetry::Verdict(v) = &h.message {
            let of_samples = v.state == State::Invalid;
            // The second microphone's level: 0.8 of 0.02, in the band.
            let level = (1e-4..0.016).contains(&v.level);
            if of_samples || !level || v.modes.is_empty() {
                bad += 1;
            } else {
                sound += 1;
            }
        }
    }
    (dropped, sound, bad)
}

#[test]
fn a_bad_microphone_is_dropped_and_the_other_goes_on() {
    println!("| fault | dropped after, ms | sound verdicts in the last second | others |");
    println!("|---|---|---|---|");
    for kind in [
        FaultKind::MicStuck,
        FaultKind::MicNan,
        FaultKind::MicNoisy,
        FaultKind::MicDead,
    ] {
        let (dropped, sound, bad) = heard(kind, 2);
        let (which, after_us) = dropped.expect("told");
        println!(
            "| {} | {:.1} | {sound} | {bad} |",
            kind.name(),
            1e-3 * after_us as f64
        );
        assert_eq!(which, 1.0, "{kind:?}");
        assert!(after_us < 120_000, "{kind:?}: {after_us} µs");
        assert!(sound >= 15 && bad == 0, "{kind:?}: {sound}, {bad}");
        // With one there is nobody to take over.
        let (dropped, sound, _) = heard(kind, 1);
        assert_eq!((dropped, sound), (None, 0), "{kind:?}");
    }
    // A clipped signal is the cut's.
    assert_eq!(heard(FaultKind::MicClipped, 2).0, None);
}
