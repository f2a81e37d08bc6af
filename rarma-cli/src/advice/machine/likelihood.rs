//! How well a machine agrees with what was heard.

use super::curve::Point;
use rarma_core::advice::{KnownCut, Outcome};

/// Part of the alarms that are at the frequency of a growing root itself; and at a sideband or overtone of
/// it: on random cuts nine of ten lie within some percent.
const STRAIGHT: f64 = 0.85;
const BESIDE: f64 = 0.12;
/// Density of the rest, alarms of something else, per unit of the logarithm of the frequency: they may
/// lie anywhere in three octaves.
const ELSEWHERE: f64 = (1.0 - STRAIGHT - BESIDE) / 2.0;
/// Sidebands to either side: so many turns and teeth off.
const MOST_TURNS: u32 = 2;
const MOST_TEETH: u32 = 3;
/// Weight of a machine that an outcome without a frequency contradicts: no machine is the truth.
const CONTRADICTED: f64 = 0.05;
/// No frequency is known better than this part of it.
const LEAST_SD: f64 = 0.002;

/// A weight, and the part of it that comes of a frequency that the machine has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Likelihood {
    pub weight: f64,
    pub explained: f64,
}

/// Of a chatter that was heard at a frequency and its standard deviation, Hz, where the machine has these
/// roots; of several that grow any may be heard.
pub(super) fn of_chatter(
    roots: &[Point],
    (f_hz, sd_hz): (f64, f64),
    spindle_hz: f64,
    teeth: u32,
) -> Likelihood {
    let growing: Vec<f64> = roots
        .iter()
        .filter(|p| p.growth_per_s >= 0.0 && p.f_hz.is_finite())
        .map(|p| p.f_hz)
        .collect();
    if growing.is_empty() {
        // It chatters, and here it does not.
        return Likelihood {
            weight: CONTRADICTED * ELSEWHERE,
            explained: 0.0,
        };
    }
    let sd = (sd_hz / f_hz).max(LEAST_SD);
    let bell = |at: f64| {
        let off = (f_hz / at).ln() / sd;
        (-0.5 * off * off).exp() / (sd * (2.0 * core::f64::consts::PI).sqrt())
    };
    let mut explained = 0.0;
    for own in &growing {
        let turn = (1..=MOST_TURNS).map(|k| f64::from(k) * spindle_hz);
        let tooth = (1..=MOST_TEETH).map(|k| f64::from(k * teeth) * spindle_hz);
        let mut beside: Vec<f64> = turn.chain(tooth).flat_map(|d| [own - d, own + d]).collect();
        beside.extend([2.0 * own, 3.0 * own, 0.5 * own]);
        let sum: f64 = beside.iter().map(|at| bell(at.abs())).sum();
        explained += STRAIGHT * bell(*own) + BESIDE * sum / beside.len() as f64;
    }
    explained /= growing.len() as f64;
    Likelihood {
        weight: explained + ELSEWHERE,
        explained,
    }
}

/// Of what came of another cut.
pub(super) fn of_known(roots: &[Point], cut: &KnownCut<f64>, teeth: u32) -> f64 {
    let grows = roots.iter().any(|p| p.growth_per_s >= 0.0);
    match cut.outcome {
        Outcome::Chatter { f_hz: Some(heard) } => {
            of_chatter(roots, heard, cut.spindle_hz, teeth).weight
        }
        outcome if (outcome == Outcome::Stable) == grows => CONTRADICTED,
        _ => 1.0,
    }
}
