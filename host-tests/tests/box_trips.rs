//! Promise: what trips the box, or resets it, is told and stays; nothing comes on again before
//! all that arming needs is there and somebody clears and arms.
//!
//! `cargo test --release -p host-tests --test box_trips -- --nocapture`

use hal_sim::rig::{FaultKind as K, RigSetUp};
use host_tests::rig::{answer, broken, press_again, set, working};
use rarma_box::guard::{Denial, FaultCode as C, Mode, Severity, Stage};
use rarma_box::settings::SettingValue;
use rarma_box::wire::{Answer, Command, Refused, Started, Telemetry};

/// The first trip that was told.
fn trip(all: &hal_sim::SimBox) -> Option<(C, u8, u64)> {
    all.host.heard.iter().find_map(|h| match &h.message {
        Telemetry::Fault(f) if f.severity == Severity::Trip => {
            Some((f.record.code, f.record.place, h.at_us))
        }
        _ => None,
    })
}

#[test]
fn winding_that_carries_too_much_for_too_long_is_switched_off_by_its_model() {
    let mut all = working(Mode::Safe, RigSetUp::default());
    set(&mut all, "cers.thermal", SettingValue::Real(1.0));
    all.send(&Command::Start(Mode::Cers));
    all.run_for(0.01);
    all.send(&Command::Arm);
    all.run_for(0.5);
    let from = all.rig.world_us();
    all.send(&Command::Current { a: 2.0 });
    all.run_for(2.0);
    let (code, _, at) = trip(&all).expect("a trip");
    assert_eq!(code, C::Overload);
    // Before: 0.8 A for 0.43 s on average. r = (2/1.2)² = 2.78; from θ0 = 0.156 it is
    // full after ln((r − θ0)/(r − 1)) = 0.388 s, and the ramp of 8 A/s adds 0.1 s or so.
    let after = (at - from) as f64 * 1e-6;
    assert!((0.39..0.55).contains(&after), "{after} s");
    assert!(!all.rig.outputs_on());
}

#[test]
fn current_sensor_without_a_zero_is_found_before_the_bias_is_up() {
    let mut set_up = RigSetUp::default();
    set_up.plant.offset_a[2] = 0.5;
    let all = working(Mode::Cers, set_up);
    let (code, place, at) = trip(&all).expect("a trip");
    assert_eq!((code, place), (C::CurrentSensorOffset, 2));
    // Armed at 0.3 s; the supply is steady after 50 ms, zeros are there 20 ms later.
    assert!((370_000..375_000).contains(&at), "{at}");
}

#[test]
fn arming_needs_stop_chain_enable_input_heartbeat_and_a_cleared_fault() {
    let mut all = working(Mode::Safe, RigSetUp::default());
    let ask = |all: &mut hal_sim::SimBox, command: Command| {
        let to = all.send(&command);
        all.run_for(0.005);
        answer(all, to).expect("an answer")
    };
    let denied = |why| Answer::Refused(Refused::Denied(why));
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::Mode));
    ask(&mut all, Command::Start(Mode::Cers));
    all.rig.contacts.enable = false;
    all.run_for(0.005);
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::EnableOpen));
    all.rig.contacts.enable = true;
    all.host.heartbeat_us = None;
    all.run_for(1.0);
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::NoHeartbeat));
    all.host.heartbeat_us = Some(100_000);
    all.rig.contacts.stop_chain = false;
    all.run_for(0.2);
    // Latched, although nothing was on; and it cannot be cleared while it stands.
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::StopChainOpen));
    assert_eq!(ask(&mut all, Command::Clear), denied(Denial::FaultStands));
    all.rig.contacts.stop_chain = true;
    all.run_for(0.005);
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::FaultLatched));
    assert_eq!(ask(&mut all, Command::Clear), Answer::Done);
    assert_eq!(ask(&mut all, Command::Arm), denied(Denial::EnableHeld));
    press_again(&mut all);
    assert_eq!(all.rig.last_on_us(), None);
    assert_eq!(ask(&mut all, Command::Arm), Answer::Done);
    all.run_for(0.5);
    assert!(all.rig.outputs_on());
    assert_eq!(
        ask(&mut all, Command::Save { setting: 1 }),
        denied(Denial::Energised)
    );
    assert_eq!(
        ask(&mut all, Command::Start(Mode::Ldbb)),
        denied(Denial::Energised)
    );
    assert_eq!(
        ask(&mut all, Command::Pressure { pa: 1e5 }),
        denied(Denial::Mode)
    );
    assert_eq!(
        ask(&mut all, Command::Current { a: 2.6 }),
        denied(Denial::Limit)
    );
    assert_eq!(
        ask(&mut all, Command::Current { a: f32::NAN }),
        denied(Denial::Limit)
    );
    assert_eq!(ask(&mut all, Command::Stop), Answer::Done);
    all.run_for(0.3);
    assert!(!all.rig.outputs_on());
    assert_eq!(all.app.supervisor().stage(), Stage::Off);
}

/// The supply of the power stage dips while the bar is loaded and the controller lives on: the
/// valve is vented, and stays so when the supply is back, until somebody clears and arms. A
/// millisecond is ridden through: the regulator's air does not feel it.
#[test]
fn supply_dip_vents_the_bar_for_good() {
    let dip = |length_us: u64| RigSetUp {
        faults: vec![hal_sim::rig::FaultEvent {
            kind: K::SupplyDip,
            place: 0,
            from_us: 1_200_025,
            to_us: 1_200_025 + length_us,
        }],
        ..RigSetUp::default()
    };
    let mut all = working(Mode::Ldbb, dip(20_000));
    all.run_to(1_200_000);
    assert!(all.rig.plant().pressure_pa > 1.8e5);
    all.run_to(1_500_000);
    let pa = all.rig.plant().pressure_pa;
    let (code, _, at) = trip(&all).expect("a trip");
    println!(
        "20 ms: {code:?} after {} ms, {pa:.0} Pa 0.3 s later",
        1e-3 * (at - 1_200_025) as f64
    );
    assert_eq!(code, C::SupplyLow);
    assert!(pa < 2e3 && !all.rig.outputs_on() && all.resets == 0);
    // The supply has been back for 3 s, another pressure is asked for: nothing comes by itself.
    let to = all.send(&Command::Pressure { pa: 3e5 });
    all.run_to(4_200_000);
    assert!(matches!(answer(&all, to), Some(Answer::Refused(_))));
    assert!(all.rig.plant().pressure_pa < 1e3 && !all.rig.outputs_on());
    assert_eq!(all.app.supervisor().stage(), Stage::Faulted);
    press_again(&mut all);
    for command in [Command::Clear, Command::Arm] {
        let to = all.send(&command);
        all.run_for(0.01);
        assert_eq!(answer(&all, to), Some(Answer::Done), "{command:?}");
    }
    all.run_for(1.5);
    let pa = all.rig.plant().pressure_pa;
    assert!((3.8e4..4.2e4).contains(&pa), "{pa} Pa at rest");

    let mut all = working(Mode::Ldbb, dip(900));
    all.run_to(1_900_000);
    assert_eq!(trip(&all), None);
    assert!(all.rig.outputs_on() && all.rig.plant().pressure_pa > 1.9e5);
}

#[test]
fn last_fault_survives_a_reset_and_is_told() {
    let (_, mut all) = broken(Mode::Cers, K::Panic, 0, 10_000_000);
    let to = all.send(&Command::Identify);
    all.run_for(0.01);
    let Some(Answer::Identity(identity)) = answer(&all, to) else {
        panic!("no identity");
    };
    assert_eq!(identity.started, Started::Software);
    assert_eq!(identity.before.map(|f| f.code), Some(C::Panic));
    // A watchdog's reset tells what was latched before it, too.
    let (_, mut all) = broken(Mode::Cers, K::MainHangs, 0, 50_000);
    let to = all.send(&Command::Identify);
    all.run_for(0.01);
    assert!(matches!(answer(&all, to), Some(Answer::Identity(_))));
}
