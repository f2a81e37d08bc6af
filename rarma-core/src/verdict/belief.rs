//! The speed as a belief: how likely each speed near the told one is, by the lines that
//! are heard; and from it, how likely the rotation makes a line.
//!
//! Rate: per window, a line or some speeds a slice. Words: *comb*, the multiples of the
//! turn's frequency or of the teeth's.

mod desk;
mod turned;

pub(super) use desk::Desk;

use super::Listening;
use super::config::VerdictConfig;
use super::frame::HOP_S;
use crate::real::Real;
use crate::visit::state;
use desk::above_zero;

/// Speeds: the told one times e^u, u in steps over ±[`SPAN`].
const STEP: f64 = 0.001;
pub(super) const SPAN: f64 = 0.25;
pub(super) const SPEEDS: usize = 501;
/// A told speed is never less likely than this, natural logarithm: it may be quite wrong.
const LEAST_PRIOR: f64 = -30.0;
/// The same once the comb has left its place: the control has changed the speed.
const LEAST_MOVED: f64 = -3.0;
/// What the lines say is forgotten in this time, s.
const MEMORY_S: f64 = 0.5;
/// Windows that count as independent within that time.
const INDEPENDENT: f64 = 8.0;
/// Part of the lines of a cut that the rotation makes.
const FORCED: f64 = 0.8;
/// Prior chance that the rotation makes a line at a low multiple, and density of any other
/// line against it.
const PRIOR: f64 = 0.8;
const OTHERS: f64 = 0.002;
/// Deviation of a line's frequency, in units of the resolution.
pub(super) const LINE_SD: f64 = 0.15;
/// A speed so much less likely than the likeliest, natural logarithm, has no chance.
const IMPOSSIBLE: f64 = -25.0;
/// Teeth of a cutter of which nobody told how many it has.
const LIKELY_TEETH: u32 = 2;
/// A line of the comb is looked for so many deviations about.
const REACH: f64 = 3.5;
/// Deviations over the spacing from which on every frequency lies on the comb.
const SMEARED: f64 = 0.3;
/// How strong the other lines' word for a rotation is at half its weight, and the width of
/// the step.
const WORD: (f64, f64) = (0.0, 0.3);
/// Images of a sampler that folds.
const FOLDS: u32 = 4;
/// What a folded line may be: on teeth, on turns, folded of teeth, folded of turns.
const FOLDED: (f64, f64, f64, f64) = (0.5, 0.2, 0.2, 0.1);

/// The belief.
#[derive(Debug, Clone)]
pub(super) struct Belief<T> {
    /// Mean log-likelihood of each speed over that of one no line speaks for, which is
    /// `everywhere`.
    heard: [T; SPEEDS],
    everywhere: T,
    told_hz: T,
    teeth: T,
    folding_hz: Option<T>,
    sd_hz: T,
    prior_gain: T,
    /// Sum of the prior: of a told speed, of one that has moved; and that in use.
    prior_sums: (T, T),
    prior_sum: T,
    on_teeth: T,
    /// Multiple of the turn from which on forced lines become rare.
    rare_turns: T,
    alone: T,
    /// Least of the prior, natural logarithm.
    least: T,
    /// Logarithm of the largest probability, sum of all, mean and deviation of u.
    largest: T,
    sum: T,
    mean: T,
    sd: T,
    /// u of the speed to which the rotation may have been turned from the told one.
    turned: T,
}

state! { Belief<T> {
    heard, everywhere, told_hz, teeth, folding_hz, sd_hz, prior_gain,
    prior_sums, prior_sum, on_teeth, rare_turns, alone, least, largest, sum, mean, sd,
    turned
} }

impl<T: Real> Belief<T> {
    /// Zeros, until [`Self::restart`].
    pub(super) const BLANK: Self = Self {
        heard: [T::ZERO; SPEEDS],
        everywhere: T::ZERO,
        told_hz: T::ZERO,
        teeth: T::ZERO,
        folding_hz: None,
        sd_hz: T::ZERO,
        prior_gain: T::ZERO,
        prior_sums: (T::ZERO, T::ZERO),
        prior_sum: T::ZERO,
        on_teeth: T::ZERO,
        rare_turns: T::ZERO,
        alone: T::ZERO,
        least: T::ZERO,
        largest: T::ZERO,
        sum: T::ZERO,
        mean: T::ZERO,
        sd: T::ZERO,
        turned: T::ZERO,
    };

    /// Forgets everything and takes a told speed, in place: it is 2 KB.
    #[inline(never)]
    pub(super) fn restart(
        &mut self,
        config: &VerdictConfig,
        told_hz: f64,
        listening: &Listening,
        resolution_hz: T,
        desk: &mut Desk<'_, T>,
    ) {
        // The rest is set by the prior, and by what is heard.
        self.forget_all();
        self.turned = T::ZERO;
        self.told_hz = T::from_f64(told_hz);
        self.teeth = T::from_u32(listening.teeth.unwrap_or(1));
        self.folding_hz = listening.folding_hz.map(T::from_f64);
        self.sd_hz = resolution_hz * T::from_f64(LINE_SD);
        self.prior_gain = T::from_f64(-0.5 / (config.told_sd * config.told_sd));
        self.on_teeth = T::from_f64(config.on_teeth);
        let teeth = listening.teeth.unwrap_or(LIKELY_TEETH);
        self.rare_turns = T::from_f64(config.rare_multiple) * T::from_u32(teeth);
        self.alone = T::from_f64(config.alone);
        self.prior_sums.1 = self.weigh_prior(LEAST_MOVED);
        self.prior_sums.0 = self.weigh_prior(LEAST_PRIOR);
        self.prior_sum = self.prior_sums.0;
        self.settle(desk);
    }

    /// Takes a least prior; gives the sum of all.
    fn weigh_prior(&mut self, least: f64) -> T {
        self.least = T::from_f64(least);
        let mut sum = T::ZERO;
        for i in 0..SPEEDS {
            sum += self.prior(i).exp();
        }
        sum
    }

    /// Told anew: what was heard belongs to the new speed, for the rotation goes with it, unless it had gone before. Of a
    /// speed that was not believed in at all nothing was heard.
    pub(super) fn tell(&mut self, told_hz: T) {
        if !self.reaches(told_hz) {
            self.forget_all();
        }
        let steps = (told_hz / self.told_hz).ln() * T::from_f64(1.0 / STEP);
        self.shift(steps, T::max);
        self.told_hz = told_hz;
        self.turned = T::ZERO;
        self.least = T::from_f64(LEAST_PRIOR);
        self.prior_sum = self.prior_sums.0;
    }

    /// The speed, Hz, is among the speeds.
    pub(super) fn reaches(&self, spindle_hz: T) -> bool {
        (spindle_hz / self.told_hz).ln().abs() < T::from_f64(SPAN)
    }

    /// The comb has left its place: the told speed is that of before.
    pub(super) fn moved(&mut self) {
        self.turned = T::ZERO;
        self.forget_all();
        self.least = T::from_f64(LEAST_MOVED);
        self.prior_sum = self.prior_sums.1;
    }

    fn forget_all(&mut self) {
        self.heard.fill(T::ZERO);
        self.everywhere = T::ZERO;
    }

    fn u(i: usize) -> T {
        T::from_f64(STEP) * T::from_u32(i as u32) - T::from_f64(SPAN)
    }

    /// Of the told speed, or of the one to which it may have been turned. Both count in full: the sum of all is up to twice
    /// as large then, which is ln 2 / [`INDEPENDENT`] of a word and not counted.
    fn prior(&self, i: usize) -> T {
        let u = Self::u(i);
        let v = u - self.turned;
        (self.prior_gain * (u * u).min(v * v)).max(self.least)
    }

    /// The believed speed, Hz.
    pub(super) fn turn_hz(&self) -> T {
        self.told_hz * self.mean.exp()
    }

    /// Its standard deviation, a part of it.
    pub(super) fn sd(&self) -> T {
        self.sd
    }

    pub(super) fn teeth(&self) -> T {
        self.teeth
    }

    /// How much a line's word weighs: high multiples say less.
    pub(super) fn weight(&self, f_hz: T) -> T {
        T::ONE / (T::ONE + f_hz / (self.turn_hz() * T::from_f64(10.0)))
    }

    /// Lines of this weight together are about to be heard.
    pub(super) fn forget(&mut self, weights: T) {
        let keep = T::ONE - Self::gain() * weights.min(T::ONE);
        self.everywhere *= keep;
        for heard in &mut self.heard {
            *heard *= keep;
        }
    }

    fn gain() -> T {
        T::from_f64(HOP_S / MEMORY_S)
    }

    /// One line is heard; `weights`, of all lines of the window.
    pub(super) fn hear(&mut self, f_hz: T, weight: T, weights: T, desk: &mut Desk<'_, T>) {
        self.mix(f_hz, desk);
        let gain = Self::gain() * weights.min(T::ONE) * weight;
        let off = T::from_f64(1.0 - FORCED);
        let nowhere = gain * off.ln();
        self.everywhere += nowhere;
        let heard = &mut self.heard;
        above_zero(desk.both().0, |i, mixed| {
            if let Some(heard) = heard.get_mut(i) {
                *heard += gain * (off + T::from_f64(FORCED) * mixed).ln() - nowhere;
            }
        });
    }

    /// The probabilities, after all lines are heard.
    pub(super) fn settle(&mut self, desk: &mut Desk<'_, T>) {
        let n = T::from_f64(INDEPENDENT);
        self.largest = T::from_f64(-1e30);
        for (i, (chance, heard)) in desk.chance().zip(&self.heard).enumerate() {
            *chance = self.prior(i) + n * (self.everywhere + *heard);
            self.largest = self.largest.max(*chance);
        }
        let (mut sum, mut first, mut second) = (T::ZERO, T::ZERO, T::ZERO);
        for (i, chance) in desk.chance().enumerate() {
            let below = *chance - self.largest;
            if below < T::from_f64(IMPOSSIBLE) {
                *chance = T::ZERO;
                continue;
            }
            let p = below.exp();
            *chance = p;
            let u = Self::u(i);
            sum += p;
            first += p * u;
            second += p * u * u;
        }
        self.sum = sum;
        self.mean = first / sum;
        self.sd = (second / sum - self.mean * self.mean).max(T::ZERO).sqrt();
    }

    /// Log-odds that the rotation makes a line, by the word of the other lines: its own
    /// word, `weight` over `age_s`, is taken back first.
    pub(super) fn forced(&self, f_hz: T, weight: T, age_s: T, desk: &mut Desk<'_, T>) -> T {
        self.mix(f_hz, desk);
        let off = T::from_f64(1.0 - FORCED);
        let known = T::ONE - (-age_s / T::from_f64(MEMORY_S)).exp();
        let own = T::from_f64(INDEPENDENT) * weight * known;
        let nowhere = (-own * off.ln()).exp();
        let (mut sum, mut on) = (T::ZERO, T::ZERO);
        let has_spoken = weight > T::ZERO;
        let (mixed, chances) = desk.both();
        above_zero(chances, |i, chance| {
            let mixed = mixed.get(i).map_or(T::ZERO, |place| place.1);
            if mixed > T::ZERO {
                let back = if has_spoken {
                    chance * (-own * (off + T::from_f64(FORCED) * mixed).ln()).exp()
                } else {
                    chance
                };
                sum += back;
                on += back * mixed;
            } else {
                sum += chance * nowhere;
            }
        });
        let tiny = T::from_f64(1e-30);
        let word =
            (self.largest + (sum + tiny).ln() - self.prior_sum.ln()) / T::from_f64(INDEPENDENT);
        let others = sigmoid((word - T::from_f64(WORD.0)) / T::from_f64(WORD.1));
        let multiple = f_hz / (self.told_hz * self.rare_turns);
        let prior = T::from_f64(PRIOR) / (T::ONE + multiple * multiple)
            * (self.alone + (T::ONE - self.alone) * others);
        (prior * on / (sum + tiny) + T::from_f64(OTHERS)).ln() - (T::ONE - prior).ln()
    }

    /// Density of a line at each speed, over that of a line anywhere.
    fn mix(&self, f_hz: T, desk: &mut Desk<'_, T>) {
        desk.clear_mixed();
        let one = T::ONE;
        let teeth = self.teeth;
        let Some(rate) = self.folding_hz else {
            if teeth > one {
                self.comb(f_hz, teeth, self.on_teeth, desk);
                self.comb(f_hz, one, one - self.on_teeth, desk);
            } else {
                self.comb(f_hz, one, one, desk);
            }
            return;
        };
        let folds = T::from_u32(2 * FOLDS);
        let on_teeth = T::from_f64(FOLDED.2) / folds;
        let on_turns = T::from_f64(2.0 * FOLDED.3) / folds;
        self.comb(f_hz, teeth, T::from_f64(FOLDED.0), desk);
        self.comb(f_hz, one, T::from_f64(FOLDED.1), desk);
        for m in 1..=FOLDS {
            for image in [rate * T::from_u32(m) - f_hz, rate * T::from_u32(m) + f_hz] {
                self.comb(image, teeth, on_teeth, desk);
                if m <= FOLDS / 2 {
                    self.comb(image, one, on_turns, desk);
                }
            }
        }
    }

    /// Adds the multiples of `per_turn` times each speed, with a weight.
    fn comb(&self, f_hz: T, per_turn: T, weight: T, desk: &mut Desk<'_, T>) {
        let spacing = self.told_hz * per_turn;
        if !(spacing > T::ZERO && f_hz > T::ZERO) {
            return;
        }
        if self.sd_hz > spacing * T::from_f64(SMEARED) {
            desk.mixed().for_each(|mixed| *mixed += weight);
            return;
        }
        let span = T::from_f64(SPAN);
        let order = f_hz / spacing;
        let reach = T::from_f64(REACH) * self.sd_hz / f_hz;
        let last = order * (span + reach).exp();
        let mut k = (order * (-span - reach).exp() - T::from_f64(0.5))
            .round()
            .max(T::ONE);
        let high = weight * spacing / (self.sd_hz * T::from_f64(2.5066));
        let at = |u: T| (u + span) * T::from_f64(1.0 / STEP);
        let to_index = |u: T| at(u).clamp(T::ZERO, T::from_u32(SPEEDS as u32 - 1));
        let (half, dr) = (T::from_f64(-0.5), T::from_f64(STEP) * f_hz / self.sd_hz);
        let bend = (-dr * dr).exp();
        while k <= last {
            // Speeds whose k-th multiple lies near the line.
            let u = (order / k).ln();
            // Up to the next one, and down; a whole number stays.
            let from = (to_index(u - reach) + T::from_f64(0.999)).to_f32() as usize;
            let to = (to_index(u + reach) + T::from_f64(0.001)).to_f32() as usize;
            let near = desk.near(from, to);
            if near.len() > 0 {
                // e^(−r²/2) at equal steps of r, each from the one before. r = (f − kfₙ)/sd is as
                // good as straight within the reach.
                let first = T::from_f64(STEP) * (T::from_u32(from as u32) - at(u)) * f_hz;
                let r = first / self.sd_hz;
                let mut bell = high * (T::ONE + Self::u(from)) * (half * r * r).exp();
                let mut ratio = (half * dr * (r + r + dr)).exp();
                for mixed in near {
                    *mixed += bell;
                    bell *= ratio;
                    ratio *= bend;
                }
            }
            k += T::ONE;
        }
    }
}

/// 1/(1 + e^−x).
pub(super) fn sigmoid<T: Real>(x: T) -> T {
    T::ONE / (T::ONE + (-x).exp())
}
