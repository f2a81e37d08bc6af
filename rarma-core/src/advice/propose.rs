//! From a belief to a list of speeds, or to "none", and what helps then.

use super::belief::{Belief, SPEEDS};
use super::config::{AdviceConfig, AdviceError};
use super::heard::{HeardChatter, KnownCut};
use super::lobes::{Lobes, floor};
use crate::decide::Structure;
use crate::real::Real;

/// Speeds that are proposed at most.
const MOST_PROPOSALS: usize = 4;
/// Of two speeds alike the nearer goes first: e times further off weighs as a ninth less.
const NEAR: f64 = 9.0;
/// Of two speeds alike the quieter goes first: e times the vibration weighs as a twelfth less. Of 32 cuts with a
/// pocket (seeds 1 to 299 of the population, machine told) 14 vibrate 15 dB less at the first speed and 29 are stable
/// there, with 6 and 18 likewise, with 4 15 and 29; where vibration does not count 12 and 29. 17 have such a speed at all. With 4
/// fewer of the 58 that are told by the alarm's frequency are stable (seeds from 120000 on): 48 for 51.
const QUIET: f64 = 12.0;
/// A pocket reaches as far as its chance is this part of that of its best speed.
const RIM: f64 = 0.5;
/// Scores this near to the best are a plateau: its middle is proposed.
const PLATEAU: f64 = 0.98;

/// A speed to turn instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal<T> {
    /// The speed, turns a second.
    pub spindle_hz: T,
    /// Standard deviation of the middle of its pocket, turns a second: of the mode's frequency.
    pub spindle_sd_hz: T,
    /// The pocket: so many waves between two teeth, about; 0 is above all lobes.
    pub pocket: u32,
    /// From where to where the pocket goes within reach, turns a second: where the chance is at
    /// least half of that of its best speed.
    pub from_hz: T,
    /// See `from_hz`.
    pub to_hz: T,
    /// Chance that the cut is stable there, 0 to 1, before it is tried.
    pub chance: T,
    /// How many times deeper the cut may be there by the likeliest lobes, 1 to 8; 1 where they
    /// do not have it stable.
    pub margin: T,
    /// The speed over the present one.
    pub ratio: T,
    /// The feed (not that of a tooth) over the present one.
    pub feed_ratio: T,
}

/// What helps where no speed does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Help {
    /// A smaller depth of cut.
    LessDepth,
    /// A speed that swings all the time: of use at many waves, where lobes lie close.
    SpeedVariation,
    /// A cutter with fewer teeth, or with unequal ones.
    OtherTeeth,
}

/// What to turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice<T> {
    /// Waves between two teeth now.
    pub waves: T,
    /// From so many waves on pockets have merged, by the likeliest lobes.
    pub most_waves: T,
    /// Frequency of the mode that chatters, Hz, told or worked out.
    pub natural_hz: T,
    /// Its likeliest lobes, at the depth of this cut.
    pub lobes: Lobes<T>,
    /// The structure's mode was told.
    pub of_structure: bool,
    /// Speeds, the best first; none where no speed within reach is likely enough.
    pub proposals: [Option<Proposal<T>>; MOST_PROPOSALS],
    /// The largest chance within reach.
    pub best_chance: T,
    /// The next pocket above the reach, turns a second, where one is left there.
    pub beyond_hz: Option<T>,
    /// What helps, the likeliest first, where no speed is proposed.
    pub helps: [Help; 3],
}

impl<T: Real> Advice<T> {
    /// The speed to try first.
    pub fn first(&self) -> Option<&Proposal<T>> {
        self.proposals.iter().flatten().next()
    }
}

/// Which speeds to turn instead of the one at which this chatter was heard.
///
/// With a `structure` (modes at rest: frequency and damping) the depth is worked out from how
/// far the chatter lies off its mode, and pockets are kept clear of the other modes; without
/// one damping and depth are a belief. `known` are other cuts with the same tool, stable or not, also at
/// other depths: each of the last [`MOST_KNOWN`](super::MOST_KNOWN) is evidence. From the
/// frequencies of several chatters follow mode, damping and depth; one that is of another mode is
/// told apart, and its lobes count, too.
///
/// A proposal's chance is the part of the belief in which a speed, and what lies within
/// `config.hold` of it, is stable. Proposals are ranked by it: a pocket that is wide and of few
/// waves has more of it; of two alike the nearer goes first.
///
/// Limits: one mode chatters, in one direction; teeth equally spaced; the period doubling of
/// cuts with short arcs is taken for a phase of ½. How often it is right is in docs/advice.md.
///
/// # Errors
/// What is out of range in `config` or `heard`; [`AdviceError::Reach`] where the power leaves
/// nothing of the reach.
///
/// ```
/// use rarma_core::advice::{AdviceConfig, HeardChatter, advise};
/// // Two teeth at 9000 1/min chatter at 1128 Hz: 3.76 waves between two teeth.
/// let heard = HeardChatter { f_hz: 1128.0, f_sd_hz: 1.0, spindle_hz: 150.0, spindle_sd_hz: 0.1, teeth: 2 };
/// let advice = advise(&AdviceConfig::reach(75.0, 225.0), &heard, None, &[]).unwrap();
/// // The mode lies below the chatter, and the pocket below f/(3·2) = 11 280 1/min.
/// let best = advice.first().unwrap();
/// assert!(advice.natural_hz < 1110.0 && best.pocket == 3);
/// assert!((60.0 * best.spindle_hz - 10_700.0f64).abs() < 100.0 && best.chance > 0.5);
/// ```
pub fn advise<T: Real>(
    config: &AdviceConfig<T>,
    heard: &HeardChatter<T>,
    structure: Option<&Structure<T>>,
    known: &[KnownCut<T>],
) -> Result<Advice<T>, AdviceError> {
    checked(config, heard, known)?;
    let belief = Belief::new(config, heard, structure, known);
    Ok(proposed(config, heard, &belief, |_| T::ONE))
}

/// [`advise`], where more is known than one mode tells: `chance` is the chance that the cut is stable at
/// a speed, turns a second, and `vibration` what it vibrates there if it is, above 0 and in any unit: of speeds
/// alike the quieter goes first. Mode, waves and margins are those of the one mode; a speed that was tried
/// counts beside the chances.
///
/// # Errors
/// As [`advise`].
pub fn advise_by<T: Real>(
    config: &AdviceConfig<T>,
    heard: &HeardChatter<T>,
    structure: Option<&Structure<T>>,
    known: &[KnownCut<T>],
    chance: impl Fn(T) -> T,
    vibration: impl Fn(T) -> T,
) -> Result<Advice<T>, AdviceError> {
    checked(config, heard, known)?;
    let belief = Belief::new(config, heard, structure, &[]).by(chance, known);
    Ok(proposed(config, heard, &belief, vibration))
}

fn checked<T: Real>(
    config: &AdviceConfig<T>,
    heard: &HeardChatter<T>,
    known: &[KnownCut<T>],
) -> Result<(), AdviceError> {
    config.validate()?;
    heard.validate()?;
    known.iter().try_for_each(KnownCut::validate)?;
    if config.top_hz(heard.spindle_hz) > config.least_hz {
        Ok(())
    } else {
        Err(AdviceError::Reach)
    }
}

fn proposed<T: Real>(
    config: &AdviceConfig<T>,
    heard: &HeardChatter<T>,
    belief: &Belief<T>,
    vibration: impl Fn(T) -> T,
) -> Advice<T> {
    let held = held(belief, config.hold);
    let best_chance = held.iter().fold(T::ZERO, |best, x| best.max(*x));
    let most_waves = belief.usual.most_waves().unwrap_or(T::ZERO);
    let waves = heard.waves();
    let top_hz = config.top_hz(heard.spindle_hz);
    Advice {
        waves,
        most_waves,
        natural_hz: belief.usual.natural_hz(),
        lobes: belief.usual,
        of_structure: belief.of_structure,
        proposals: proposals(config, heard, belief, held, vibration),
        best_chance,
        beyond_hz: beyond(&belief.usual, top_hz, heard, most_waves),
        helps: if waves > most_waves {
            [Help::LessDepth, Help::SpeedVariation, Help::OtherTeeth]
        } else {
            [Help::LessDepth, Help::OtherTeeth, Help::SpeedVariation]
        },
    }
}

/// Mean chance within the hold around each speed; beyond the ends it is that of the end.
fn held<T: Real>(belief: &Belief<T>, hold: T) -> [T; SPEEDS] {
    let ends = (belief.speeds.first(), belief.speeds.last());
    let step = match ends {
        (Some(a), Some(b)) => (*b / *a).ln() / T::from_u32(SPEEDS as u32 - 1),
        _ => T::ONE,
    };
    let wanted = (hold / step).round().to_f64();
    let reach = if wanted >= 1.0 { wanted as usize } else { 0 }.min(SPEEDS);
    let count = T::from_u32(2 * reach as u32 + 1);
    core::array::from_fn(|i| {
        let around = (0..=2 * reach).map(|k| (i + k).saturating_sub(reach).min(SPEEDS - 1));
        let sum: T = around.filter_map(|k| belief.chances.get(k).copied()).sum();
        sum / count
    })
}

fn proposals<T: Real>(
    config: &AdviceConfig<T>,
    heard: &HeardChatter<T>,
    belief: &Belief<T>,
    mut held: [T; SPEEDS],
    vibration: impl Fn(T) -> T,
) -> [Option<Proposal<T>>; MOST_PROPOSALS] {
    let mut scores = held;
    for (score, speed) in scores.iter_mut().zip(&belief.speeds) {
        if *score < config.least_chance {
            *score = T::ZERO;
            continue;
        }
        let far = (*speed / heard.spindle_hz).ln().abs();
        let loud = vibration(*speed).ln();
        *score *= (-(far / T::from_f64(NEAR)) - loud / T::from_f64(QUIET)).exp();
    }
    let mut out = [None; MOST_PROPOSALS];
    for slot in &mut out {
        let Some((top, best)) = largest(&scores) else {
            break;
        };
        let chance = held.get(top).copied().unwrap_or(T::ZERO);
        let (first, last) = around(&scores, top, best * T::from_f64(PLATEAU));
        let middle = usize::midpoint(first, last);
        let (from, to) = around(&held, top, chance * T::from_f64(RIM));
        let at = |i: usize| belief.speeds.get(i).copied().unwrap_or(heard.spindle_hz);
        let spindle_hz = at(middle);
        let ratio = spindle_hz / heard.spindle_hz;
        let waves = belief.usual.waves_at(spindle_hz).round().to_f64();
        *slot = Some(Proposal {
            spindle_hz,
            spindle_sd_hz: spindle_hz * belief.natural_sd,
            pocket: waves as u32,
            from_hz: at(from),
            to_hz: at(to),
            chance: held.get(middle).copied().unwrap_or(T::ZERO),
            margin: belief.usual.margin(spindle_hz),
            ratio,
            feed_ratio: if config.keeps_feed { ratio } else { T::ONE },
        });
        for of in [&mut scores, &mut held] {
            of.iter_mut()
                .take(to + 1)
                .skip(from)
                .for_each(|x| *x = T::ZERO);
        }
    }
    out
}

/// The largest score above 0 and its place, the first of equals.
fn largest<T: Real>(scores: &[T; SPEEDS]) -> Option<(usize, T)> {
    let mut best = None;
    for (i, score) in scores.iter().enumerate() {
        if *score > best.map_or(T::ZERO, |(_, most)| most) {
            best = Some((i, *score));
        }
    }
    best
}

/// The stretch around a place in which scores are at least `rim`.
fn around<T: Real>(scores: &[T; SPEEDS], top: usize, rim: T) -> (usize, usize) {
    let holds = |score: &&T| **score >= rim;
    let below = scores.iter().take(top).rev().take_while(holds).count();
    let above = scores.iter().skip(top + 1).take_while(holds).count();
    (top - below, top + above)
}

/// The next pocket above the reach by the likeliest lobes.
fn beyond<T: Real>(
    usual: &Lobes<T>,
    top_hz: T,
    heard: &HeardChatter<T>,
    most_waves: T,
) -> Option<T> {
    let pocket = floor(usual.waves_at(top_hz));
    (pocket >= T::ONE && pocket < most_waves)
        .then(|| usual.natural_hz() / (pocket * T::from_u32(heard.teeth)))
}
