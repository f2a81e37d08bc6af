//! `rarma monitor` itself.

use super::{Alarm, Detector, Recording, Said};
use crate::Defect;
use firmware::monitor::MonitorDuty;
use rarma_box::wire::{MonitorJob, Telemetry};
use rarma_core::decide::State;
use rarma_core::monitor::MonitorConfig;

/// Poles are looked at this often, s.
const EVERY_S: f64 = 0.01;

/// The monitor, with its usual settings.
pub(super) struct Monitor;

impl Detector for Monitor {
    fn name(&self) -> &'static str {
        "monitor"
    }

    fn threshold(&self) -> &'static str {
        "damping ratio below which a mode is suspected, 1"
    }

    fn thresholds(&self) -> &'static [f64] {
        &[0.01, 0.0025, 0.005, 0.02]
    }

    fn listens_anew(&self) -> bool {
        true
    }

    fn listen(&self, recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect> {
        thresholds.iter().map(|t| at(recording, *t)).collect()
    }
}

/// Runs the monitor; every message goes to `take` with its time, s.
pub(super) fn run(
    recording: &Recording,
    monitor: MonitorConfig,
    mut take: impl FnMut(&Telemetry),
) -> Result<(), Defect> {
    let job = MonitorJob {
        monitor,
        channel: 0,
        every_s: EVERY_S,
    };
    let mut duty = MonitorDuty::new(&job)
        .map_err(|why| Defect(format!("the population's settings: {why:?}")))?;
    let mut told = monitor.spindle_hz;
    for (n, x) in recording.samples().iter().enumerate() {
        duty.samples(&[*x], &mut take);
        let now = recording.speed.known_hz(n as f64 / recording.fs_hz());
        if told.is_some()
            && now != told
            && let Some(hz) = now
        {
            duty.tell_speed(hz as f32)
                .map_err(|why| Defect(format!("the population's speed: {why:?}")))?;
            told = now;
        }
    }
    Ok(())
}

pub(super) fn config(recording: &Recording) -> MonitorConfig {
    MonitorConfig {
        full_scale: Some(1.0),
        order: recording.order,
        ..MonitorConfig::new(recording.fs_hz())
    }
}

fn at(recording: &Recording, threshold: f64) -> Result<Said, Defect> {
    let mut said = Said::default();
    let end_s = recording.length_s();
    let mut warned: Option<f64> = None;
    let config = MonitorConfig {
        threshold,
        spindle_hz: recording.speed.first_hz(),
        teeth: recording.teeth,
        aliased: recording.aliased,
        verdict: recording.numbers,
        ..config(recording)
    };
    run(recording, config, |message| match message {
        Telemetry::Alarm(alarm) => {
            let t = alarm.sample as f64 / recording.fs_hz();
            match said.alarms.last_mut() {
                Some(last) if !alarm.on => last.off_s = t,
                _ if alarm.on => said.alarms.push(Alarm {
                    on_s: t,
                    off_s: end_s,
                    f_hz: f64::from(alarm.frequency),
                }),
                _ => {}
            }
        }
        Telemetry::Verdict(verdict) => {
            let t = verdict.sample as f64 / recording.fs_hz();
            match (warned, verdict.state == State::Warning) {
                (None, true) => warned = Some(t),
                (Some(from), false) => {
                    said.warnings_s.push((from, t));
                    warned = None;
                }
                _ => {}
            }
        }
        _ => {}
    })?;
    said.warnings_s.extend(warned.map(|from| (from, end_s)));
    Ok(said)
}
