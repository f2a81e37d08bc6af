//! What the channels have in common: their covariances at the first lags, and what each mode has
//! of them.

use alloc::vec;
use alloc::vec::Vec;
use nalgebra::{Complex, DMatrix};
use rarma_core::spectrum::{Quadratic, Roots};

/// Lags at least. White noise of the sensors lies in lag 0, which is left out. With half as many,
/// modes that are close in frequency are told apart less well; twice as many cost twice the time.
const LEAST_LAGS: usize = 32;
/// Deviations of the input beyond which a sample counts as this many: a blow does not take over
/// what is summed since long.
const MOST_DEVIATIONS: f64 = 6.0;
/// Singular values of the modes' lags, over the largest, that count as none.
const NONE: f64 = 1e-10;

/// Sums of y_k(t)·y_r(t − lag), lag = 1 … L, with their forgetting.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    channels: usize,
    lags: usize,
    /// The last L samples, newest first.
    past: Vec<f64>,
    /// Of lag l from k to r at ((l − 1)·K + r)·K + k.
    sums: Vec<f64>,
    weight: f64,
}

impl Moments {
    pub fn new(channels: usize, p: usize) -> Self {
        let lags = LEAST_LAGS.max(2 * p);
        Self {
            channels,
            lags,
            past: vec![0.0; lags * channels],
            sums: vec![0.0; lags * channels * channels],
            weight: 0.0,
        }
    }

    pub fn clear(&mut self) {
        self.past.fill(0.0);
        self.sums.fill(0.0);
        self.weight = 0.0;
    }

    /// Takes a sample of channels whose mean squares are `power`.
    pub fn add(&mut self, y: &[f64], power: &[f64], lambda: f64) {
        let k = self.channels;
        let held = |k: usize| {
            let most = MOST_DEVIATIONS * libm::sqrt(power[k]);
            y[k].clamp(-most, most)
        };
        let earlier = self.past.iter();
        for (sums, earlier) in self.sums.chunks_exact_mut(k).zip(earlier) {
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum = *sum * lambda + held(i) * earlier;
            }
        }
        self.weight = self.weight * lambda + 1.0;
        let kept = self.past.len() - k;
        self.past.copy_within(..kept, k);
        for i in 0..k {
            self.past[i] = held(i);
        }
    }

    /// For each factor with a pair z of roots the matrix G of what it has of the covariances, by
    /// least squares over the lags; none for those with real roots:
    ///
    /// ```text
    /// E y_k(t+l)·y_r(t) = Σ over modes Re(G_kr·z^l)
    /// ```
    pub fn of_modes(&self, factors: &[Quadratic<f64>]) -> Vec<Option<DMatrix<Complex<f64>>>> {
        let k = self.channels;
        let columns: Vec<[Complex<f64>; 2]> = factors.iter().map(roots).collect();
        let design = DMatrix::from_fn(self.lags, 2 * factors.len(), |l, j| {
            let at = |z: Complex<f64>| z.powi(l as i32 + 1);
            match columns[j / 2] {
                [z, _] if z.im > 0.0 && j % 2 == 0 => at(z).re,
                [z, _] if z.im > 0.0 => -at(z).im,
                real => at(real[j % 2]).re,
            }
        });
        let right = DMatrix::from_fn(self.lags, k * k, |l, i| {
            self.sums[l * k * k + i] / self.weight.max(1.0)
        });
        let svd = design.svd(true, true);
        let none = NONE * svd.singular_values.max();
        let Ok(found) = svd.solve(&right, none) else {
            return vec![None; factors.len()];
        };
        columns
            .iter()
            .enumerate()
            .map(|(m, [z, _])| {
                (z.im > 0.0).then(|| {
                    DMatrix::from_fn(k, k, |i, r| {
                        Complex::new(found[(2 * m, r * k + i)], found[(2 * m + 1, r * k + i)])
                    })
                })
            })
            .collect()
    }

    /// Every number of the state.
    pub fn all(&mut self) -> impl Iterator<Item = &mut f64> {
        let numbers = self.past.iter_mut().chain(&mut self.sums);
        numbers.chain(core::iter::once(&mut self.weight))
    }
}

/// The root of the upper half and its conjugate, or both real roots.
fn roots(factor: &Quadratic<f64>) -> [Complex<f64>; 2] {
    match factor.roots() {
        Roots::Pair { re, im } => [Complex::new(re, im), Complex::new(re, -im)],
        Roots::Real(a, b) => [a, b].map(|x| Complex::new(x, 0.0)),
    }
}
