//! Histogram of the squared envelope and its nearest decreasing function: for the eye.
//!
//! Rate: decision rate. No decision comes from here: of sixteen bins, some rise over
//! their neighbour in any noise.

use crate::real::Real;
use crate::visit::state;

/// Bins of a histogram.
pub const BINS: usize = 16;
/// They reach from 0 to this multiple of the mean; 1.8 % of exponential V lie beyond.
pub const BINS_REACH: f64 = 4.0;

/// Counts of V in [`BINS`] equal bins from 0 to 4 times a mean that was frozen before
/// the first of them was counted: an estimate of w(V), eq. 32 of the thesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Histogram<T> {
    /// Counts per bin, from V = 0 up.
    pub counts: [u16; BINS],
    /// Values beyond the last bin.
    pub beyond: u16,
    /// Width of a bin, squared input units; 0 while nothing is known.
    pub bin_width: T,
}

state! { Histogram<T> { counts, beyond, bin_width } }

/// The decreasing function nearest to a histogram, and how far it is from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecreasingFit<T> {
    /// Fitted counts per bin, nowhere rising; their sum is that of the counts.
    pub counts: [T; BINS],
    /// Bins that hold more than the bin before.
    pub violations: u32,
    /// Part of all counts in the bins that would have to lie elsewhere for the
    /// histogram to decrease, 0..=1: Σ|count − fit| / (2·Σ count).
    pub weight: T,
}

impl<T: Real> Default for Histogram<T> {
    fn default() -> Self {
        Self {
            counts: [0; BINS],
            beyond: 0,
            bin_width: T::ZERO,
        }
    }
}

impl<T: Real> Histogram<T> {
    /// An empty histogram for values of this mean, > 0.
    pub fn of_mean(mean: T) -> Self {
        Self {
            bin_width: mean * T::from_f64(BINS_REACH / BINS as f64),
            ..Self::default()
        }
    }

    /// Counts one value; without a bin width, or for NaN, nothing.
    pub fn count(&mut self, v: T) {
        if !(self.bin_width > T::ZERO && v >= T::ZERO) {
            return;
        }
        let mut edge = self.bin_width;
        for count in &mut self.counts {
            if v < edge {
                *count = count.saturating_add(1);
                return;
            }
            edge += self.bin_width;
        }
        self.beyond = self.beyond.saturating_add(1);
    }

    /// Values counted, those beyond the last bin included.
    pub fn total(&self) -> u32 {
        self.counts.iter().map(|c| u32::from(*c)).sum::<u32>() + u32::from(self.beyond)
    }

    /// Pools adjacent bins until none rises over the one before: the decreasing
    /// function with the least squared distance. O([`BINS`]).
    pub fn decreasing(&self) -> DecreasingFit<T> {
        // Pools: sum and number of bins; a pool that rises over the last is merged.
        let mut pools = [(T::ZERO, 0usize); BINS];
        let mut used = 0usize;
        let (mut violations, mut before) = (0, u16::MAX);
        for &count in &self.counts {
            violations += u32::from(count > before);
            before = count;
            let mut pool = (T::from_u32(u32::from(count)), 1);
            while let Some(&(sum, bins)) = used.checked_sub(1).and_then(|i| pools.get(i)) {
                // Means compared by cross products: nothing to divide by.
                let rises = pool.0 * T::from_u32(bins as u32) > sum * T::from_u32(pool.1 as u32);
                if !rises {
                    break;
                }
                pool = (pool.0 + sum, pool.1 + bins);
                used -= 1;
            }
            if let Some(place) = pools.get_mut(used) {
                *place = pool;
                used += 1;
            }
        }
        let mut fit = [T::ZERO; BINS];
        let mut places = fit.iter_mut();
        for &(sum, bins) in pools.iter().take(used) {
            let mean = sum / T::from_u32(bins as u32);
            for place in places.by_ref().take(bins) {
                *place = mean;
            }
        }
        let (mut moved, mut all) = (T::ZERO, T::ZERO);
        for (&count, &fitted) in self.counts.iter().zip(&fit) {
            let count = T::from_u32(u32::from(count));
            moved += (count - fitted).abs();
            all += count;
        }
        let weight = if all > T::ZERO {
            moved / (all + all)
        } else {
            T::ZERO
        };
        DecreasingFit {
            counts: fit,
            violations,
            weight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_fall_into_their_bins() {
        let mut histogram = Histogram::<f32>::of_mean(2.0);
        assert_eq!(histogram.bin_width, 0.5);
        for v in [0.0, 0.49, 0.51, 7.9, 8.1, 1e30, f32::NAN, -1.0] {
            histogram.count(v);
        }
        assert_eq!(histogram.counts[..2], [2, 1]);
        assert_eq!((histogram.counts[15], histogram.beyond), (1, 2));
        assert_eq!(histogram.total(), 6);
        let mut nothing = Histogram::<f32>::default();
        nothing.count(1.0);
        assert_eq!(nothing.total(), 0);
        assert_eq!(nothing.decreasing().weight, 0.0);
    }

    #[test]
    fn a_hump_is_levelled() {
        let mut histogram = Histogram::<f64>::of_mean(1.0);
        histogram.counts[..6].copy_from_slice(&[2, 4, 9, 9, 1, 0]);
        let fit = histogram.decreasing();
        assert_eq!(fit.counts[..6], [6.0, 6.0, 6.0, 6.0, 1.0, 0.0]);
        assert_eq!(fit.violations, 2);
        assert!((fit.weight - 6.0 / 25.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn the_fit_decreases_and_keeps_sum_and_decreasing_input(
            counts in prop::array::uniform16(0u16..200)
        ) {
            let mut histogram = Histogram::<f64>::of_mean(1.0);
            histogram.counts = counts;
            let fit = histogram.decreasing();
            prop_assert!(fit.counts.windows(2).all(|w| w[1] <= w[0] + 1e-9));
            let sum = |c: &[f64]| c.iter().sum::<f64>();
            prop_assert!((sum(&fit.counts) - f64::from(histogram.total())).abs() < 1e-6);
            prop_assert!((0.0..=1.0).contains(&fit.weight));
            prop_assert_eq!(fit.violations == 0, fit.weight == 0.0);
            // No decreasing step function is nearer: each pool's fit is its mean, so
            // the residual is orthogonal to the fit.
            let cross: f64 = counts.iter().zip(&fit.counts).map(|(c, f)| (f64::from(*c) - f) * f).sum();
            prop_assert!(cross.abs() < 1e-6 * (1.0 + sum(&fit.counts).powi(2)));
        }
    }
}
