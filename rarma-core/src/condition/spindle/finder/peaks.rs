//! Lines of a spectrum: what stands out of the background, and how far.
//!
//! Words: *background*, the level between the lines of a spectrum.

use super::sliced_fft::SlicedFft;
use crate::real::Real;
use crate::visit::state;

/// Peaks that are kept, the strongest.
pub(crate) const MOST_PEAKS: usize = 24;
/// The background at a bin: this quantile of the bins so far to both sides.
const REACH: usize = 24;
const QUANTILE: f64 = 0.3;
/// Power of a peak over the background. 0.3 of noise lies below 0.36 of its mean,
/// and 8 in 10 000 of it above 20 times that.
const PEAK_RATIO: f64 = 20.0;
/// Beside a peak this much stronger, within so many bins, there is none: skirts of
/// the window (−31 dB) and of a speed that wanders.
const SKIRT: (usize, f64) = (4, 250.0);
const FAR_SKIRT: (usize, f64) = (12, 10_000.0);

/// A line of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Peak<T> {
    /// Frequency in bins, refined between them.
    pub bin: T,
    /// Power.
    pub power: T,
}

state! { Peak<T> { bin, power } }

/// The strongest peaks of a spectrum, the strongest first.
#[derive(Debug, Clone)]
pub(super) struct Peaks<T> {
    list: [Peak<T>; MOST_PEAKS],
    used: usize,
}

state! { Peaks<T> {
    list, used;
    where *used <= MOST_PEAKS
} }

impl<T: Real> Peaks<T> {
    /// None.
    pub const BLANK: Self = Self {
        list: [Peak {
            bin: T::ZERO,
            power: T::ZERO,
        }; MOST_PEAKS],
        used: 0,
    };

    /// Adds a peak, if it is among the strongest.
    pub fn insert(&mut self, peak: Peak<T>) {
        let mut next = peak;
        for (i, place) in self.list.iter_mut().enumerate() {
            if i >= self.used {
                *place = next;
                self.used = i + 1;
                return;
            }
            if next.power > place.power {
                core::mem::swap(place, &mut next);
            }
        }
    }

    /// The peaks, the strongest first.
    pub fn as_slice(&self) -> &[Peak<T>] {
        self.list.get(..self.used).unwrap_or(&[])
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.used = 0;
    }
}

/// The peak at bin `k`, if there is one; its background is read off `bins`, first and
/// one past the last.
pub(super) fn peak_at<T: Real, const M: usize>(
    fft: &SlicedFft<T, M>,
    bins: (usize, usize),
    k: usize,
) -> Option<Peak<T>> {
    let at = |i: usize| fft.power(i);
    let here = at(k);
    let (left, right) = (at(k - 1), at(k + 1));
    let largest = here > left && here >= right && here > at(k - 2) && here > at(k + 2);
    if !largest || !here.is_finite() {
        return None;
    }
    let level = here / T::from_f64(PEAK_RATIO);
    let (near, far) = (here * T::from_f64(SKIRT.1), here * T::from_f64(FAR_SKIRT.1));
    let (mut below, mut seen) = (0u32, 0u32);
    for i in k.saturating_sub(REACH).max(bins.0)..(k + REACH + 1).min(bins.1) {
        let p = at(i);
        let d = i.abs_diff(k);
        if (d <= SKIRT.0 && p > near) || (d <= FAR_SKIRT.0 && p > far) {
            return None;
        }
        seen += 1;
        below += u32::from(p < level);
    }
    if T::from_u32(below) < T::from_f64(QUANTILE) * T::from_u32(seen) {
        return None;
    }
    // Hann window: amplitudes of the two largest bins in the ratio
    // (1 + δ)/(2 − δ), δ from the larger one.
    let (side, sign) = if right > left {
        (right, T::ONE)
    } else {
        (left, -T::ONE)
    };
    let ratio = (side / here).sqrt();
    let two = T::from_f64(2.0);
    let delta = ((two * ratio - T::ONE) / (T::ONE + ratio)).clamp(T::ZERO, T::from_f64(0.5));
    Some(Peak {
        bin: T::from_u32(k as u32) + sign * delta,
        power: here,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_are_kept_in_order() {
        let mut all = Peaks::BLANK;
        for i in 0..40 {
            let power = f64::from((i * 17) % 40);
            all.insert(Peak { bin: power, power });
        }
        let bins: Vec<f64> = all.as_slice().iter().map(|p| p.bin).collect();
        let wanted: Vec<f64> = (16..40).rev().map(f64::from).collect();
        assert_eq!(bins, wanted);
    }
}
