//! A bare threshold on the damping.

use super::monitor::{config, run};
use super::{Detector, Recording, Said};
use crate::Defect;
use rarma_box::wire::Telemetry;

/// The threshold must be passed for so long, s.
const HELD_S: f64 = 0.1;

/// The least damping of any pole in the band, held; that damping.
pub(super) struct BareDamping;

impl Detector for BareDamping {
    fn name(&self) -> &'static str {
        "bare damping"
    }

    fn threshold(&self) -> &'static str {
        "least damping ratio of any pole, 1"
    }

    fn thresholds(&self) -> &'static [f64] {
        &[0.01, 0.0005, 0.001, 0.002, 0.005, 0.02]
    }

    fn asks_speed(&self) -> bool {
        false
    }

    fn listen(&self, recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect> {
        bare(recording, thresholds)
    }
}

/// The damping of the least damped pole, and nothing else asked: no speed, no loudness.
fn bare(recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect> {
    let mut least: Vec<(f64, f64, f64)> = Vec::new();
    run(recording, config(recording), |message| {
        if let Telemetry::Verdict(verdict) = message {
            let mode = verdict
                .modes
                .iter()
                .min_by(|a, b| a.damping.total_cmp(&b.damping));
            if let Some(mode) = mode {
                least.push((
                    verdict.sample as f64 / recording.fs_hz(),
                    f64::from(mode.damping),
                    f64::from(mode.frequency),
                ));
            }
        }
    })?;
    Ok(thresholds
        .iter()
        .map(|threshold| {
            let mut said = Said::default();
            let mut since: Option<f64> = None;
            for (t, zeta, f_hz) in &least {
                if zeta >= threshold {
                    since = None;
                    continue;
                }
                let from = *since.get_or_insert(*t);
                if t - from < HELD_S {
                    continue;
                }
                said.calls(*t, *t, *f_hz);
            }
            said
        })
        .collect())
}
