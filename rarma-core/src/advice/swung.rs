//! A few cases of what chatters, for one who plays it: see [`vary`](super::vary).

use super::heard::HeardChatter;
use super::lobes::Side;
use super::mode::{EXCESSES, MOST_LOAD, ZETAS, damping, dominant, unknown};
use super::phase::{growth_of, phase_of};
use crate::decide::Structure;
use crate::real::Real;

// The two below were set on 33 cuts of seeds 1..140 and 400..700 of the population that no speed of 41 or 201 within reach
// makes stable, each with eight swings or more. A play of the load that was worked out has it stable
// with a swing: of 88 turned ones 91 % are so, of 59 milled ones 22 %; at 1.4 times that load 97
// and 42 %, at twice 100 and 53 %.

/// Loads over the one that was worked out, of the cases of a swinging speed.
const SWUNG_LOADS: [f64; 3] = [0.7, 1.0, 1.4];
/// The load of an interrupted cut over that which the frequency of its chatter tells, where
/// the speed swings: over a swing the teeth meet every phase, and other modes theirs.
const INTERRUPTED: f64 = 2.0;
/// Cases of a swinging speed at most.
pub(super) const MOST_CASES: usize = ZETAS.len() * EXCESSES.len();

/// What chatters, for one who plays it.
#[derive(Clone, Copy)]
pub(super) struct Case<T> {
    pub natural_hz: T,
    pub zeta: T,
    pub load: T,
    pub side: Side,
    /// Growth at the present speed, σ/ω_m.
    pub growth: T,
}

/// A few cases, each as likely, of what was heard, and whether a mode of the structure was
/// taken: the present speed is where the phase is known, so that small doubts matter little.
pub(super) fn cases<T: Real>(
    heard: &HeardChatter<T>,
    structure: Option<&Structure<T>>,
) -> ([Option<Case<T>>; MOST_CASES], bool) {
    let phase = phase_of(heard.waves());
    let harder = if heard.teeth > 1 { INTERRUPTED } else { 1.0 };
    let of = |natural_hz: T, zeta: T, load: T| {
        let load = (load * T::from_f64(harder)).min(T::from_f64(MOST_LOAD));
        Case {
            natural_hz,
            zeta,
            load,
            side: phase.side,
            growth: growth_of(&phase, load, zeta),
        }
    };
    let mut out = [None; MOST_CASES];
    if let Some(d) = structure.and_then(|s| dominant(heard, s)) {
        for (slot, times) in out.iter_mut().zip(SWUNG_LOADS.map(T::from_f64)) {
            *slot = Some(of(d.mode.f_hz, damping(&d.mode), d.load * times));
        }
        return (out, true);
    }
    let pairs = ZETAS
        .iter()
        .flat_map(|z| EXCESSES.iter().map(move |e| (*z, *e)));
    for (slot, (zeta, excess)) in out.iter_mut().zip(pairs) {
        let one = unknown(heard, &phase, T::from_f64(zeta), T::from_f64(excess));
        *slot = Some(of(one.natural_hz, one.zeta, one.load));
    }
    (out, false)
}
