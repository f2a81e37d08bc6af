//! A virtual cut as the box's estimators get it: played, band-limited, decimated.

use crate::banded;
use crate::error::ScenarioError;
use crate::scenario::Loaded;
use rarma_core::condition::Band;
use rarma_plants::cut::{Process, Scenario, VirtualCut};
use rarma_plants::delay::Root;
use rarma_plants::process::Schedule;

/// Of a cut from standstill, left out of every estimate, s.
pub const SETTLE_S: f64 = 0.5;

/// What was heard.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard {
    /// Rate of the converter, Hz.
    pub fs: f64,
    /// Samples as parts of full scale.
    pub samples: Vec<f64>,
    /// Rate after the band filter, Hz.
    pub band_fs: f64,
    /// Samples in the band, without the first [`SETTLE_S`].
    pub band: Vec<f64>,
}

/// What becomes of the forced vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Forced {
    /// It stays, as in any recording.
    Kept,
    /// The same cut without anything random is played beside it and subtracted. Only
    /// a virtual machine can do that, and only in a stable cut: chatter does not
    /// repeat.
    Removed,
}

/// Plays a scenario and conditions it as the box does.
///
/// # Errors
/// What the plant or the band refuses, in a line.
pub fn hear(scenario: &Scenario, band: Band, forced: Forced) -> Result<Heard, ScenarioError> {
    let refused =
        |what: String| ScenarioError::whole(&scenario.name, what, "correct the fields it names");
    let cut = VirtualCut::new(scenario).map_err(|why| refused(why.to_string()))?;
    let fs = cut.sample_rate_hz();
    let mut samples: Vec<f64> = cut.map(|r| f64::from(r.value)).collect();
    if forced == Forced::Removed {
        let still = VirtualCut::new(&silent(scenario)).map_err(|why| refused(why.to_string()))?;
        for (x, r) in samples.iter_mut().zip(still) {
            *x -= f64::from(r.value);
        }
    }
    let part = banded::through(&samples, fs, band).map_err(|why| refused(format!("box: {why}")))?;
    let from = ((SETTLE_S * part.fs) as usize).min(part.samples.len());
    Ok(Heard {
        fs,
        samples,
        band_fs: part.fs,
        band: part.samples[from..].to_vec(),
    })
}

/// The same cut with nothing random in it.
fn silent(scenario: &Scenario) -> Scenario {
    let mut out = scenario.clone();
    let noise = match &mut out.process {
        Process::Milling(c) => &mut c.noise,
        Process::Turning(c) => &mut c.noise,
    };
    noise.relative = 0.0;
    noise.background_n = 0.0;
    out.microphone.noise_pa = 0.0;
    out.microphone.converter.dither = false;
    out
}

/// The same cut held at one depth for `seconds` after settling, with this seed.
pub fn held(loaded: &Loaded, process: &Process, depth_m: f64, seconds: f64, seed: u64) -> Scenario {
    Scenario {
        process: process.at_depth(Schedule::constant(depth_m)),
        duration_s: SETTLE_S + seconds,
        ..loaded.scenario.clone()
    }
    .seeded(seed)
}

/// Roots that can be heard in a band: inside it, damped by less than `most`.
pub fn audible(roots: &[Root], band: Band, most: f64) -> Vec<Root> {
    roots
        .iter()
        .filter(|r| r.f_hz >= band.low_hz && r.f_hz <= band.high_hz && r.zeta < most)
        .copied()
        .collect()
}

/// A root belongs to a mode within this part of its frequency.
const NEIGHBOUR: f64 = 0.12;

/// The least damped root next to each mode of the structure, out of those that can be
/// heard. Where a revolution holds many vibrations each mode is surrounded by roots,
/// one every 1/τ; a model of low order cannot tell them apart, and only the first to
/// lose its damping matters.
pub fn dominant(process: &Process, roots: &[Root]) -> Vec<Root> {
    let mut out: Vec<Root> = Vec::new();
    for mode in process.modes() {
        let near = roots
            .iter()
            .filter(|r| (r.f_hz / mode.mode.f_hz - 1.0).abs() < NEIGHBOUR)
            .min_by(|a, b| a.zeta.total_cmp(&b.zeta));
        if let Some(root) = near
            && !out.contains(root)
        {
            out.push(*root);
        }
    }
    out.sort_by(|a, b| a.f_hz.total_cmp(&b.f_hz));
    out
}

/// Whether `f` lies on a multiple of the tooth frequency, or of the spindle's where
/// teeth differ; turning has no forced lines.
pub fn is_forced(process: &Process, f: f64, f_sd: f64) -> bool {
    let Process::Milling(c) = process else {
        return false;
    };
    let equal = c.pitch_rad.is_empty() && c.runout_m.iter().all(|r| *r == 0.0);
    let spacing = if equal { c.tooth_hz() } else { c.spindle_hz };
    let width = (2.0 * f_sd.max(0.0)).max(2.0).min(0.15 * spacing);
    let nearest = (f / spacing).round().max(1.0) * spacing;
    (f - nearest).abs() <= width
}
