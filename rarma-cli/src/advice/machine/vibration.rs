//! What teeth and runout force of a cut that does not chatter, speed by speed: a pocket of the lobes is where a
//! multiple of the teeth meets a mode, and there it is the most.

use super::Machine;
use super::curve::{CELLS, Span};
use core::f64::consts::TAU;
use hal_sim::plant::cut::Process;
use hal_sim::plant::milling::{Milling, MillingConfig};
use hal_sim::plant::process::{ForceNoise, Schedule};
use rayon::prelude::*;

/// What came of the start has left after so many time constants of the mode that keeps it longest: 2 % are left.
const SETTLED: f64 = 4.0;
/// ... but nobody waits longer, s: a mode of 100 Hz and 1 % takes 0.64.
const MOST_S: f64 = 0.5;
/// It is measured over whole turns, so long at least, s.
const MEASURED_S: f64 = 0.05;
/// Steps a period of the fastest mode: the force is a square, and its third multiple counts.
const STEPS: f64 = 40.0;

/// Vibration of the tool, m rms, over a stretch of speeds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Vibration {
    span: Span,
    /// By the cell; none where nobody asks, or nothing is forced.
    rms_m: Vec<Option<f64>>,
}

impl Vibration {
    /// Of a machine, in cells that are wanted.
    pub(super) fn new(
        machine: &Machine,
        span: Span,
        wanted: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        let played = |cell: usize| match &machine.process {
            Process::Milling(config) if wanted(cell) => {
                forced_m(config, span.speed_hz(cell), machine.depth_m)
            }
            _ => None,
        };
        Self {
            span,
            rms_m: (0..=CELLS).into_par_iter().map(played).collect(),
        }
    }

    /// At a speed, turns a second; where nobody has asked, as much as anywhere.
    pub(super) fn at(&self, spindle_hz: f64) -> f64 {
        let place = self.span.place(spindle_hz);
        let ends = [place.floor(), place.ceil()].map(|cell| self.rms_m[cell as usize]);
        let part = place.fract();
        match ends {
            [Some(a), Some(b)] => a.powf(1.0 - part) * b.powf(part),
            [Some(one), None] | [None, Some(one)] => one,
            [None, None] => {
                let most = self.rms_m.iter().flatten().copied().reduce(f64::max);
                most.unwrap_or(1.0)
            }
        }
    }
}

/// Vibration of the tool about its mean, m rms, once the start has died away; none where the equation cannot be
/// played.
fn forced_m(config: &MillingConfig, spindle_hz: f64, depth_m: f64) -> Option<f64> {
    let modes = config.shaped_modes();
    let slowest = modes.iter().map(|m| m.mode.zeta * m.mode.f_hz);
    let slowest_per_s = TAU * slowest.reduce(f64::min)?;
    let fastest_hz = modes.iter().map(|m| m.mode.f_hz).fold(0.0, f64::max);
    let mut mill = Milling::new(MillingConfig {
        spindle_hz,
        speed: None,
        variation: None,
        workpiece: None,
        depth: Schedule::constant(depth_m),
        noise: ForceNoise::default(),
        min_step_rate_hz: STEPS * fastest_hz,
        ..config.clone()
    })
    .ok()?;
    let steps = |s: f64| (s / mill.dt()).ceil() as usize;
    let settles = steps((SETTLED / slowest_per_s).min(MOST_S));
    let turns = (MEASURED_S * spindle_hz).ceil();
    let count = steps(turns / spindle_hz);
    (0..settles).for_each(|_| {
        mill.step();
    });
    let (mut sum, mut squares) = ([0.0; 2], 0.0);
    for _ in 0..count {
        let at = mill.step().position_m;
        for (sum, x) in sum.iter_mut().zip(at) {
            *sum += x / count as f64;
            squares += x * x / count as f64;
        }
    }
    let variance = squares - sum.iter().map(|x| x * x).sum::<f64>();
    (variance > 0.0).then(|| variance.sqrt())
}
