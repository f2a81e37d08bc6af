//! What is not known of a cut, as a belief: at which speeds it is stable, and how likely.

use super::config::AdviceConfig;
use super::evidence::{Anchor, CONTRADICTED, Evidence};
use super::heard::{HeardChatter, KnownCut};
use super::lobes::{Lobes, Side};
use super::mode::{damping, each, usual};
use crate::decide::{StructuralMode, Structure};
use crate::real::Real;

/// Speeds that are looked at, evenly in the logarithm: 0.43 % apart for a reach of 50 to 150 %.
pub(super) const SPEEDS: usize = 256;

// Set as those of `mode`; figures with known cuts are those of `evidence`.

/// A cut that was tried and chatters spoils the speeds around it up to so far away, as a part
/// of it: where every case has it stable, something chatters that is in none.
const SPOILT: f64 = 0.05;
/// Chance that a speed that was stable, as deep, is so again; it falls to nothing over the same
/// way. Without it, after six cuts, 0.66 and 0.72 of first proposals are stable, with it 0.71 and 0.76.
const PROVEN: f64 = 0.95;
/// The load on another mode over that on the one that chatters: e^(mean + deviation·u). The
/// stiffnesses of a structure's modes lie within some 16 times of each other. A mean of half
/// or double the load: 0.77 and 0.79, 0.75 and 0.85; a deviation of 0.6 or 1.2: within 0.03.
const OTHERS: (f64, f64) = (-0.3, 0.8);
/// Standard deviations u at which it is looked at.
const OTHERS_AT: [f64; 9] = [-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0];
/// Part of the truth that lies in the cases at all, with a structure and without: of the first
/// proposals that every case has stable, 0.79 and 0.67 are so. What is missing is modes that
/// nobody has told, and short arcs.
const SEEN: [f64; 2] = [0.8, 0.6];

/// The belief, over a grid of speeds.
pub(super) struct Belief<T> {
    /// Speeds, turns a second, rising.
    pub speeds: [T; SPEEDS],
    /// Chance that the cut is stable there.
    pub chances: [T; SPEEDS],
    /// The likeliest lobes.
    pub usual: Lobes<T>,
    /// Relative standard deviation of the mode's frequency.
    pub natural_sd: T,
    /// Whether a mode of the structure was taken.
    pub of_structure: bool,
}

/// What is likely of one mode.
struct Likely<T> {
    /// Relative standard deviation of its frequency.
    natural_sd: T,
    /// Those of its mean frequency, damping and load.
    lobes: Lobes<T>,
}

impl<T: Real> Belief<T> {
    /// What one heard chatter, a structure and other cuts make one believe.
    pub(super) fn new(
        config: &AdviceConfig<T>,
        heard: &HeardChatter<T>,
        structure: Option<&Structure<T>>,
        known: &[KnownCut<T>],
    ) -> Self {
        let evidence = Evidence::new(heard, structure, known);
        let anchors = evidence.anchors(heard);
        let told = anchors[0].and_then(|a| a.told);
        let [with, without] = SEEN.map(T::from_f64);
        let mut out = Self {
            speeds: grid(config.least_hz, config.top_hz(heard.spindle_hz)),
            chances: [if told.is_some() { with } else { without }; SPEEDS],
            usual: usual(heard, told.as_ref()),
            natural_sd: T::ZERO,
            of_structure: told.is_some(),
        };
        for (place, anchor) in anchors.iter().flatten().enumerate() {
            let likely = out.heard(&evidence, anchor);
            if place == 0 {
                out.natural_sd = likely.natural_sd;
                if anchor.is_fine() && told.is_none() {
                    out.usual = likely.lobes;
                }
            }
        }
        if let (Some(structure), Some(told)) = (structure, told) {
            for (place, mode) in structure.modes().iter().enumerate() {
                let mut chattered = anchors.iter().flatten().filter_map(|a| a.told);
                if !chattered.any(|told| told.place == place) {
                    out.silent(heard, mode, told.load, evidence.known());
                }
            }
        }
        evidence.known().iter().for_each(|cut| out.tried(cut));
        out
    }

    /// The same with chances that are known otherwise, and what came of the speeds that were tried.
    pub(super) fn by(mut self, chance: impl Fn(T) -> T, known: &[KnownCut<T>]) -> Self {
        self.chances = self.speeds.map(chance);
        known.iter().for_each(|cut| self.tried(cut));
        self
    }

    /// What came of a speed says something of those around it, whatever the cases say: one that chattered no
    /// deeper than the cut that is asked about spoils them, one that was stable as deep holds for them.
    fn tried(&mut self, cut: &KnownCut<T>) {
        let (stable, depth) = (cut.is_stable(), cut.depth);
        if if stable {
            depth < T::ONE
        } else {
            depth > T::ONE
        } {
            return;
        }
        for (chance, speed) in self.chances.iter_mut().zip(&self.speeds) {
            let off = (*speed / cut.spindle_hz).ln().abs() / T::from_f64(SPOILT);
            let off = off.min(T::ONE);
            if stable {
                *chance = chance.max(T::from_f64(PROVEN) * (T::ONE - off));
            } else {
                *chance *= off;
            }
        }
    }

    /// A mode that has chattered may do so at other speeds; gives what is likely of it.
    fn heard(&mut self, evidence: &Evidence<'_, T>, anchor: &Anchor<T>) -> Likely<T> {
        let mut chances = [T::ZERO; SPEEDS];
        let mut sum = T::ZERO;
        // Means of the logarithms over those of the anchor: frequency, its square, damping, load.
        let mut means = [T::ZERO; 4];
        let mut side = Side::Above;
        let (told, is_fine) = (anchor.told.as_ref(), anchor.is_fine());
        each(&anchor.heard, anchor.depth, told, is_fine, &mut |case| {
            let weight = evidence.weigh(anchor, &case);
            add(&mut chances, &self.speeds, &case.lobes(T::ONE), weight);
            let ln = (case.natural_hz / anchor.heard.f_hz).ln();
            sum += weight;
            for (mean, x) in means
                .iter_mut()
                .zip([ln, ln * ln, case.zeta.ln(), case.load.ln()])
            {
                *mean += weight * x;
            }
            side = case.side;
        });
        self.multiply(&chances, sum);
        let [ln, square, zeta, load] = means.map(|mean| mean / sum);
        let natural_hz = anchor.heard.f_hz * ln.exp();
        Likely {
            natural_sd: (square - ln * ln).max(T::ZERO).sqrt(),
            lobes: Lobes::new(natural_hz, zeta.exp(), load.exp(), side, anchor.heard.teeth),
        }
    }

    fn multiply(&mut self, chances: &[T; SPEEDS], sum: T) {
        for (all, one) in self.chances.iter_mut().zip(chances) {
            *all *= *one / sum;
        }
    }

    /// A mode of the structure that has not been heard may chatter where others do not. Which way and
    /// how hard the cut pulls it nobody has told, only that another was the one to be heard.
    fn silent(
        &mut self,
        heard: &HeardChatter<T>,
        mode: &StructuralMode<T>,
        load: T,
        known: &[KnownCut<T>],
    ) {
        let mut chances = [T::ZERO; SPEEDS];
        let mut sum = T::ZERO;
        for u in OTHERS_AT {
            let of = load * T::from_f64(OTHERS.0 + OTHERS.1 * u).exp();
            let bell = T::from_f64(-0.5 * u * u).exp();
            for side in [Side::Above, Side::Below] {
                let lobes =
                    |depth| Lobes::new(mode.f_hz, damping(mode), of * depth, side, heard.teeth);
                let mut weight = bell;
                // A cut that is told to be stable is so of every mode; one that chatters may
                // do it by another.
                let quiet = known.iter().filter(|cut| cut.is_stable());
                let quiet = quiet.map(|cut| (cut.spindle_hz, cut.depth));
                for (hz, depth) in quiet.chain([(heard.spindle_hz, T::ONE)]) {
                    if !lobes(depth).is_stable(hz) {
                        weight *= T::from_f64(CONTRADICTED);
                    }
                }
                add(&mut chances, &self.speeds, &lobes(T::ONE), weight);
                sum += weight;
            }
        }
        self.multiply(&chances, sum);
    }
}

fn add<T: Real>(chances: &mut [T; SPEEDS], speeds: &[T; SPEEDS], lobes: &Lobes<T>, weight: T) {
    for (chance, speed) in chances.iter_mut().zip(speeds) {
        if lobes.is_stable(*speed) {
            *chance += weight;
        }
    }
}

/// Evenly in the logarithm, both ends included.
fn grid<T: Real>(least: T, most: T) -> [T; SPEEDS] {
    let step = (most / least).ln() / T::from_u32(SPEEDS as u32 - 1);
    core::array::from_fn(|i| least * (step * T::from_u32(i as u32)).exp())
}
