//! Promise: no command exceeds a limit, whatever is said in whatever order while outputs are
//! on; and a step to the greatest set point stays below the trip.

use hal_sim::rig::{Heard, RigSetUp};
use host_tests::rig::working;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::{Mode, Stage};
use rarma_box::settings::{SETTINGS, SettingValue};
use rarma_box::wire::{Command, ExcitationMessage, Telemetry};
use rarma_rigs::cers::{Direction, ExcitationJob, Signal};

/// A command that somebody might send to a box at work; finite or not, allowed or not.
fn anything(rng: &mut ChaCha8Rng) -> Command {
    let real = |rng: &mut ChaCha8Rng| match rng.random_range(0..4) {
        0 => rng.random_range(0.0..2.5),
        1 => rng.random_range(-1e6..1e6),
        2 => f32::from_bits(rng.random()),
        _ => rng.random_range(0.0..8e5),
    };
    match rng.random_range(0..7) {
        5 => Command::Excite(ExcitationJob {
            signal: Signal::ALL[rng.random_range(0..4)],
            direction: Direction::ALL[rng.random_range(0..3)],
            rms_a: if rng.random() { 0.2 } else { real(rng) },
            low_hz: if rng.random() { 200.0 } else { real(rng) },
            high_hz: if rng.random() { 2000.0 } else { real(rng) },
            seconds: rng.random_range(0.0..1.0),
            lines: rng.random_range(0..10),
        }),
        6 => Command::Quiet,
        0 | 1 => Command::Current { a: real(rng) },
        2 | 3 => Command::Pressure { pa: real(rng) },
        _ => Command::Set {
            setting: SETTINGS[rng.random_range(3..SETTINGS.len())].number,
            value: SettingValue::Real(real(rng)),
        },
    }
}

fn greatest(mode: Mode, seed: u64) -> (f64, f64, Stage) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut all = working(
        mode,
        RigSetUp {
            seed,
            ..RigSetUp::default()
        },
    );
    assert_eq!(all.app.supervisor().stage(), Stage::Ready);
    let (mut amps, mut pascals) = (0.0f64, 0.0f64);
    for k in 0..400 {
        let command = anything(&mut rng);
        all.send(&command);
        if k % 50 == 49 {
            // The greatest that is allowed.
            all.send(&Command::Current { a: 2.5 });
            all.send(&Command::Pressure { pa: 7.2e5 });
            all.run_for(0.3);
        }
        for _ in 0..16 {
            all.step();
            let plant = all.rig.plant();
            amps = plant.current_a.iter().fold(amps, |a, b| a.max(*b));
            pascals = pascals.max(plant.pressure_pa);
        }
    }
    let excited = |h: &Heard| {
        matches!(
            h.message,
            Telemetry::Excitation(ExcitationMessage::Started(_))
        )
    };
    let signals = all.host.heard.iter().filter(|h| excited(h)).count();
    println!("seed {seed}: {signals} signals");
    (amps, pascals, all.app.supervisor().stage())
}

#[test]
fn coils_stay_within_their_limit() {
    let mut most = 0.0f64;
    for seed in 0..8 {
        let (amps, pascals, stage) = greatest(Mode::Cers, seed);
        // The overload model may rightly end it, and settings such as the supply's or the
        // overspeed's limit act at once; nothing else does.
        let sound = matches!(stage, Stage::Ready | Stage::Exciting | Stage::Faulted);
        assert!(sound, "{stage:?}");
        assert_eq!(pascals, 0.0);
        most = most.max(amps);
    }
    println!("greatest current {most:.3} A");
    assert!((0.79..2.65).contains(&most), "{most}");
}

#[test]
fn pressure_stays_within_its_limit() {
    let mut most = 0.0f64;
    for seed in 0..8 {
        let (amps, pascals, _) = greatest(Mode::Ldbb, seed);
        assert_eq!(amps, 0.0);
        most = most.max(pascals);
    }
    println!("greatest pressure {most:.0} Pa");
    assert!((1.9e5..7.21e5).contains(&most), "{most}");
}
