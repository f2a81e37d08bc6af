//! Machines like the one that is told, what was heard as evidence of which it is, and the speeds at which
//! they are stable.

use super::curve::{Curve, Point, Span};
use super::likelihood::{Conditions, Likelihood, of_known};
use super::vibration::Vibration;
use super::{Machine, Spread};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rarma_core::advice::{
    Advice, AdviceConfig, AdviceError, HeardChatter, KnownCut, MOST_KNOWN, Outcome, advise_by,
};
use rarma_core::decide::Structure;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Machines that are drawn.
const DRAWN: usize = 128;
/// Those of them that are looked at speed by speed. With 24 chances are known to a tenth, and of the speeds that hang on the
/// least chance some are proposed or not by luck: of 89 alarms of seeds 120000 to 120399 one to three more are
/// answered rightly with 48, of 181 true frequencies one at most.
const CHARTED: usize = 48;
/// So many of these are looked at first: where all of them chatter the others are not looked at.
const SCOUTS: usize = 8;
/// Roots that may be heard at one speed.
const HEARD_ROOTS: usize = 3;
/// Chance of being stable from which on a speed is proposed. On the 75 cuts with a pocket of seeds 1 to 300 of
/// the population and the 44 without, told as wrong as usual: 0.95 of the first speeds stable and 0.93 of the
/// "none" said; from 0.2 on 0.95 and 0.77, from 0.6 on 0.85 and 0.95.
const LEAST_CHANCE: f64 = 0.4;
/// The frequency is one of theirs where so much of the weight comes of frequencies that the machines have.
const EXPLAINED: f64 = 0.5;
/// Where it is none of theirs, so many of them must chatter at the speed: more than do not.
const CHATTERING: f64 = 0.5;

/// What machines like the one that is told say.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Which speeds to turn.
    pub advice: Advice<f64>,
    /// They chatter at the frequency that was heard, at this speed or at another of the cut's; otherwise
    /// most of them chatter there, but at others.
    pub explains: bool,
    /// Part of such machines that chatter at this speed, before anything was heard.
    pub expected: f64,
}

/// Roots of every drawn machine at one speed and depth.
type Looks = Arc<Vec<Vec<Point>>>;

/// What is believed of a machine that is told.
#[derive(Debug)]
pub struct Belief {
    told: Machine,
    spread: Spread,
    drawn: Vec<Machine>,
    curves: Vec<Mutex<Curve>>,
    looks: Mutex<BTreeMap<(u64, u64), Looks>>,
}

impl Belief {
    /// So many times `done` of [`advise`](Self::advise) and [`chart`](Self::chart) is called at most.
    pub const CHARTED: usize = CHARTED;

    /// Of a machine that is known as well as this.
    #[must_use]
    pub fn new(told: Machine, spread: Spread, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Self {
            curves: (0..DRAWN)
                .map(|_| Mutex::new(Curve::new(Span::new(1.0, 2.0))))
                .collect(),
            drawn: (0..DRAWN).map(|_| told.like(&spread, &mut rng)).collect(),
            told,
            spread,
            looks: Mutex::default(),
        }
    }

    /// Its modes.
    #[must_use]
    pub fn structure(&self) -> Option<Structure<f64>> {
        self.told.structure(&self.spread)
    }

    /// Part of the machines like it that chatter at a speed, turns a second, at full depth.
    #[must_use]
    pub fn expected(&self, spindle_hz: f64) -> f64 {
        chattering(&self.looks(spindle_hz, 1.0))
    }

    /// What every drawn machine does at a speed, turns a second, and so many times the depth.
    fn looks(&self, spindle_hz: f64, depth: f64) -> Looks {
        let key = (spindle_hz.to_bits(), depth.to_bits());
        let known = || self.looks.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&key) {
            return Arc::clone(found);
        }
        let look = |machine: &Machine| -> Vec<Point> {
            let roots = machine.roots(spindle_hz, depth, HEARD_ROOTS);
            let roots = roots.unwrap_or_default();
            roots.iter().map(|r| Point::of(Some(r))).collect()
        };
        let found: Looks = Arc::new(self.drawn.par_iter().map(look).collect());
        known().insert(key, Arc::clone(&found));
        found
    }

    /// Which speeds to turn, as [`advise_by`] ranks them; none where machines like it chatter neither at this
    /// speed nor where the cut is known to have chattered. `done` is called after each machine that is looked at.
    ///
    /// # Errors
    /// As [`advise_by`].
    pub fn advise(
        &self,
        config: &AdviceConfig<f64>,
        heard: &HeardChatter<f64>,
        known: &[KnownCut<f64>],
        done: impl Fn() + Sync,
    ) -> Result<Option<Answer>, AdviceError> {
        heard.validate()?;
        known.iter().try_for_each(KnownCut::validate)?;
        config.validate()?;
        let here = self.looks(heard.spindle_hz, 1.0);
        let known = last(known);
        let there: Vec<Looks> = known
            .iter()
            .map(|cut| self.looks(cut.spindle_hz, cut.depth))
            .collect();
        let structure = self.structure();
        let structure = structure.as_ref();
        let Some(weighed) = weighed(heard, structure, known, &here, &there) else {
            return Ok(None);
        };
        let times = resampled(&weighed.weights, CHARTED);
        let mut chosen: Vec<usize> = (0..times.len()).filter(|k| times[*k] > 0).collect();
        chosen.sort_by_key(|k| core::cmp::Reverse(times[*k]));
        let span = Span::new(config.least_hz, config.most_hz);
        let charted = self.charted(&chosen, span, None, &done);
        let weighed = Weighed {
            weights: chosen.iter().map(|k| times[*k] as f64).collect(),
            ..weighed
        };
        answer(config, heard, structure, known, &charted, &weighed).map(Some)
    }

    fn charted(
        &self,
        which: &[usize],
        span: Span,
        also_hz: Option<f64>,
        done: &(impl Fn() + Sync),
    ) -> Charted {
        let curves = self.looked_at(which, span, also_hz, done);
        let is_asked = |cell| curves.iter().any(|c| c.is_stable_within(cell, cell));
        Charted {
            vibration: Vibration::new(&self.told, span, is_asked),
            curves,
        }
    }

    /// Curves of these machines: of the first of them everywhere, of the others where one of those is
    /// stable, and at one more speed.
    fn looked_at(
        &self,
        which: &[usize],
        span: Span,
        also_hz: Option<f64>,
        done: &(impl Fn() + Sync),
    ) -> Vec<Curve> {
        let teeth = self.told.process.teeth() as f64;
        let look = |k: &usize, scouts: &[Curve]| {
            let mut curve = self.curves[*k]
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            if curve.span != span {
                *curve = Curve::new(span);
            }
            curve.look_at(&self.drawn[*k], teeth, |from, to| {
                scouts.is_empty()
                    || scouts.iter().any(|s| s.is_stable_within(from, to))
                    || also_hz.is_some_and(|hz| span.holds(hz, from, to))
            });
            done();
            curve.clone()
        };
        let (first, others) = which.split_at(SCOUTS.min(which.len()));
        let mut curves: Vec<Curve> = first.par_iter().map(|k| look(k, &[])).collect();
        let others: Vec<Curve> = others.par_iter().map(|k| look(k, &curves)).collect();
        curves.extend(others);
        curves
    }

    /// The chart of a programmed speed and what may be turned, turns a second, made before anything is heard.
    pub fn chart(
        &self,
        program_hz: f64,
        (least_hz, most_hz): (f64, f64),
        done: impl Fn() + Sync,
    ) -> Chart {
        let which: Vec<usize> = (0..CHARTED).collect();
        Chart {
            structure: self.structure(),
            charted: self.charted(
                &which,
                Span::new(least_hz, most_hz),
                Some(program_hz),
                &done,
            ),
        }
    }
}

/// Machines like one that is told, looked at speed by speed before anything is heard.
#[derive(Debug)]
pub struct Chart {
    structure: Option<Structure<f64>>,
    charted: Charted,
}

/// Curves of machines, and what the one that is told vibrates where any of them is stable.
#[derive(Debug)]
struct Charted {
    curves: Vec<Curve>,
    vibration: Vibration,
}

impl Chart {
    /// As [`Belief::advise`], at once.
    ///
    /// # Errors
    /// As there.
    pub fn advise(
        &self,
        config: &AdviceConfig<f64>,
        heard: &HeardChatter<f64>,
        known: &[KnownCut<f64>],
    ) -> Result<Option<Answer>, AdviceError> {
        heard.validate()?;
        let known = last(known);
        let at = |hz: f64| -> Looks {
            let roots = self.charted.curves.iter().map(|curve| vec![curve.at(hz)]);
            Arc::new(roots.collect())
        };
        let there: Vec<Looks> = known.iter().map(|cut| at(cut.spindle_hz)).collect();
        let (structure, here) = (self.structure.as_ref(), at(heard.spindle_hz));
        let Some(weighed) = weighed(heard, structure, known, &here, &there) else {
            return Ok(None);
        };
        answer(config, heard, structure, known, &self.charted, &weighed).map(Some)
    }
}

/// Of a list so many count, the last.
fn last(known: &[KnownCut<f64>]) -> &[KnownCut<f64>] {
    &known[known.len().saturating_sub(MOST_KNOWN)..]
}

/// How much each machine counts.
struct Weighed {
    weights: Vec<f64>,
    explains: bool,
    /// Part of them that chatter at this speed, each counted alike.
    expected: f64,
}

/// Weights of the machines; none where they have chattered neither here nor at a speed that is known.
///
/// One speed at which they agree with what was heard is enough: a speed that they propose with a chance of one half
/// chatters as often as not, and that is no word against them.
fn weighed(
    heard: &HeardChatter<f64>,
    structure: Option<&Structure<f64>>,
    known: &[KnownCut<f64>],
    here: &Looks,
    there: &[Looks],
) -> Option<Weighed> {
    let sd = heard
        .f_sd_hz
        .hypot(heard.f_hz * heard.spindle_sd_hz / heard.spindle_hz);
    let modes = structure.map(Structure::modes).unwrap_or_default();
    let modes_hz: Vec<f64> = modes.iter().map(|mode| mode.f_hz).collect();
    let cut = Conditions {
        spindle_hz: heard.spindle_hz,
        teeth: heard.teeth,
        modes_hz: &modes_hz,
    };
    let now = KnownCut::chattered(heard.spindle_hz, Some((heard.f_hz, sd)));
    let cuts = known.iter().chain([&now]).zip(there.iter().chain([here]));
    let mut weights = vec![1.0; here.len()];
    let (mut explains, mut expects) = (false, false);
    for (known, looks) in cuts {
        let each: Vec<Likelihood> = looks
            .iter()
            .map(|roots| of_known(roots, known, &cut))
            .collect();
        for (weight, one) in weights.iter_mut().zip(&each) {
            *weight *= one.weight;
        }
        let all: f64 = each.iter().map(|one| one.weight).sum();
        let explained: f64 = each.iter().map(|one| one.explained).sum();
        explains |= explained > EXPLAINED * all;
        expects |= known.outcome != Outcome::Stable && chattering(looks) > CHATTERING;
    }
    (explains || expects).then(|| Weighed {
        weights,
        explains,
        expected: chattering(here),
    })
}

/// Part of the machines that chatter.
fn chattering(looks: &Looks) -> f64 {
    let grows = |roots: &&Vec<Point>| roots.iter().any(|p| p.growth_per_s >= 0.0);
    looks.iter().filter(grows).count() as f64 / looks.len() as f64
}

/// How often each is among so many, by its weight: systematic resampling.
fn resampled(weights: &[f64], count: usize) -> Vec<usize> {
    let sum: f64 = weights.iter().sum();
    let mut passed = 0.0;
    let mut taken = 0;
    let times = weights.iter().map(|weight| {
        passed += weight / sum * count as f64;
        let before = taken;
        while taken < count && (taken as f64 + 0.5) < passed {
            taken += 1;
        }
        taken - before
    });
    times.collect()
}

fn answer(
    config: &AdviceConfig<f64>,
    heard: &HeardChatter<f64>,
    structure: Option<&Structure<f64>>,
    known: &[KnownCut<f64>],
    charted: &Charted,
    weighed: &Weighed,
) -> Result<Answer, AdviceError> {
    let Charted { curves, vibration } = charted;
    let weights = &weighed.weights;
    let stable = |curves: &[Curve], hz: f64| {
        let all: f64 = weights[..curves.len()].iter().sum();
        let stable = curves.iter().zip(weights);
        let stable = stable.filter(|(curve, _)| curve.at(hz).growth_per_s < 0.0);
        stable.map(|(_, weight)| weight).sum::<f64>() / all
    };
    let chance = |hz: f64| {
        let scouts = stable(&curves[..SCOUTS.min(curves.len())], hz);
        // Where none of the scouts is stable, nor beside, the others were not looked at.
        if scouts > 0.0 {
            stable(curves, hz)
        } else {
            0.0
        }
    };
    let config = AdviceConfig {
        least_chance: LEAST_CHANCE,
        ..*config
    };
    // What is wrong of a speed is so of those around it.
    let now = KnownCut::chattered(heard.spindle_hz, None);
    let tried: Vec<KnownCut<f64>> = known
        .iter()
        .copied()
        .chain((weighed.expected <= CHATTERING).then_some(now))
        .collect();
    Ok(Answer {
        advice: advise_by(&config, heard, structure, &tried, chance, |hz| {
            vibration.at(hz)
        })?,
        explains: weighed.explains,
        expected: weighed.expected,
    })
}
