//! What is not known of a cut, as a belief: cases, each with its weight and its lobes.

use super::config::AdviceConfig;
use super::heard::{HeardChatter, KnownCut, MOST_KNOWN};
use super::lobes::{Lobes, Side};
use super::phase::{Phase, load_of, phase_of, ratio_of};
use crate::decide::{StructuralMode, Structure};
use crate::real::Real;

/// Speeds that are looked at, evenly in the logarithm: 0.43 % apart for a reach of 50 to 150 %.
pub(super) const SPEEDS: usize = 256;

// The numbers below were set on the 399 cuts beyond their limit of seeds 1..1000 of the
// population. Figures: part of the cuts with a pocket whose first proposal is stable, and of
// those without for which none is said; 0.77 and 0.82 with a structure, 0.60 and 0.60 without. Changed ones are compared at 0.77 and
// 0.80, 0.63 and 0.47 (a chance of 0.25 in the cases from which on a speed is proposed).

/// Dampings that a mode may have which nobody has told: a tool on its holder. Half of them all:
/// 0.65 and 0.33; double: 0.58 and 0.69.
const ZETAS: [f64; 4] = [0.006, 0.011, 0.02, 0.036];
/// Depths over the limit at which a cut is heard to chatter, where the mode, and so the shift
/// of the frequency, is not known. Their excess halved: 0.65 and 0.42; doubled: 0.58 and 0.60.
const EXCESSES: [f64; 2] = [1.2, 1.8];
/// The load over the one that was worked out. More than 1: teeth that leave the cut lower the
/// load that is heard. Their spread prefers the bottom of a pocket to its rim. 1 alone: 0.75
/// and 0.68; half the spread: 0.78 and 0.76; double: 0.68 and 0.87.
const LOADS: [f64; 4] = [0.7, 1.0, 1.4, 2.0];
/// Off by so many standard deviations: of the waves, and of the mode's frequency.
const OFFS: [f64; 3] = [-1.0, 0.0, 1.0];
/// Doubt about the mode's frequency beside its own standard deviation, parts of its width ζ·f:
/// a cut of two directions is not quite that of one. Half and double: 0.77 and 0.78, 0.75 and
/// 0.83.
const DOUBT: f64 = 0.2;
/// Relative standard deviations are brought into this range: nothing is known better, and what
/// is known worse is not known.
const DOUBTS: (f64, f64) = (0.001, 0.1);
/// A cut that was tried and chatters spoils the speeds around it up to so far away, as a part
/// of it: where every case has it stable, something chatters that is in none.
const SPOILT: f64 = 0.05;
/// Weight of a case that what was heard contradicts: no case is the truth. Half and double:
/// within 0.02.
const CONTRADICTED: f64 = 0.05;
/// A load beyond it is no cut, but a phase on a flip or a whole wave.
const MOST_LOAD: f64 = 0.25;
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
/// A damping that is told is brought into this range: an estimate may fall below 0.
const ZETA: (f64, f64) = (0.001, 0.2);
/// What a shift of the frequency costs in the choice of the mode, per unit of its logarithm.
const FAR: f64 = 20.0;
/// What a shift to the wrong side costs.
const WRONG_SIDE: f64 = 3.0;
/// Depth over the limit that a heard chatter most likely has.
const USUAL_EXCESS: f64 = 1.5;
/// Damping in the middle of [`ZETAS`].
const USUAL_ZETA: f64 = 0.015;

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

/// The mode that chatters, as far as it is known.
#[derive(Clone, Copy)]
struct Dominant<T> {
    /// Its place in the structure.
    place: usize,
    mode: StructuralMode<T>,
    load: T,
}

struct Sums<T> {
    weight: T,
    ln: T,
    ln_square: T,
}

impl<T: Real> Belief<T> {
    /// What one heard chatter, a structure and other cuts make one believe.
    pub(super) fn new(
        config: &AdviceConfig<T>,
        heard: &HeardChatter<T>,
        structure: Option<&Structure<T>>,
        known: &[KnownCut<T>],
    ) -> Self {
        let known = known
            .get(known.len().saturating_sub(MOST_KNOWN)..)
            .unwrap_or_default();
        let dominant = structure.and_then(|s| dominant(heard, s));
        let mut out = Self {
            speeds: grid(config.least_hz, config.top_hz(heard.spindle_hz)),
            chances: [T::ZERO; SPEEDS],
            usual: usual(heard, dominant.as_ref()),
            natural_sd: T::ZERO,
            of_structure: dominant.is_some(),
        };
        let mut sums = Sums {
            weight: T::ZERO,
            ln: T::ZERO,
            ln_square: T::ZERO,
        };
        let mut case = |lobes: Lobes<T>| {
            let mut weight = T::ONE;
            if lobes.is_stable(heard.spindle_hz) {
                weight = T::from_f64(CONTRADICTED);
            }
            for cut in known {
                if lobes.is_stable(cut.spindle_hz) != cut.stable {
                    weight *= T::from_f64(CONTRADICTED);
                }
            }
            add(&mut out.chances, &out.speeds, &lobes, weight);
            let ln = (lobes.natural_hz() / heard.f_hz).ln();
            sums.weight += weight;
            sums.ln += weight * ln;
            sums.ln_square += weight * ln * ln;
        };
        match &dominant {
            Some(dominant) => with_mode(heard, dominant, &mut case),
            None => without_mode(heard, &mut case),
        }
        let mean = sums.ln / sums.weight;
        let variance = sums.ln_square / sums.weight - mean * mean;
        out.natural_sd = variance.max(T::ZERO).sqrt();
        let [told, untold] = SEEN.map(T::from_f64);
        let seen = if out.of_structure { told } else { untold };
        for chance in &mut out.chances {
            *chance *= seen / sums.weight;
        }
        for cut in known.iter().filter(|cut| !cut.stable) {
            for (chance, speed) in out.chances.iter_mut().zip(&out.speeds) {
                let off = (*speed / cut.spindle_hz).ln().abs() / T::from_f64(SPOILT);
                *chance *= off.min(T::ONE);
            }
        }
        if let (Some(structure), Some(dominant)) = (structure, &dominant) {
            for (place, mode) in structure.modes().iter().enumerate() {
                if place != dominant.place {
                    out.other(heard, mode, dominant.load, known);
                }
            }
        }
        out
    }

    /// Another mode of the structure may chatter where the first does not. Which way and how
    /// hard the cut pulls it nobody has told, only that the first was the one to be heard.
    fn other(
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
                let lobes = Lobes::new(mode.f_hz, damping(mode), of, side, heard.teeth);
                let mut weight = bell;
                // A cut that is told to be stable is so of every mode; one that chatters may
                // do it by another.
                let quiet = known.iter().filter(|cut| cut.stable);
                for hz in quiet.map(|cut| cut.spindle_hz).chain([heard.spindle_hz]) {
                    if !lobes.is_stable(hz) {
                        weight *= T::from_f64(CONTRADICTED);
                    }
                }
                add(&mut chances, &self.speeds, &lobes, weight);
                sum += weight;
            }
        }
        for (all, one) in self.chances.iter_mut().zip(chances) {
            *all *= one / sum;
        }
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

fn damping<T: Real>(mode: &StructuralMode<T>) -> T {
    mode.zeta.clamp(T::from_f64(ZETA.0), T::from_f64(ZETA.1))
}

/// The mode of the structure whose chatter this is: the load that it takes must be one that
/// chatters, and the frequency must lie near.
fn dominant<T: Real>(heard: &HeardChatter<T>, structure: &Structure<T>) -> Option<Dominant<T>> {
    let phase = phase_of(heard.waves());
    let mut best: Option<(T, Dominant<T>)> = None;
    for (place, mode) in structure.modes().iter().enumerate() {
        let zeta = damping(mode);
        let ratio = heard.f_hz / mode.f_hz;
        let limit = phase.limit_load(zeta);
        let far = ratio.ln().abs() * T::from_f64(FAR);
        let (cost, load) = match load_of(&phase, ratio, zeta) {
            Some(load) => {
                let odd = (load / limit / T::from_f64(USUAL_EXCESS)).ln().abs();
                (far + odd, load)
            }
            None => (
                far + T::from_f64(WRONG_SIDE),
                limit * T::from_f64(USUAL_EXCESS),
            ),
        };
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            let load = load.min(T::from_f64(MOST_LOAD));
            let mode = *mode;
            best = Some((cost, Dominant { place, mode, load }));
        }
    }
    best.map(|(_, dominant)| dominant)
}

fn usual<T: Real>(heard: &HeardChatter<T>, dominant: Option<&Dominant<T>>) -> Lobes<T> {
    let phase = phase_of(heard.waves());
    match dominant {
        Some(d) => {
            let (hz, zeta) = (d.mode.f_hz, damping(&d.mode));
            Lobes::new(hz, zeta, d.load, phase.side, heard.teeth)
        }
        None => {
            let zeta = T::from_f64(USUAL_ZETA);
            unknown(heard, &phase, zeta, T::from_f64(USUAL_EXCESS)).lobes(heard, phase.side)
        }
    }
}

/// A case of a mode that nobody has told.
struct Unknown<T> {
    natural_hz: T,
    zeta: T,
    load: T,
}

impl<T: Real> Unknown<T> {
    fn lobes(&self, heard: &HeardChatter<T>, side: Side) -> Lobes<T> {
        Lobes::new(self.natural_hz, self.zeta, self.load, side, heard.teeth)
    }
}

fn unknown<T: Real>(heard: &HeardChatter<T>, phase: &Phase<T>, zeta: T, excess: T) -> Unknown<T> {
    let load = (phase.limit_load(zeta) * excess).min(T::from_f64(MOST_LOAD));
    let ratio = ratio_of(phase, load, zeta).max(T::from_f64(0.3));
    Unknown {
        natural_hz: heard.f_hz / ratio,
        zeta,
        load,
    }
}

/// A relative standard deviation within [`DOUBTS`].
fn doubt<T: Real>(sd: T, of: T) -> T {
    (sd / of).clamp(T::from_f64(DOUBTS.0), T::from_f64(DOUBTS.1))
}

/// Relative standard deviation of the waves.
fn waves_sd<T: Real>(heard: &HeardChatter<T>) -> T {
    let (f, n) = (
        heard.f_sd_hz / heard.f_hz,
        heard.spindle_sd_hz / heard.spindle_hz,
    );
    doubt((f * f + n * n).sqrt(), T::ONE)
}

/// Cases of a mode that is told: off in the waves, in the mode, in the load.
fn with_mode<T: Real>(
    heard: &HeardChatter<T>,
    dominant: &Dominant<T>,
    case: &mut impl FnMut(Lobes<T>),
) {
    let (mode, zeta) = (dominant.mode, damping(&dominant.mode));
    let side = phase_of(heard.waves()).side;
    let (form, own) = (T::from_f64(DOUBT) * zeta, doubt(mode.f_sd, mode.f_hz));
    let mode_sd = (form * form + own * own).sqrt();
    let (sd, f_sd) = (waves_sd(heard), doubt(heard.f_sd_hz, heard.f_hz));
    for off in OFFS.map(T::from_f64) {
        let phase = phase_of(heard.waves() * (T::ONE + off * sd));
        let ratio = heard.f_hz * (T::ONE + off * f_sd) / mode.f_hz;
        let load = match load_of(&phase, ratio, zeta) {
            Some(load) if phase.side == side => load.min(T::from_f64(MOST_LOAD)),
            _ => dominant.load,
        };
        for times in LOADS.map(T::from_f64) {
            for shift in OFFS.map(T::from_f64) {
                let hz = mode.f_hz * (T::ONE + shift * mode_sd);
                case(Lobes::new(hz, zeta, load * times, side, heard.teeth));
            }
        }
    }
}

/// Cases of a mode that nobody has told: its damping and the depth besides.
fn without_mode<T: Real>(heard: &HeardChatter<T>, case: &mut impl FnMut(Lobes<T>)) {
    let sd = waves_sd(heard);
    for off in OFFS.map(T::from_f64) {
        let phase = phase_of(heard.waves() * (T::ONE + off * sd));
        for zeta in ZETAS.map(T::from_f64) {
            for excess in EXCESSES.map(T::from_f64) {
                let one = unknown(heard, &phase, zeta, excess);
                for times in LOADS.map(T::from_f64) {
                    for shift in OFFS.map(T::from_f64) {
                        let off = T::ONE + shift * T::from_f64(DOUBT) * zeta;
                        let moved = Unknown {
                            natural_hz: one.natural_hz * off,
                            load: one.load * times,
                            ..one
                        };
                        case(moved.lobes(heard, phase.side));
                    }
                }
            }
        }
    }
}
