//! Which spacing explains the lines of a spectrum, and how likely chance does.
//!
//! Words: *comb*, lines at multiples of one spacing; *hit*, a peak on a multiple.

use super::peaks::{MOST_PEAKS, Peak, Peaks};
use crate::real::Real;
use crate::visit::state;

/// A peak this near a multiple, bins, is on it. Twice this over the spacing is the
/// chance that a peak anywhere is.
pub(crate) const TOLERANCE_BINS: f64 = 0.4;
/// Least error of a peak's frequency that is believed, bins.
pub(super) const LEAST_ERROR_BINS: f64 = 0.005;
/// Numbers of strongest peaks that are tried; as many chances more.
const LOOKS: [u8; 7] = [3, 4, 6, 8, 12, 16, 24];
/// ln of the product of the numbers up to the index.
const LN_FACTORIAL: [f32; MOST_PEAKS + 1] = [
    0.0,
    0.0,
    core::f32::consts::LN_2,
    1.791_759,
    3.178_054,
    4.787_492,
    6.579_251,
    8.525_161,
    10.604_603,
    12.801_827,
    15.104_413,
    17.502_308,
    19.987_214,
    22.552_164,
    25.191_221,
    27.899_271,
    30.671_86,
    33.505_073,
    36.395_445,
    39.339_884,
    42.335_616,
    45.380_14,
    48.471_18,
    51.606_676,
    54.784_73,
];
/// Multiples of a spacing are split into this many parts at the most.
const MOST_PARTS: u32 = 8;
/// The lines between must be this unlikely to be there by chance for the spacing to
/// be split.
const LN_SPLIT: f64 = -9.2;
/// Least part of the multiples between the lowest and the highest hit of a spacing
/// nobody told that must be hits.
const LEAST_FILLED: f64 = 0.3;

/// Least lines of a spacing nobody told.
pub(super) const COMB_HITS: u32 = 3;
/// Least lines of a spacing near the told one.
pub(super) const TOLD_HITS: u32 = 2;

/// How well a spacing explains the peaks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Score<T> {
    /// Spacing, bins.
    pub spacing: T,
    /// Its standard deviation, bins.
    pub sd: T,
    /// Peaks on multiples.
    pub hits: u32,
    /// Part of the multiples between the lowest and the highest hit that are hits.
    pub filled: T,
    /// ln of an upper bound on the chance that so many peaks lie on multiples of one
    /// given spacing.
    pub ln_chance: T,
}

state! { Score<T> { spacing, sd, hits, filled, ln_chance } }

/// Which multiples of a spacing count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Multiples {
    /// All.
    All,
    /// Those of this number (of teeth).
    Of(u32),
    /// All but those of this number, among the peaks that those do not explain.
    NotOf(u32),
}

impl<T: Real> Peaks<T> {
    /// The multiple of `spacing` that a peak is on.
    pub(super) fn multiple(peak: &Peak<T>, spacing: T) -> Option<T> {
        let n = (peak.bin / spacing).round();
        let off = (peak.bin - n * spacing).abs();
        (n >= T::ONE && off <= T::from_f64(TOLERANCE_BINS)).then_some(n)
    }

    /// How many peaks are on a multiple of `spacing`: what most spacings are told from a comb by, at a fraction of
    /// [`Self::score`]. A quotient by 1/spacing names another multiple than [`Self::multiple`] only half way
    /// between two, where no hit is.
    pub fn hits(&self, spacing: T) -> u32 {
        let inverse = T::ONE / spacing;
        let near = |peak: &&Peak<T>| {
            let n = (peak.bin * inverse).round();
            let off = (peak.bin - n * spacing).abs();
            n >= T::ONE && off <= T::from_f64(TOLERANCE_BINS)
        };
        self.as_slice().iter().filter(near).count() as u32
    }

    /// Counts the hits on multiples of `spacing`, where it came from a peak on one
    /// (the one at `from` in the list), which then proves nothing.
    ///
    /// The chance that at least m of k peaks hit is at most C(k, m)·p^m with
    /// p = 2·[`TOLERANCE_BINS`]/spacing. k runs over the strongest 3, 4, 6 … 24, the
    /// best counts, and the chance is taken as often as there are looks.
    pub fn score(&self, spacing: T, from: Option<usize>, which: Multiples) -> Score<T> {
        let mut width = spacing;
        let mut part = T::ONE;
        match which {
            Multiples::All => {}
            Multiples::Of(z) => width = spacing * T::from_u32(z),
            Multiples::NotOf(q) => part = T::from_u32(q - 1) / T::from_u32(q),
        }
        let p = (T::from_f64(2.0 * TOLERANCE_BINS) * part / width).min(T::from_f64(0.9));
        let ln_p = p.ln();
        let mut best = T::ZERO;
        let (mut hits, mut looks, mut seen) = (0usize, 0usize, 0usize);
        let (mut lowest, mut highest) = (T::from_f64(1e9), T::ZERO);
        let mut look = LOOKS.iter();
        let mut until = look.next().map_or(usize::MAX, |k| usize::from(*k));
        for (i, peak) in self.as_slice().iter().enumerate() {
            let n = match which {
                Multiples::All => Self::multiple(peak, spacing),
                Multiples::Of(_) => Self::multiple(peak, width),
                Multiples::NotOf(q) => {
                    // What the multiples of q explain is no evidence for the others.
                    if Self::multiple(peak, spacing * T::from_u32(q)).is_some() {
                        continue;
                    }
                    Self::multiple(peak, spacing)
                }
            };
            seen += 1;
            if let Some(n) = n {
                hits += 1;
                lowest = lowest.min(n);
                highest = highest.max(n);
            }
            if seen == until || i + 1 == self.as_slice().len() {
                looks += 1;
                if seen >= until {
                    until = look.next().map_or(usize::MAX, |k| usize::from(*k));
                }
                let free = usize::from(from.is_some_and(|f| f <= i));
                let (k, m) = (seen - free, hits.saturating_sub(free));
                best = best.min(ln_choose::<T>(k, m) + T::from_u32(m as u32) * ln_p);
            }
        }
        let looks = T::from_u32(looks.max(1) as u32).ln();
        let multiples = (highest - lowest + T::ONE).max(T::ONE);
        Score {
            spacing,
            sd: T::ZERO,
            hits: hits as u32,
            filled: T::from_u32(hits as u32) / multiples,
            ln_chance: (best + looks).min(T::ZERO),
        }
    }

    /// Whether a score is that of a comb nobody told of: three lines, and not so few
    /// among so many multiples that a small spacing merely fits everything.
    pub fn is_comb(score: &Score<T>) -> bool {
        score.hits >= COMB_HITS && score.filled >= T::from_f64(LEAST_FILLED)
    }

    /// Least squares of a spacing through its hits, and the error of it: that of the
    /// frequencies about the fit, over √Σn².
    pub fn refine(&self, score: &Score<T>) -> Score<T> {
        let (mut nf, mut nn, mut count) = (T::ZERO, T::ZERO, 0u32);
        for peak in self.as_slice() {
            if let Some(n) = Self::multiple(peak, score.spacing) {
                nf += n * peak.bin;
                nn += n * n;
                count += 1;
            }
        }
        if count == 0 {
            return *score;
        }
        let spacing = nf / nn;
        let mut squares = T::ZERO;
        for peak in self.as_slice() {
            if let Some(n) = Self::multiple(peak, score.spacing) {
                let off = peak.bin - n * spacing;
                squares += off * off;
            }
        }
        // As if one line more were known to scatter so: few lines tell little of it.
        let prior = T::from_f64(0.014 * 0.014);
        let variance = (squares + prior) / T::from_u32(count);
        let least = T::from_f64(LEAST_ERROR_BINS);
        Score {
            spacing,
            sd: variance.sqrt().max(least) / nn.sqrt(),
            ..*score
        }
    }

    /// The largest part of `score`'s spacing whose multiples explain peaks that those
    /// of the spacing do not, against chance: tooth lines were found, and the
    /// spindle's own are there as well.
    pub fn split(&self, score: &Score<T>, least_spacing: T) -> Option<Score<T>> {
        let mut best: Option<(T, Score<T>)> = None;
        for q in 2..=MOST_PARTS {
            let spacing = score.spacing / T::from_u32(q);
            if spacing < least_spacing {
                break;
            }
            let between = self.score(spacing, None, Multiples::NotOf(q));
            let least = best.map_or(T::from_f64(LN_SPLIT), |(ln, _)| ln);
            if between.hits >= 2 && between.ln_chance < least {
                let all = self.score(spacing, None, Multiples::All);
                let all = Score {
                    ln_chance: all.ln_chance.min(score.ln_chance),
                    ..all
                };
                if Self::is_comb(&all) {
                    best = Some((between.ln_chance, all));
                }
            }
        }
        best.map(|(_, all)| all)
    }
}

/// ln of the number of ways to take `m` of `k`.
pub(super) fn ln_choose<T: Real>(k: usize, m: usize) -> T {
    let ln = |i: usize| LN_FACTORIAL.get(i).copied().unwrap_or(f32::MAX);
    T::from_f32(ln(k) - ln(m) - ln(k.saturating_sub(m)))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn peaks(bins: &[f64]) -> Peaks<f64> {
        let mut peaks = Peaks::BLANK;
        for (i, bin) in bins.iter().enumerate() {
            peaks.insert(Peak {
                bin: *bin,
                power: 100.0 - i as f64,
            });
        }
        peaks
    }

    #[test]
    fn the_bound_is_above_the_chance_and_not_far() {
        // Random peaks: how often do four of six hit, and what does the bound say?
        let mut seed = 5u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let (spacing, trials) = (10.0, 100_000);
        let (mut often, mut bound) = (0, 0.0);
        for _ in 0..trials {
            let bins: [f64; 6] = core::array::from_fn(|_| 100.0 + 800.0 * uniform());
            let score = peaks(&bins).score(spacing, None, Multiples::All);
            if score.hits >= 3 {
                often += 1;
            }
            if score.hits == 3 {
                bound = 20.0 * 0.08f64.powi(3) * 3.0;
            }
        }
        let chance = f64::from(often) / f64::from(trials);
        // Binomial: 0.0085; the bound without the looks: 0.0102.
        assert!((0.007..0.0102).contains(&chance), "{chance}");
        assert!(bound > chance && bound < 4.0 * chance);
    }

    #[test]
    fn a_part_of_the_spacing_that_explains_no_more_is_less_likely() {
        let true_lines = peaks(&[30.0, 60.05, 90.0, 120.0, 150.0, 201.3]);
        let at = |s| true_lines.score(s, None, Multiples::All).ln_chance;
        assert!(at(30.0) < at(15.0) - 2.0 && at(30.0) < at(10.0) - 2.0);
        assert!(at(30.0) < at(60.0));
        let found = true_lines.refine(&true_lines.score(30.01, None, Multiples::All));
        assert!((found.spacing - 30.002).abs() < 0.002 && found.sd > 1e-3 && found.sd < 1e-2);
        assert!(true_lines.split(&found, 5.0).is_none());
    }

    #[test]
    fn the_spindle_is_found_below_the_teeth() {
        let lines = peaks(&[
            125.0, 250.0, 375.0, 500.0, 625.0, 150.0, 175.1, 225.0, 275.0, 401.0,
        ]);
        let teeth = lines.score(125.0, None, Multiples::All);
        let spindle = lines.split(&teeth, 5.0).expect("lines between");
        assert_eq!((spindle.spacing, spindle.hits), (25.0, 9));
    }
}
