//! A simulated box brought to work in one mode and then broken: what it makes of it.

use hal_sim::rig::{FaultEvent, FaultKind, RigConfig, RigSetUp, SimBox, SimRig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_box::guard::{FaultRecord, Mode, Severity, Stage};
use rarma_box::settings::{SettingValue, find};
use rarma_box::wire::{Answer, Command, Started, Telemetry};

/// When the fault comes, µs of the world.
pub const FAULT_US: u64 = 1_200_000;

/// Quiet noise, as an idle machine makes.
pub fn quiet(seed: u64) -> impl Iterator<Item = f32> + 'static {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let x: f32 = StandardNormal.sample(&mut rng);
        0.02 * x
    })
}

/// The number of a setting.
pub fn number(name: &str) -> u16 {
    let setting = rarma_box::settings::SETTINGS
        .iter()
        .find(|s| s.name == name);
    setting
        .unwrap_or_else(|| panic!("no setting {name}"))
        .number
}

/// Sets a setting on the box.
pub fn set(all: &mut SimBox, name: &str, value: SettingValue) {
    let number = number(name);
    assert!(find(number).is_some());
    all.send(&Command::Set {
        setting: number,
        value,
    });
}

/// The last answer to a command, by its sequence number.
pub fn answer(all: &SimBox, to: u32) -> Option<Answer> {
    all.host
        .heard
        .iter()
        .rev()
        .find_map(|heard| match &heard.message {
            Telemetry::Reply(reply) if reply.to == to => Some(reply.answer.clone()),
            _ => None,
        })
}

/// Whoever stands at the machine releases the enable input and presses it again.
pub fn press_again(all: &mut SimBox) {
    all.rig.contacts.enable = false;
    all.run_for(0.1);
    all.rig.contacts.enable = true;
    all.run_for(0.005);
}

/// A box at its working point in a mode, at 1.0 s.
pub fn working(mode: Mode, set_up: RigSetUp) -> SimBox {
    let seed = set_up.seed;
    let thermistor = set_up.plant.thermistor;
    let mut all = SimBox::new(SimRig::new(set_up, quiet(seed)));
    all.run_to(200_000);
    set(&mut all, "tacho.pulses", SettingValue::Whole(1));
    if let Some((_, b_k)) = thermistor {
        set(&mut all, "cers.thermistor", SettingValue::Real(b_k as f32));
    }
    for name in ["xp", "xm", "yp", "ym"] {
        // A textbook magnet's: without it nothing can be excited.
        let gain = format!("cers.gain-{name}");
        set(&mut all, &gain, SettingValue::Real(2.9e-7));
    }
    all.send(&Command::Start(mode));
    all.run_to(300_000);
    if mode.owns_outputs() {
        all.send(&Command::Arm);
        all.run_to(600_000);
        if mode == Mode::Ldbb {
            all.send(&Command::Pressure { pa: 2e5 });
        }
    }
    all.run_to(1_000_000);
    all
}

/// What came of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The first fault told after it, and how long after, µs.
    pub told: Option<(FaultRecord, Severity, u64)>,
    /// Outputs were on at the fault.
    pub were_on: bool,
    /// Outputs are on at the end.
    pub still_on: bool,
    /// Outputs were on last so long after the fault, µs.
    pub off_after_us: Option<u64>,
    /// Coils carried more than 50 mA last so long after the fault, µs.
    pub current_after_us: Option<u64>,
    /// Stage at the end.
    pub stage: Stage,
    /// The highest current any coil had, A.
    pub peak_a: f64,
    /// The box was reset.
    pub resets: u32,
    /// Broken frames that its health messages tell of.
    pub garbage: u32,
    /// Why it says it started anew.
    pub hello: Option<Started>,
}

/// Brings a box to work, breaks it for `length_us`, watches for two seconds.
pub fn broken(mode: Mode, kind: FaultKind, place: usize, length_us: u64) -> (Outcome, SimBox) {
    let at_arming = matches!(kind, FaultKind::GateRefuses | FaultKind::SupplyUnsteady);
    // The rig with the gauge has no input left for it.
    let of_winding = matches!(kind, FaultKind::WindingHot | FaultKind::ThermistorLost);
    let thermistor = (of_winding && mode != Mode::Ldbb).then_some((313.0, 3950.0));
    // The period after the one that ends the approach.
    let from_us = if at_arming { 250_000 } else { FAULT_US + 25 };
    let event = FaultEvent {
        kind,
        place,
        from_us,
        to_us: from_us + length_us,
    };
    let mut all = working(
        mode,
        RigSetUp {
            faults: vec![event],
            plant: RigConfig {
                thermistor,
                ..RigConfig::default()
            },
            ..RigSetUp::default()
        },
    );
    let fault_us = if at_arming { 300_000 } else { from_us };
    if !at_arming {
        all.run_to(FAULT_US);
    }
    let were_on = all.rig.outputs_on();
    let mut peak_a = 0.0f64;
    let mut asked = false;
    while all.rig.world_us() < FAULT_US + 2_000_000 {
        all.step();
        peak_a = all
            .rig
            .plant()
            .current_a
            .iter()
            .fold(peak_a, |a, b| a.max(*b));
        if !asked && all.rig.world_us() >= FAULT_US + 100_000 {
            asked = true;
            // Reveals a valve that does not move, and a flash that does not write.
            if mode == Mode::Ldbb {
                all.send(&Command::Pressure { pa: 5e5 });
            }
            all.send(&Command::Save { setting: 1 });
            // A gate that stays closed shows when it should open.
            if kind == FaultKind::GateWelded {
                all.send(&Command::Stop);
            }
        }
    }
    let told = all
        .host
        .heard
        .iter()
        .find_map(|heard| match &heard.message {
            Telemetry::Fault(f) if heard.at_us >= fault_us => {
                Some((f.record, f.severity, heard.at_us - fault_us))
            }
            _ => None,
        });
    let hello = all
        .host
        .heard
        .iter()
        .find_map(|heard| match &heard.message {
            Telemetry::Hello(identity) if heard.at_us >= fault_us => Some(identity.started),
            _ => None,
        });
    let garbage = all.host.heard.iter().map(|heard| match &heard.message {
        Telemetry::Health(health) => health.garbage,
        _ => 0,
    });
    let garbage = garbage.max().unwrap_or(0);
    let after = |at_us: u64| (at_us >= fault_us).then(|| at_us - fault_us);
    let outcome = Outcome {
        told,
        were_on,
        still_on: all.rig.outputs_on(),
        off_after_us: all.rig.last_on_us().and_then(after),
        current_after_us: after(all.rig.current_until_us()),
        stage: all.app.supervisor().stage(),
        peak_a,
        resets: all.resets,
        hello,
        garbage,
    };
    (outcome, all)
}
