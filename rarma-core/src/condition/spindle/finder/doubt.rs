//! What speaks against a spacing though chance does not: chatter with sidebands a turn
//! apart, or with its own overtones, fits some speed.

use super::comb::{LEAST_ERROR_BINS, Score, TOLERANCE_BINS, ln_choose};
use super::peaks::{Peak, Peaks};
use crate::real::Real;

/// Lines of a comb scatter less about their multiples, bins rms; by chance it is 0.23.
const WIDEST_SCATTER_BINS: f64 = 0.2;
/// Above this scatter, bins rms, it is looked whether the lines have another spacing
/// and an offset (chatter with sidebands), by this ratio of squares.
const OFFSET_SCATTER_BINS: f64 = 0.1;
const OFFSET_RATIO: f64 = 9.0;
/// The strongest line may lie this part of a spacing beside a multiple by the distances
/// of its neighbours.
const OFF_ORIGIN: f64 = 0.15;
/// Cutters have no more teeth than this; a strongest line of a higher number that is
/// no multiple of the teeth is not theirs.
const MOST_TEETH: u32 = 12;

impl<T: Real> Peaks<T> {
    /// Whether the hits lie on multiples of the spacing, and not merely near them: on
    /// a line through the origin of small scatter. Chatter with sidebands a turn apart
    /// lies near the multiples of a speed that is a little wrong, but off the origin.
    pub fn through_origin(&self, score: &Score<T>) -> bool {
        let fine = self.refine(score).spacing;
        let (mut n_sum, mut n_square, mut off_sum, mut off_n, mut off_square) =
            (T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO);
        let mut m = T::ZERO;
        for peak in self.as_slice() {
            if let Some(n) = Self::multiple(peak, score.spacing) {
                let off = peak.bin - n * fine;
                m += T::ONE;
                n_sum += n;
                n_square += n * n;
                off_sum += off;
                off_n += off * n;
                off_square += off * off;
            }
        }
        if !(m > T::from_f64(2.5)) {
            return true;
        }
        let scatter = (off_square / m).sqrt();
        if scatter < T::from_f64(OFFSET_SCATTER_BINS) {
            return true;
        }
        // What a free offset and slope would take of the squares.
        let spread = n_square - n_sum * n_sum / m;
        let slope = (off_n - n_sum * off_sum / m) / spread;
        let taken = off_sum * off_sum / m + slope * slope * spread;
        let left = (off_square - taken).max(T::ZERO) / (m - T::from_f64(2.0));
        scatter < T::from_f64(WIDEST_SCATTER_BINS) && taken < left * T::from_f64(OFFSET_RATIO)
    }

    /// Whether the lines around the strongest one have the spacing by themselves: their
    /// distances from it give one without any origin, and it must put the strongest on
    /// a multiple. Sidebands of a chatter lie a turn apart, but beside the multiples.
    pub fn agrees_with_distances(&self, score: &Score<T>) -> bool {
        let Some(strongest) = self.as_slice().first() else {
            return true;
        };
        let Some(n0) = Self::multiple(strongest, score.spacing) else {
            return true;
        };
        let (mut df, mut dd, mut count) = (T::ZERO, T::ZERO, 0u32);
        let near = |peak: &Peak<T>| {
            let dn = Self::multiple(peak, score.spacing)? - n0;
            (dn != T::ZERO && dn.abs() * T::from_f64(3.0) <= n0).then_some(dn)
        };
        for peak in self.as_slice() {
            if let Some(dn) = near(peak) {
                df += dn * (peak.bin - strongest.bin);
                dd += dn * dn;
                count += 1;
            }
        }
        if count < 3 {
            return true;
        }
        let spacing = df / dd;
        let mut squares = T::ZERO;
        for peak in self.as_slice() {
            if let Some(dn) = near(peak) {
                let off = peak.bin - strongest.bin - dn * spacing;
                squares += off * off;
            }
        }
        let least = T::from_f64(LEAST_ERROR_BINS);
        let sd = (squares / T::from_u32(count)).sqrt().max(least) / dd.sqrt();
        let off = (strongest.bin - n0 * spacing).abs();
        off < (n0 * sd * T::from_f64(3.0)).max(spacing * T::from_f64(OFF_ORIGIN))
    }

    /// Whether the spacing rests on the overtones of the strongest peak alone: that peak
    /// is a hit whose number is no plausible one of teeth, nor a multiple of `teeth`,
    /// and without the hits on multiples of it what is left is no comb against chance
    /// `ln_least`. A loud chatter with its overtones fits some speed near any told one.
    pub fn rests_on_overtones(&self, score: &Score<T>, teeth: Option<u32>, ln_least: T) -> bool {
        let Some(strongest) = self.as_slice().first() else {
            return false;
        };
        let Some(n) = Self::multiple(strongest, score.spacing) else {
            return false;
        };
        let n = n.to_f32() as u32;
        let of_teeth = teeth.is_some_and(|z| z > 0 && n.is_multiple_of(z));
        if n <= MOST_TEETH || of_teeth {
            return false;
        }
        let p = (T::from_f64(2.0 * TOLERANCE_BINS) / score.spacing).min(T::from_f64(0.9));
        let (mut others, mut hits) = (0usize, 0usize);
        for peak in self.as_slice() {
            // Overtones lie where the strongest says, to as many times its error.
            let times = (peak.bin / strongest.bin).round();
            let off = (peak.bin - times * strongest.bin).abs();
            if times >= T::ONE && off <= T::from_f64(TOLERANCE_BINS) * times {
                continue;
            }
            others += 1;
            hits += usize::from(Self::multiple(peak, score.spacing).is_some());
        }
        ln_choose::<T>(others, hits) + T::from_u32(hits as u32) * p.ln() > ln_least
    }
}

#[cfg(test)]
mod tests {
    use super::super::comb::Multiples;
    use super::super::comb::tests::peaks;

    #[test]
    fn sidebands_of_chatter_are_no_lines_of_a_wrong_speed() {
        // 898.6 Hz and sidebands of 27.6 Hz in bins of 2.93 Hz, against 898.6/33.
        let sidebands: [f64; 5] =
            core::array::from_fn(|k| (898.6 + 27.6 * (k as f64 - 2.0)) / 2.929_687_5);
        let chatter = peaks(&sidebands);
        let wrong = chatter.score(898.6 / 33.0 / 2.929_687_5, None, Multiples::All);
        assert_eq!(wrong.hits, 5);
        assert!(!chatter.through_origin(&wrong));
        // Lines of that speed with as much scatter but no order in it.
        let off = [0.15, -0.15, 0.1, -0.12, 0.14];
        let lines: [f64; 5] = core::array::from_fn(|k| 9.3 * (31.0 + k as f64) + off[k]);
        let lines = peaks(&lines);
        assert!(lines.through_origin(&lines.score(9.3, None, Multiples::All)));
    }
}
