//! How well a machine agrees with what was heard.

use super::curve::Point;
use rarma_core::advice::{KnownCut, Outcome};

// Parts of what is heard. Of 66 alarms of the population's cuts (seeds 120000 to 120299) 43 lay within 1 % of the root, 13
// between it and its mode, five at a sideband or overtone, five elsewhere.

/// Part of the alarms that are at the frequency of a growing root itself, as chatter that is still small is.
const STRAIGHT: f64 = 0.75;
/// That of chatter that stands: teeth leave the cut, the load is less than that of the depth, and the less it
/// is the nearer the frequency lies to that of the mode. With double, which is what was counted, or half: of 109 first speeds by
/// the true root one fewer is stable or one more, of 55 by the alarm one more or the same; of 43 by the alarm of seeds
/// 1 to 300 the same with double.
const STANDING: f64 = 0.1;
/// That of alarms at a sideband or overtone.
const BESIDE: f64 = 0.1;
/// Density of the rest, alarms of something else, per unit of the logarithm of the frequency: they may
/// lie anywhere in three octaves.
const ELSEWHERE: f64 = (1.0 - STRAIGHT - STANDING - BESIDE) / 2.0;
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

/// What is known of a cut beside its chatter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Conditions<'a> {
    /// Turns a second.
    pub spindle_hz: f64,
    pub teeth: u32,
    /// Natural frequencies of the machine, Hz.
    pub modes_hz: &'a [f64],
}

/// Of a chatter that was heard at a frequency and its standard deviation, Hz, where the machine has these
/// roots; of several that grow any may be heard.
pub(super) fn of_chatter(
    roots: &[Point],
    (f_hz, sd_hz): (f64, f64),
    cut: &Conditions<'_>,
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
    // Flat from one logarithm to the other, with half a bell at either end.
    let between = |from: f64, to: f64| {
        let (low, high) = (from.min(to), from.max(to));
        let off = (f_hz.ln() - f_hz.ln().clamp(low, high)) / sd;
        let area = high - low + sd * (2.0 * core::f64::consts::PI).sqrt();
        (-0.5 * off * off).exp() / area
    };
    // A line at 0 Hz has a logarithm, too: of a number that nothing is near to.
    let ln = |hz: f64| hz.abs().max(f64::MIN_POSITIVE).ln();
    let bell = |at: f64| between(ln(at), ln(at));
    let mut explained = 0.0;
    for own in &growing {
        let turn = (1..=MOST_TURNS).map(|k| f64::from(k) * cut.spindle_hz);
        let tooth = (1..=MOST_TEETH).map(|k| f64::from(k * cut.teeth) * cut.spindle_hz);
        let mut beside: Vec<f64> = turn.chain(tooth).flat_map(|d| [own - d, own + d]).collect();
        beside.extend([2.0 * own, 3.0 * own, 0.5 * own]);
        let sum: f64 = beside.iter().map(|at| bell(*at)).sum();
        let off = |mode: &&f64| (*mode / own).ln().abs();
        let mode = cut.modes_hz.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        explained += STRAIGHT * bell(*own)
            + STANDING * between(ln(*own), ln(*mode.unwrap_or(own)))
            + BESIDE * sum / beside.len() as f64;
    }
    explained /= growing.len() as f64;
    Likelihood {
        weight: explained + ELSEWHERE,
        explained,
    }
}

/// Of what came of a cut of this machine; no frequency explains that a cut was stable.
pub(super) fn of_known(roots: &[Point], cut: &KnownCut<f64>, here: &Conditions<'_>) -> Likelihood {
    let grows = roots.iter().any(|p| p.growth_per_s >= 0.0);
    let weight = match cut.outcome {
        Outcome::Chatter { f_hz: Some(heard) } => {
            let there = Conditions {
                spindle_hz: cut.spindle_hz,
                ..*here
            };
            return of_chatter(roots, heard, &there);
        }
        outcome if (outcome == Outcome::Stable) == grows => CONTRADICTED,
        _ => 1.0,
    };
    Likelihood {
        weight,
        explained: 0.0,
    }
}
