//! A checked series, its scale, and sums over it.

use super::error::FitError;
use rarma_core::real::Real;

/// Borrowed samples that are finite, enough, and not all equal. Read through
/// [`Series::at`], which divides by a power of two near the largest magnitude: so
/// squares neither overflow nor vanish, and no digit changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<'a, T> {
    y: &'a [T],
    offset: T,
    scale: T,
    inverse: T,
}

/// Doublings tried in the search for the scale: more than any exponent range.
const MOST_DOUBLINGS: u32 = 1000;

impl<'a, T: Real> Series<'a, T> {
    /// Checks `y`, of which at least `needed` samples (and two) are required.
    pub fn new(y: &'a [T], needed: usize) -> Result<Self, FitError> {
        Self::about(y, T::ZERO, needed)
    }

    /// The same with `offset` subtracted from every sample.
    pub fn about(y: &'a [T], offset: T, needed: usize) -> Result<Self, FitError> {
        if let Some(index) = y.iter().position(|x| !x.is_finite()) {
            return Err(FitError::NotFinite { index });
        }
        let needed = needed.max(2);
        if y.len() < needed {
            return Err(FitError::TooFewSamples { needed });
        }
        if y.iter().all(|x| *x == y[0]) {
            return Err(FitError::Constant);
        }
        let largest = y.iter().fold(T::ZERO, |m, x| m.max((*x - offset).abs()));
        let two = T::from_f64(2.0);
        let half = T::from_f64(0.5);
        let (mut scale, mut inverse) = (T::ONE, T::ONE);
        for _ in 0..MOST_DOUBLINGS {
            if scale < largest * half && (inverse * half) > T::ZERO {
                (scale, inverse) = (scale * two, inverse * half);
            } else if scale > largest && (inverse * two).is_finite() {
                (scale, inverse) = (scale * half, inverse * two);
            } else {
                break;
            }
        }
        Ok(Self {
            y,
            offset,
            scale,
            inverse,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.y.len()
    }

    /// Sample t over the scale.
    #[inline(always)]
    pub fn at(&self, t: usize) -> T {
        (self.y[t] - self.offset) * self.inverse
    }

    /// What one unit of [`Series::at`] is in input units.
    pub fn scale(&self) -> T {
        self.scale
    }

    /// A variance of scaled samples in input units squared.
    pub fn unscale_variance(&self, variance: T) -> T {
        variance * self.scale * self.scale
    }

    /// Σᵢ weights[i]·y(from + i), scaled.
    #[inline(always)]
    pub fn dot(&self, weights: &[T], from: usize) -> T {
        let mut sum = dot(weights, &self.y[from..from + weights.len()]);
        if self.offset != T::ZERO {
            for w in weights {
                sum -= *w * self.offset;
            }
        }
        sum * self.inverse
    }

    /// Autocovariance of lag k about 0, divided by the number of samples:
    /// r(k) = Σ y(t)·y(t+k)/n. Scaled.
    pub fn autocovariance(&self, lag: usize) -> T {
        let n = self.len();
        let mut sum = Accumulator::default();
        for t in lag..n {
            sum.add(self.at(t) * self.at(t - lag));
        }
        sum.value() / count(n)
    }
}

/// Inner product in eight lanes, which the compiler turns into vectors.
#[inline(always)]
pub(super) fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    let mut lanes = [T::ZERO; 8];
    let (chunks, others) = (x.chunks_exact(8), y.chunks_exact(8));
    let (rest, other_rest) = (chunks.remainder(), others.remainder());
    for (a, b) in chunks.zip(others) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += *a * *b;
        }
    }
    let mut sum = T::ZERO;
    for (a, b) in rest.iter().zip(other_rest) {
        sum += *a * *b;
    }
    for lane in lanes {
        sum += lane;
    }
    sum
}

/// A count as a number; exact up to 2³².
pub(super) fn count<T: Real>(n: usize) -> T {
    T::from_u32(u32::try_from(n).unwrap_or(u32::MAX))
}

/// A sum that keeps what rounding drops (Kahan): in `f32` over many samples the
/// plain sum would lose three digits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Accumulator<T> {
    sum: T,
    lost: T,
}

impl<T: Real> Accumulator<T> {
    #[inline(always)]
    pub fn add(&mut self, x: T) {
        let y = x - self.lost;
        let next = self.sum + y;
        self.lost = (next - self.sum) - y;
        self.sum = next;
    }

    pub fn value(&self) -> T {
        self.sum
    }
}

/// Arithmetic mean, input units; 0 of an empty slice.
///
/// The batch estimators take a series as it is: subtract this first.
pub fn mean<T: Real>(y: &[T]) -> T {
    let mut sum = Accumulator::default();
    for x in y {
        sum.add(*x);
    }
    sum.value() / count(y.len().max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_by_cause() {
        let error = |y: &[f32]| Series::new(y, 3).map(|_| ()).unwrap_err();
        assert_eq!(error(&[1.0, 2.0]), FitError::TooFewSamples { needed: 3 });
        assert_eq!(error(&[1.0; 9]), FitError::Constant);
        assert_eq!(
            error(&[1.0, f32::NAN, 2.0]),
            FitError::NotFinite { index: 1 }
        );
        assert_eq!(error(&[]), FitError::TooFewSamples { needed: 3 });
    }

    #[test]
    fn scale_is_a_power_of_two_next_to_the_largest() {
        for largest in [3.1e-38f32, 1e-20, 0.3, 1.0, 7.0, 1e30, 3e38] {
            let y = [0.0, largest, -0.1 * largest];
            let series = Series::new(&y, 2).expect("valid");
            assert!((0.5..=2.0).contains(&series.at(1)), "{largest}");
            assert_eq!(series.at(1) * series.scale(), largest);
        }
    }

    #[test]
    fn sums_keep_their_digits_in_single_precision() {
        let y = [0.1f32; 100_001];
        assert!((mean(&y) - 0.1).abs() < 1e-8);
        assert_eq!(mean::<f32>(&[]), 0.0);
    }

    #[test]
    fn dot_product_of_any_length() {
        let y: [f64; 21] = core::array::from_fn(|i| i as f64 - 3.0);
        let series = Series::new(&y, 2).expect("valid");
        for length in 0..18 {
            let w: [f64; 18] = core::array::from_fn(|i| 1.0 + i as f64);
            let plain: f64 = (0..length).map(|i| w[i] * y[2 + i]).sum();
            assert!((series.dot(&w[..length], 2) * series.scale() - plain).abs() < 1e-9);
        }
    }
}
