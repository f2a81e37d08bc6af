//! Promise: an hour of work over a link that loses frames: time does not drift, no verdict is
//! missing, and all counters add up.
//!
//! Always: half a minute. The hour:
//! `cargo test --release -p host-tests --test long_run -- --ignored --nocapture`.

use hal_sim::rig::{RigSetUp, SimBox, SimRig};
use host_tests::rig::quiet;
use rarma_box::guard::Mode;
use rarma_box::wire::{Health, Telemetry};
use std::time::Instant;

const FS: f64 = 48_000.0;
const EVERY_S: f64 = 0.05;

fn run(seconds: u64, loss: f64) {
    let begun = Instant::now();
    let mut all = SimBox::new(SimRig::new(
        RigSetUp {
            spindle_hz: 0.0,
            ..RigSetUp::default()
        },
        quiet(9),
    ));
    all.run_for(0.1);
    assert_eq!(all.app.supervisor().mode(), Mode::Monitor);
    all.rig.link.frame_loss = loss;
    let mut verdicts = 0u64;
    let mut last_sample = 0u64;
    let mut health: Option<Health> = None;
    let mut drift_us = 0i64;
    let mut host_verdict_gap = 0u64;
    for _ in 0..seconds {
        all.run_for(1.0);
        for heard in all.host.heard.drain(..) {
            match heard.message {
                Telemetry::Verdict(v) => {
                    verdicts += 1;
                    // Verdicts stand on a grid of 50 ms: a lost one leaves a whole gap.
                    let steps = (v.sample - last_sample) as f64 / (EVERY_S * FS);
                    if last_sample > 0 {
                        assert!((steps - steps.round()).abs() < 0.05, "{steps} steps");
                        host_verdict_gap += steps.round() as u64 - 1;
                    }
                    last_sample = v.sample;
                    let heard_us = v.sample as f64 / FS * 1e6;
                    drift_us = drift_us.max((heard.at_us as i64 - heard_us as i64).abs());
                }
                Telemetry::Health(h) => health = Some(h),
                Telemetry::Fault(f) => panic!("a fault: {f:?}"),
                _ => {}
            }
        }
    }
    all.rig.link.frame_loss = 0.0;
    all.run_for(1.5);
    for heard in all.host.heard.drain(..) {
        match heard.message {
            Telemetry::Verdict(v) => {
                verdicts += 1;
                host_verdict_gap +=
                    ((v.sample - last_sample) as f64 / (EVERY_S * FS)).round() as u64 - 1;
                last_sample = v.sample;
            }
            Telemetry::Health(h) => health = Some(h),
            _ => {}
        }
    }
    let health = health.expect("a health message");
    let now_us = all.rig.world_us();
    let total = all.app.health(now_us);
    println!(
        "{seconds} s in {:.1} s: {} samples, {} verdicts made, {verdicts} heard, {} frames, {} lost on the way, {} missing by number, drift {drift_us} us",
        begun.elapsed().as_secs_f64(),
        total.samples,
        total.verdicts,
        total.frames,
        all.rig.link.frames_lost,
        all.host.missing,
    );
    // Time: every sample of the world was taken, and the clock is the world's.
    let due = (now_us as f64 * FS * 1e-6) as u64;
    assert!(due - total.samples <= 16, "{due} {}", total.samples);
    assert_eq!((total.missing, total.late, total.dropped), (0, 0, 0));
    assert!(now_us - health.now_us <= 1_100_000);
    assert!(drift_us < 6_000, "{drift_us}");
    // Verdicts: as many as the time has steps; heard and lost add up.
    let steps = (total.samples as f64 / (EVERY_S * FS)) as i64;
    assert!(
        (i64::from(total.verdicts) - steps).abs() <= 1,
        "{} {steps}",
        total.verdicts
    );
    assert!(i64::from(total.verdicts) - (verdicts + host_verdict_gap) as i64 <= 1);
    // Frames: those that came, and those that are missing by their numbers, are all.
    assert_eq!(u64::from(total.frames), all.rig.link.frames);
    assert_eq!(all.host.whole + all.host.missing, all.rig.link.frames);
    assert_eq!(all.host.missing, all.rig.link.frames_lost);
    assert_eq!(all.host.broken, 0);
    if loss > 0.0 {
        let part = all.host.missing as f64 / all.rig.link.frames as f64;
        assert!((0.5 * loss..1.5 * loss).contains(&part), "{part}");
    }
    // Commands: every heartbeat of the host was answered.
    let heartbeats = now_us / 100_000;
    assert!(
        u64::from(total.commands).abs_diff(heartbeats) <= 1,
        "{} {heartbeats}",
        total.commands
    );
    assert_eq!((total.refused, total.garbage, all.resets), (0, 0, 0));
}

#[test]
fn nothing_is_lost_or_drifts() {
    run(30, 0.02);
}

#[test]
#[ignore = "an hour of the box; minutes of the host"]
fn nothing_is_lost_or_drifts_long() {
    run(3600, 0.02);
}
