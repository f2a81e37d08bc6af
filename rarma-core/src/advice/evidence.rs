//! How well a case agrees with other cuts, and whose chatter theirs is.

use super::heard::{HeardChatter, KnownCut, MOST_KNOWN, Outcome};
use super::mode::{DOUBT, Dominant, Hypothesis, dominant, doubt, each};
use super::phase::{phase_of, ratio_of};
use crate::decide::Structure;
use crate::real::Real;

// Figures: 145 cuts beyond their limit of seeds 1..1000 of the population, 92 of them with a pocket, and
// five more cuts of each at speeds and depths that were drawn. Part of the first proposals that are stable without a structure and
// with one, and of the 53 without a pocket for which one is said, without a structure: 0.71, 0.76, 0.11.

/// Modes whose chatter is told apart.
pub(super) const MOST_MODES: usize = 4;
/// Weight of a case that a cut contradicts: no case is the truth. 0.02: 0.71, 0.77, 0.13; 0.15: 0.68, 0.76,
/// 0.09.
pub(super) const CONTRADICTED: f64 = 0.05;
/// Density of the frequency of a chatter of another mode, per unit of its logarithm: where the cases
/// of a mode say less than this, it is another's. 0.2 and 1.5: within 0.01.
const OTHER: f64 = 0.5;

/// Chatter that a belief in one mode begins with.
#[derive(Clone, Copy)]
pub(super) struct Anchor<T> {
    pub heard: HeardChatter<T>,
    /// Depth of its cut over that of the one asked about.
    pub depth: T,
    pub told: Option<Dominant<T>>,
    /// Known cuts whose chatter is this mode's, too.
    pub own: [bool; MOST_KNOWN],
}

impl<T: Real> Anchor<T> {
    /// Frequencies of more than one cut are known.
    pub fn is_fine(&self) -> bool {
        self.own.iter().any(|own| *own)
    }
}

/// What the cuts are evidence of.
pub(super) struct Evidence<'a, T> {
    known: &'a [KnownCut<T>],
    structure: Option<&'a Structure<T>>,
    teeth: u32,
    spindle_sd: T,
}

impl<'a, T: Real> Evidence<'a, T> {
    /// Of the last [`MOST_KNOWN`] of these cuts.
    pub fn new(
        heard: &HeardChatter<T>,
        structure: Option<&'a Structure<T>>,
        known: &'a [KnownCut<T>],
    ) -> Self {
        let last = known.get(known.len().saturating_sub(MOST_KNOWN)..);
        Self {
            known: last.unwrap_or_default(),
            structure,
            teeth: heard.teeth,
            spindle_sd: doubt(heard.spindle_sd_hz, heard.spindle_hz),
        }
    }

    pub fn known(&self) -> &'a [KnownCut<T>] {
        self.known
    }

    /// The modes that have chattered: that of the cut asked about first.
    pub fn anchors(&self, heard: &HeardChatter<T>) -> [Option<Anchor<T>>; MOST_MODES] {
        let mut out = [None; MOST_MODES];
        let mut free: [bool; MOST_KNOWN] = core::array::from_fn(|k| self.chatter(k).is_some());
        let mut next = Some((*heard, T::ONE));
        for slot in &mut out {
            let Some((heard, depth)) = next else {
                break;
            };
            let mut anchor = Anchor {
                heard,
                depth,
                told: self.structure.and_then(|s| dominant(&heard, s)),
                own: [false; MOST_KNOWN],
            };
            for (k, free) in free.iter_mut().enumerate() {
                if *free && self.is_of(&anchor, k) {
                    anchor.own[k] = true;
                    *free = false;
                }
            }
            *slot = Some(anchor);
            // The latest of those that are nobody's yet.
            let last = free.iter().rposition(|free| *free);
            next = last.and_then(|k| {
                free[k] = false;
                self.chatter(k)
            });
        }
        out
    }

    /// The chatter of a known cut whose frequency was heard, and its depth.
    fn chatter(&self, k: usize) -> Option<(HeardChatter<T>, T)> {
        let cut = self.known.get(k)?;
        let Outcome::Chatter {
            f_hz: Some((f_hz, f_sd_hz)),
        } = cut.outcome
        else {
            return None;
        };
        let heard = HeardChatter {
            f_hz,
            f_sd_hz,
            spindle_hz: cut.spindle_hz,
            spindle_sd_hz: self.spindle_sd * cut.spindle_hz,
            teeth: self.teeth,
        };
        Some((heard, cut.depth))
    }

    /// The chatter of a known cut is of this mode.
    fn is_of(&self, anchor: &Anchor<T>, k: usize) -> bool {
        let Some((heard, _)) = self.chatter(k) else {
            return false;
        };
        if let (Some(told), Some(structure)) = (anchor.told, self.structure) {
            return dominant(&heard, structure).is_some_and(|d| d.place == told.place);
        }
        let (mut sum, mut weight) = (T::ZERO, T::ZERO);
        each(&anchor.heard, anchor.depth, None, true, &mut |case| {
            weight += T::ONE;
            if let Some((off, sd)) = self.off(&case, k) {
                sum += (T::from_f64(-0.5) * off * off).exp() / sd;
            }
        });
        sum > weight * T::from_f64(OTHER * 2.5066)
    }

    /// How far the frequency of a known chatter lies off what a case says, in standard deviations,
    /// and one of these, of its logarithm; none where its phase lies on the other side.
    fn off(&self, case: &Hypothesis<T>, k: usize) -> Option<(T, T)> {
        let (heard, depth) = self.chatter(k)?;
        let waves = heard.waves();
        let phase = phase_of(waves);
        if phase.side != case.side {
            return None;
        }
        let load = case.told_load * depth;
        let ratio = ratio_of(&phase, load, case.zeta).max(T::from_f64(0.3));
        let own = doubt(heard.f_sd_hz, heard.f_hz);
        let form = T::from_f64(DOUBT) * case.zeta;
        // What the speed is not known by turns the phase.
        let turned = load * waves * self.spindle_sd * T::from_f64(core::f64::consts::TAU);
        let sd = (own * own + form * form + turned * turned).sqrt();
        Some(((heard.f_hz / (ratio * case.natural_hz)).ln() / sd, sd))
    }

    /// Weight of a case of this mode.
    pub fn weigh(&self, anchor: &Anchor<T>, case: &Hypothesis<T>) -> T {
        let contradicted = T::from_f64(CONTRADICTED);
        let mut weight = T::ONE;
        if case.lobes(anchor.depth).is_stable(anchor.heard.spindle_hz) {
            weight = contradicted;
        }
        for (k, cut) in self.known.iter().enumerate() {
            let stable = || case.lobes(cut.depth).is_stable(cut.spindle_hz);
            match cut.outcome {
                Outcome::Stable if !stable() => weight *= contradicted,
                Outcome::Chatter { f_hz: None } if stable() => weight *= contradicted,
                Outcome::Chatter { f_hz: Some(_) } if anchor.own[k.min(MOST_KNOWN - 1)] => {
                    // At most one contradiction a cut, so that the weight stays a number.
                    let agrees = match self.off(case, k) {
                        Some((off, _)) if !stable() => (T::from_f64(-0.5) * off * off).exp(),
                        _ => T::ZERO,
                    };
                    weight *= agrees.max(contradicted);
                }
                _ => {}
            }
        }
        weight
    }
}
