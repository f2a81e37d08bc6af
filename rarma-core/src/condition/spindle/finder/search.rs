//! Which spacings are tried, one a call, and which of them is believed.
//!
//! Words: *candidate*, a spacing that puts a peak on a multiple; *blind*, without a
//! told speed or after its neighbourhood has shown nothing.

use super::comb::{COMB_HITS, Multiples, Score, TOLD_HITS};
use super::peaks::Peaks;
use super::{CHANCE_BLIND, CHANCE_TOLD, Comb, Finding, Phase, SpeedFinder, TOLD_RANGE};
use crate::real::Real;

/// Two answers in a row that nobody told agree within this fraction, or there is none.
const AGREE: f64 = 0.015;
/// Most candidates that are counted, ln.
const LN_MANY: f64 = 16.0;

impl<T: Real> SpeedFinder<T> {
    /// Next multiple of the present generator, or the first of the next one, with the
    /// spacing inside `lo..=hi`; none when all have been tried.
    fn next_candidate(&mut self, lo: T, hi: T) -> Option<(usize, T)> {
        loop {
            let peak = *self.peaks.as_slice().get(self.generator)?;
            if self.multiple == 0 {
                // Towards zero, then up: the least multiple that fits.
                self.multiple = ((peak.bin / hi).to_f32() as u32).max(1);
                if peak.bin > hi * T::from_u32(self.multiple) {
                    self.multiple += 1;
                }
            } else {
                self.multiple += 1;
            }
            let spacing = peak.bin / T::from_u32(self.multiple);
            if spacing >= lo {
                self.tried += 1;
                return Some((self.generator, spacing));
            }
            // At most once per peak and call: those without a multiple in the range
            // are passed over.
            self.generator += 1;
            self.multiple = 0;
        }
    }

    fn better(&self, score: &Score<T>) -> bool {
        self.best.is_none_or(|b| score.ln_chance < b.ln_chance)
    }

    /// Tries the spacings near the told one, one a call.
    pub(super) fn search_told(&mut self) -> Option<Finding<T>> {
        let told = self.told?;
        let range = T::from_f64(TOLD_RANGE);
        let (lo, hi) = (told * (T::ONE - range), told * (T::ONE + range));
        if let Some((from, spacing)) = self.next_candidate(lo, hi) {
            if self.peaks.hits(spacing) < TOLD_HITS {
                return None;
            }
            let mut score = self.peaks.score(spacing, Some(from), Multiples::All);
            if let Some(teeth) = self.teeth {
                let few = self.peaks.score(spacing, Some(from), Multiples::Of(teeth));
                score.ln_chance = score.ln_chance.min(few.ln_chance + T::from_f64(2.0).ln());
            }
            if self.better(&score) && self.peaks.through_origin(&score) {
                self.best = Some(score);
            }
            return None;
        }
        let tried = T::from_u32(self.tried.max(1)).ln();
        let least = T::from_f64(CHANCE_TOLD).ln();
        let teeth = self.teeth;
        let proven = |best: &Score<T>| {
            best.ln_chance + tried < least
                && !self.peaks.rests_on_overtones(best, teeth, least)
                && self.peaks.agrees_with_distances(best)
        };
        if let Some(best) = self.best.filter(proven) {
            let comb = self.comb(&best, tried);
            return Some(self.answer(Finding::Found(comb)));
        }
        self.generator = 0;
        self.multiple = 0;
        self.tried = 0;
        self.best = None;
        self.phase = Phase::Blind;
        None
    }

    /// Tries all spacings, one a call.
    pub(super) fn search_blind(&mut self) -> Option<Finding<T>> {
        let (lo, hi) = self.range;
        if let Some((from, spacing)) = self.next_candidate(lo, hi) {
            if self.peaks.hits(spacing) < COMB_HITS {
                return None;
            }
            let mut score = self.peaks.score(spacing, Some(from), Multiples::All);
            if Peaks::is_comb(&score) {
                // Spacings at least as wide that were or will be tried.
                score.ln_chance += self.wider(spacing);
                let whole =
                    self.peaks.through_origin(&score) && self.peaks.agrees_with_distances(&score);
                if self.better(&score) && whole {
                    self.best = Some(score);
                }
            }
            return None;
        }
        let least = T::from_f64(CHANCE_BLIND).ln();
        let Some(mut best) = self.best.filter(|b| b.ln_chance < least) else {
            self.previous = None;
            return Some(self.answer(Finding::NotEstimable));
        };
        best = self.peaks.refine(&best);
        best = self.peaks.split(&best, lo).unwrap_or(best);
        let agrees = self
            .previous
            .is_some_and(|before| (best.spacing - before).abs() <= before * T::from_f64(AGREE));
        self.previous = Some(best.spacing);
        if !agrees {
            return Some(self.answer(Finding::NotEstimable));
        }
        let comb = self.comb(&best, T::ZERO);
        let finding = match self.told {
            None => Finding::Found(comb),
            Some(told) => Finding::Contradiction {
                told_hz: told * self.bin_hz,
                found_hz: comb.spacing_hz,
            },
        };
        Some(self.answer(finding))
    }

    /// ln of the number of candidates with a spacing of at least `spacing`.
    fn wider(&self, spacing: T) -> T {
        let peaks = self.peaks.as_slice().iter();
        let sum: T = peaks.map(|p| p.bin / spacing).sum();
        sum.max(T::ONE).ln().min(T::from_f64(LN_MANY))
    }

    fn comb(&self, best: &Score<T>, tried: T) -> Comb<T> {
        let fine = self.peaks.refine(best);
        Comb {
            spacing_hz: fine.spacing * self.bin_hz,
            sd_hz: fine.sd * self.bin_hz,
            lines: fine.hits,
            chance: (best.ln_chance + tried).exp().min(T::ONE),
        }
    }
}
