//! Promise: whatever breaks while both axes are driven with noise, the switches open, the force
//! ends with the current, and the fault is named.
//!
//! `cargo test --release -p host-tests --test cers_trips -- --nocapture`

use hal_sim::rig::{FaultEvent, FaultKind};
use host_tests::cers_rig::exciting;
use rarma_box::guard::{FaultCode, Stage};

#[test]
fn every_trip_ends_the_force() {
    use FaultKind as K;
    let rows = [
        (K::EmergencyStop, 0, FaultCode::EmergencyStop),
        (K::EnableLost, 0, FaultCode::EnableLost),
        (K::HeartbeatLost, 0, FaultCode::HeartbeatLost),
        (K::MainLate, 0, FaultCode::DeadlineMissed),
        // The duties hold until a comparator breaks the timers at 3.4 A; the watchdog is last.
        (K::LoopDead, 0, FaultCode::Watchdog),
        (K::CurrentDead, 0, FaultCode::Bridge),
        (K::BridgeRefuses, 0, FaultCode::Bridge),
        (K::CurrentSensorLost, 1, FaultCode::CurrentSensorLost),
        // Ten milliseconds of one code would be told; the comparator is there first.
        (K::CurrentSensorStuck, 2, FaultCode::Comparator),
        (K::GapLost, 0, FaultCode::GapSensorLost),
        (K::GapStuck, 1, FaultCode::GapSensorStuck),
        (K::GapClosing, 0, FaultCode::GapClosed),
        (K::Overspeed, 0, FaultCode::Overspeed),
        (K::WindingHot, 0, FaultCode::WindingHot),
        (K::ThermistorLost, 0, FaultCode::ThermistorLost),
        (K::SensorsDead, 0, FaultCode::SensorsLost),
        (K::MainHangs, 0, FaultCode::Watchdog),
        (K::BrownOut, 0, FaultCode::BrownOut),
        (K::Panic, 0, FaultCode::Panic),
        (K::HardFault, 0, FaultCode::HardFault),
    ];
    println!("| fault | told as | switches open after, ms | no current after that, µs |");
    println!("|---|---|---|---|");
    for (kind, place, code) in rows {
        let from_us = 1_000_025;
        let mut all = exciting(vec![FaultEvent {
            kind,
            place,
            from_us,
            to_us: from_us + 2_000_000,
        }]);
        all.run_for(1.5);
        let on = all
            .rig
            .last_on_us()
            .expect("was on")
            .saturating_sub(from_us);
        let current = all.rig.current_until_us().saturating_sub(from_us);
        let fault = all.app.supervisor().fault().map(|f| f.code);
        let left = current.saturating_sub(on);
        println!(
            "| {} | {} | {:.3} | {left} |",
            kind.name(),
            fault.map_or("-", FaultCode::name),
            1e-3 * on as f64
        );
        assert_eq!(fault, Some(code), "{kind:?}");
        assert!(!all.rig.outputs_on() && all.rig.plant().current_a.iter().all(|i| *i == 0.0));
        // 0.8 A and the noise's peaks against 48 V: 70 µs for 0.8 A.
        let broken = matches!(kind, K::LoopDead | K::CurrentSensorStuck);
        let most = if broken { 325 } else { 125 };
        assert!(left <= most, "{kind:?}: {left} µs");
        assert_eq!(all.app.supervisor().stage(), Stage::Faulted);
    }
}
