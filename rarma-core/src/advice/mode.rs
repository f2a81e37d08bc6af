//! What is not known of one mode that chatters: cases.

use super::heard::HeardChatter;
use super::lobes::{Lobes, Side};
use super::phase::{Phase, load_of, phase_of, ratio_of};
use crate::decide::{StructuralMode, Structure};
use crate::real::Real;

// The numbers below were set on the 399 cuts beyond their limit of seeds 1..1000 of the
// population. Figures: part of the cuts with a pocket whose first proposal is stable, and of
// those without for which none is said; 0.77 and 0.82 with a structure, 0.60 and 0.60 without. Changed ones are compared at 0.77 and
// 0.80, 0.63 and 0.47 (a chance of 0.25 in the cases from which on a speed is proposed).

/// Dampings that a mode may have which nobody has told: a tool on its holder. Half of them all:
/// 0.65 and 0.33; double: 0.58 and 0.69.
pub(super) const ZETAS: [f64; 4] = [0.006, 0.011, 0.02, 0.036];
/// Depths over the limit at which a cut is heard to chatter, where the mode, and so the shift
/// of the frequency, is not known. Their excess halved: 0.65 and 0.42; doubled: 0.58 and 0.60.
pub(super) const EXCESSES: [f64; 2] = [1.2, 1.8];
/// The same where the frequencies of several cuts tell of both: finer, and wider. They were set
/// on 150 cuts of the same seeds.
const FINE_ZETAS: [f64; 9] = [
    0.004, 0.0055, 0.0075, 0.0103, 0.014, 0.0192, 0.0263, 0.036, 0.05,
];
const FINE_EXCESSES: [f64; 8] = [1.05, 1.15, 1.3, 1.5, 1.8, 2.2, 3.0, 4.0];
/// The load over the one that was worked out. More than 1: teeth that leave the cut lower the
/// load that is heard. Their spread prefers the bottom of a pocket to its rim. 1 alone: 0.75
/// and 0.68; half the spread: 0.78 and 0.76; double: 0.68 and 0.87.
const LOADS: [f64; 4] = [0.7, 1.0, 1.4, 2.0];
/// Off by so many standard deviations: of the waves, and of the mode's frequency.
const OFFS: [f64; 3] = [-1.0, 0.0, 1.0];
/// Doubt about the mode's frequency beside its own standard deviation, parts of its width ζ·f:
/// a cut of two directions is not quite that of one. Half and double: 0.77 and 0.78, 0.75 and
/// 0.83.
pub(super) const DOUBT: f64 = 0.2;
/// Relative standard deviations are brought into this range: nothing is known better, and what
/// is known worse is not known.
const DOUBTS: (f64, f64) = (0.001, 0.1);
/// A load beyond it is no cut, but a phase on a flip or a whole wave.
pub(super) const MOST_LOAD: f64 = 0.25;
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

/// The mode that chatters, as far as it is known.
#[derive(Clone, Copy)]
pub(super) struct Dominant<T> {
    /// Its place in the structure.
    pub place: usize,
    pub mode: StructuralMode<T>,
    pub load: T,
}

pub(super) fn damping<T: Real>(mode: &StructuralMode<T>) -> T {
    mode.zeta.clamp(T::from_f64(ZETA.0), T::from_f64(ZETA.1))
}

/// The mode of the structure whose chatter this is: the load that it takes must be one that
/// chatters, and the frequency must lie near.
pub(super) fn dominant<T: Real>(
    heard: &HeardChatter<T>,
    structure: &Structure<T>,
) -> Option<Dominant<T>> {
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

pub(super) fn usual<T: Real>(heard: &HeardChatter<T>, dominant: Option<&Dominant<T>>) -> Lobes<T> {
    let phase = phase_of(heard.waves());
    match dominant {
        Some(d) => {
            let (hz, zeta) = (d.mode.f_hz, damping(&d.mode));
            Lobes::new(hz, zeta, d.load, phase.side, heard.teeth)
        }
        None => {
            let zeta = T::from_f64(USUAL_ZETA);
            let one = unknown(heard, &phase, zeta, T::from_f64(USUAL_EXCESS));
            Lobes::new(one.natural_hz, zeta, one.load, phase.side, heard.teeth)
        }
    }
}

/// A case of a mode that nobody has told.
pub(super) struct Unknown<T> {
    pub natural_hz: T,
    pub zeta: T,
    pub load: T,
}

pub(super) fn unknown<T: Real>(
    heard: &HeardChatter<T>,
    phase: &Phase<T>,
    zeta: T,
    excess: T,
) -> Unknown<T> {
    let load = (phase.limit_load(zeta) * excess).min(T::from_f64(MOST_LOAD));
    let ratio = ratio_of(phase, load, zeta).max(T::from_f64(0.3));
    Unknown {
        natural_hz: heard.f_hz / ratio,
        zeta,
        load,
    }
}

/// A relative standard deviation within [`DOUBTS`].
pub(super) fn doubt<T: Real>(sd: T, of: T) -> T {
    (sd / of).clamp(T::from_f64(DOUBTS.0), T::from_f64(DOUBTS.1))
}

/// Relative standard deviation of the waves.
pub(super) fn waves_sd<T: Real>(heard: &HeardChatter<T>) -> T {
    let (f, n) = (
        heard.f_sd_hz / heard.f_hz,
        heard.spindle_sd_hz / heard.spindle_hz,
    );
    doubt((f * f + n * n).sqrt(), T::ONE)
}

/// One case of one mode.
#[derive(Clone, Copy)]
pub(super) struct Hypothesis<T> {
    pub natural_hz: T,
    pub zeta: T,
    /// The load that the frequency of its chatter tells, and the one that its lobes have, of the
    /// cut that is asked about.
    pub told_load: T,
    pub load: T,
    pub side: Side,
    pub teeth: u32,
}

impl<T: Real> Hypothesis<T> {
    /// The lobes of a cut so many times as deep.
    pub fn lobes(&self, depth: T) -> Lobes<T> {
        Lobes::new(
            self.natural_hz,
            self.zeta,
            self.load * depth,
            self.side,
            self.teeth,
        )
    }
}

/// All cases of the mode that was heard in a cut of this depth: one that is told, or one that
/// nobody has told, coarse or fine.
pub(super) fn each<T: Real>(
    heard: &HeardChatter<T>,
    depth: T,
    told: Option<&Dominant<T>>,
    is_fine: bool,
    case: &mut impl FnMut(Hypothesis<T>),
) {
    let mut scaled = |one: Hypothesis<T>| {
        case(Hypothesis {
            told_load: one.told_load / depth,
            load: one.load / depth,
            ..one
        });
    };
    match told {
        Some(told) => with_mode(heard, told, &mut scaled),
        None if is_fine => without_mode(heard, &FINE_ZETAS, &FINE_EXCESSES, &mut scaled),
        None => without_mode(heard, &ZETAS, &EXCESSES, &mut scaled),
    }
}

/// Cases of a mode that is told: off in the waves, in the mode, in the load.
fn with_mode<T: Real>(
    heard: &HeardChatter<T>,
    told: &Dominant<T>,
    case: &mut impl FnMut(Hypothesis<T>),
) {
    let (mode, zeta) = (told.mode, damping(&told.mode));
    let side = phase_of(heard.waves()).side;
    let (form, own) = (T::from_f64(DOUBT) * zeta, doubt(mode.f_sd, mode.f_hz));
    let mode_sd = (form * form + own * own).sqrt();
    let (sd, f_sd) = (waves_sd(heard), doubt(heard.f_sd_hz, heard.f_hz));
    for off in OFFS.map(T::from_f64) {
        let phase = phase_of(heard.waves() * (T::ONE + off * sd));
        let ratio = heard.f_hz * (T::ONE + off * f_sd) / mode.f_hz;
        let load = match load_of(&phase, ratio, zeta) {
            Some(load) if phase.side == side => load.min(T::from_f64(MOST_LOAD)),
            _ => told.load,
        };
        for times in LOADS.map(T::from_f64) {
            for shift in OFFS.map(T::from_f64) {
                case(Hypothesis {
                    natural_hz: mode.f_hz * (T::ONE + shift * mode_sd),
                    zeta,
                    told_load: load,
                    load: load * times,
                    side,
                    teeth: heard.teeth,
                });
            }
        }
    }
}

/// Cases of a mode that nobody has told: its damping and the depth besides.
fn without_mode<T: Real>(
    heard: &HeardChatter<T>,
    zetas: &[f64],
    excesses: &[f64],
    case: &mut impl FnMut(Hypothesis<T>),
) {
    let sd = waves_sd(heard);
    for off in OFFS.map(T::from_f64) {
        let phase = phase_of(heard.waves() * (T::ONE + off * sd));
        for zeta in zetas.iter().map(|z| T::from_f64(*z)) {
            for excess in excesses.iter().map(|e| T::from_f64(*e)) {
                let one = unknown(heard, &phase, zeta, excess);
                for times in LOADS.map(T::from_f64) {
                    for shift in OFFS.map(T::from_f64) {
                        let off = T::ONE + shift * T::from_f64(DOUBT) * zeta;
                        case(Hypothesis {
                            natural_hz: one.natural_hz * off,
                            zeta,
                            told_load: one.load,
                            load: one.load * times,
                            side: phase.side,
                            teeth: heard.teeth,
                        });
                    }
                }
            }
        }
    }
}
