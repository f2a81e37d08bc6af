//! Promise: a whole circle test runs through the firmware on simulated hardware, and what goes
//! wrong during a capture leaves the bar vented or held.
//!
//! `cargo test --release -p host-tests --test ldbb_box -- --nocapture`

use hal_sim::rig::{FaultEvent, FaultKind, SimBox};
use host_tests::ldbb::m3;
use host_tests::ldbb_box::{arm, job, quieter, ready, rig, run, run_as};
use host_tests::rig::set;
use rarma_box::guard::{FaultCode, Severity, Stage};
use rarma_box::settings::SettingValue;
use rarma_box::wire::CircleMessage;
use rarma_plants::ldbb::MotionFault;
use rarma_rigs::ldbb::RunFault;

#[test]
fn eight_pressures_in_both_directions() {
    let mut all = ready(m3(), Vec::new());
    let job = job(&[0.4, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], true, false);
    let told = run(&mut all, &job, None);
    assert_eq!((told.failed, told.runs.len()), (None, 16));
    assert!(told.faults.is_empty(), "{:?}", told.faults);
    let f = told.findings();
    let s = f.stiffness.expect("eight forces");
    let truth = m3().machine.stiffness_n_per_m;
    let worst = s.rays.iter().fold(0.0, |m: f64, r| {
        let k = 1e-6 * truth.at(r.angle_deg.to_radians());
        m.max((r.n_per_um / k - 1.0).abs())
    });
    println!(
        "{:.0} s of the world; host: {:.2} N/µm at {:.1}° to {:.2} at {:.1}°, worst direction {:.2} %",
        told.world_s,
        s.least.n_per_um,
        s.least.angle_deg,
        s.most.n_per_um,
        s.most.angle_deg,
        100.0 * worst
    );
    assert!(worst < 0.01 && worst > 1e-4);
    assert!((s.most.angle_deg - 120.2).abs() < 3.0 && (s.least.angle_deg - 207.0).abs() < 3.0);
    let Some(CircleMessage::Stiffness {
        mean_n_per_m,
        most,
        least,
        sd_n_per_m,
        ..
    }) = told.stiffness
    else {
        panic!("the box says nothing")
    };
    println!(
        "box, 2° raw: mean {:.2}, {:.2} at {:.0}° to {:.2} ± {:.3} at {:.0}°",
        1e-6 * mean_n_per_m,
        1e-6 * least.0,
        least.1.to_degrees(),
        1e-6 * most.0,
        1e-6 * sd_n_per_m,
        most.1.to_degrees()
    );
    assert!((mean_n_per_m / 11.8e6 - 1.0).abs() < 0.01);
    assert!((most.0 / 13.4e6 - 1.0).abs() < 0.02 && (least.0 / 10.3e6 - 1.0).abs() < 0.02);
    let bytes = size_of::<firmware::SensorBox>();
    let bar = size_of::<firmware::bar::BarDuty>();
    println!("the application's state: {bytes} bytes, of them the ball bar's {bar} (64-bit host)");
    assert!(bar < 24 * 1024 && bar > 4 * 1024, "{bar}");
}

/// Air, gauge, sensors and stops during a capture: what the table says, within its time.
#[test]
fn faults_during_capture() {
    use FaultKind as K;
    let cases = [
        (K::PressureLost, FaultCode::PressureSensorLost),
        (K::PressureHigh, FaultCode::PressureHigh),
        (K::GaugeLost, FaultCode::GaugeLost),
        (K::GaugeRange, FaultCode::GaugeRange),
        (K::ValveRefuses, FaultCode::Valve),
        (K::SensorsDead, FaultCode::SensorsLost),
        (K::SupplyLow, FaultCode::SupplyLow),
        (K::EmergencyStop, FaultCode::EmergencyStop),
        (K::EnableLost, FaultCode::EnableLost),
        (K::HeartbeatLost, FaultCode::HeartbeatLost),
    ];
    for (kind, code) in cases {
        // The first run's capture is from about 6 to 35 s.
        let event = FaultEvent {
            kind,
            place: 0,
            from_us: 20_000_000,
            to_us: u64::MAX,
        };
        let mut all = ready(m3(), vec![event]);
        let told = run(&mut all, &job(&[2.0, 4.0, 6.0], true, false), None);
        let trip = told.faults.iter().find(|f| f.1 == Severity::Trip);
        let pa = all.rig.plant().pressure_pa;
        println!(
            "{:20} {:?} {:?}, {:.3} bar after 2 s",
            kind.name(),
            trip,
            told.failed,
            1e-5 * pa
        );
        assert_eq!(trip.map(|f| f.0), Some(code), "{kind:?} {:?}", told.faults);
        assert!(!all.rig.outputs_on() && pa < 1e4, "{kind:?}: {pa} Pa");
        assert_eq!(all.app.supervisor().stage(), Stage::Faulted);
        assert!(told.runs.is_empty() && told.stiffness.is_none());
    }
}

/// A leak ends the run at once: the bar is held at the lowest pressure, which the outer loop
/// still reaches. A stuck regulator shows when the next pressure is due.
#[test]
fn leak_and_stuck_valve() {
    let with = |kind| {
        let event = FaultEvent {
            kind,
            place: 0,
            from_us: 20_000_000,
            to_us: u64::MAX,
        };
        let mut all = ready(m3(), vec![event]);
        let told = run(&mut all, &job(&[2.0, 4.0, 6.0], false, false), None);
        let pa = all.rig.plant().pressure_pa;
        (told, pa, all.app.supervisor().stage())
    };
    let (leak, pa, stage) = with(FaultKind::PressureLeak);
    println!(
        "leak: {:?} {:?}, {:.3} bar, {stage:?}",
        leak.failed,
        leak.faults,
        1e-5 * pa
    );
    assert!(matches!(leak.failed, Some((0, RunFault::PressureMoved(_)))));
    assert!((3.6e4..4.2e4).contains(&pa) || (stage == Stage::Faulted && pa < 1e4));
    let (stuck, pa, stage) = with(FaultKind::ValveStuck);
    println!(
        "stuck: {:?} {:?}, {:.3} bar",
        stuck.failed,
        stuck.faults,
        1e-5 * pa
    );
    assert_eq!(stuck.runs.len(), 1);
    assert_eq!(stuck.faults, [(FaultCode::ValveStuck, Severity::Trip)]);
    assert!(stage == Stage::Faulted && pa < 1e4);
}

/// Triggers, direction, feed: the test ends, the bar stays held, the box stays armed.
#[test]
fn motion_faults_leave_the_bar_held() {
    for (fault, want) in [
        (MotionFault::NoEnd, RunFault::NoOffTrigger),
        (MotionFault::Reversed, RunFault::WrongDirection),
    ] {
        let mut all = ready(m3(), Vec::new());
        let told = run(
            &mut all,
            &job(&[1.0, 2.0, 3.0], true, false),
            Some((1, fault)),
        );
        let pa = all.rig.plant().pressure_pa;
        println!("{fault:?}: {:?}, {:.3} bar", told.failed, 1e-5 * pa);
        assert_eq!(told.failed, Some((1, want)));
        assert!((3.8e4..4.2e4).contains(&pa), "{pa}");
        assert_eq!(all.app.supervisor().stage(), Stage::Ready);
        assert!(told.faults.is_empty() && told.runs.len() == 1);
    }
}

/// What the settings say of the bar: a calibrated law of 10 % more, an inclination of 30°.
#[test]
fn law_and_inclination_are_settings() {
    let found = |name: &str, value: f32, incline: f64| {
        let mut all = SimBox::new(rig(m3(), Vec::new()));
        all.run_to(100_000);
        set(&mut all, name, SettingValue::Real(value));
        let mut bench = m3();
        bench.inclination_rad = incline;
        bench.machine.radius_m *= incline.cos();
        all.rig.set_bar(quieter(bench));
        arm(&mut all);
        let flat = job(&[0.5, 2.0, 4.0], true, false);
        let level = f64::from(flat.feed_m_s);
        let mut bar = flat;
        // The machine runs the circle of the inclined bar.
        bar.radius_m *= incline.cos() as f32;
        bar.feed_m_s *= incline.cos() as f32;
        let told = run_as(&mut all, &flat, &bar, None);
        assert_eq!((told.failed, told.runs.len()), (None, 6), "{name} {level}");
        let Some(CircleMessage::Stiffness { mean_n_per_m, .. }) = told.stiffness else {
            panic!("the box says nothing")
        };
        (f64::from(mean_n_per_m), told)
    };
    let (standard, _) = found("ldbb.gain", 1.26e-3, 0.0);
    let (more, _) = found("ldbb.gain", 1.386e-3, 0.0);
    println!("gain 10 % more: {:.4}", more / standard);
    assert!((more / standard - 1.1).abs() < 2e-3);
    let (inclined, told) = found("ldbb.inclination", 30f32.to_radians(), 30f64.to_radians());
    println!("30°: {:.3} of the level stiffness", inclined / standard);
    // The plant's machine is as stiff in every inclination.
    assert!((inclined / standard - 1.0).abs() < 0.01);
    // 490 N in the plane are 566 N along the bar: 4.60 bar for 4.
    let most = told.runs.iter().fold(0.0, |m: f64, r| m.max(r.pressure_pa));
    assert!((most - 4.6016e5).abs() < 500.0, "{most}");
}
