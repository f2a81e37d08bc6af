//! What teeth and runout force of a cut that does not chatter, speed by speed: a pocket of the lobes is where a
//! multiple of the teeth meets a mode, and there it is the most.

use super::Machine;
use super::curve::{CELLS, Span};
use rarma_plants::cut::Process;
use rarma_plants::forced::milling_forced_m;
use rayon::prelude::*;

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
        let played = |cell: usize| {
            let there = machine.process.at_spindle_hz(span.speed_hz(cell));
            match there {
                Process::Milling(config) if wanted(cell) => {
                    let rms_m = milling_forced_m(&config, machine.depth_m).ok();
                    rms_m.filter(|rms_m| *rms_m > 0.0)
                }
                _ => None,
            }
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
