//! The running covariance Λ of the innovations, held in range, and its factors L·D·Lᵀ.

use super::Weights;
use alloc::vec;
use alloc::vec::Vec;
use rarma_core::estimate::RarmaConfig;

/// Least innovation variance, so that silence divides by a normal number.
pub(super) const SMALLEST_VARIANCE: f64 = 1e-30;
// Gain of the recent innovation variance, and how far Λ may be above it: as in rarma-core's
// recursion, which has their origin.
const RECENT_GAIN: f64 = 1.0 / 32.0;
const RECENT_RATIO: f64 = 4.0;
/// Wild innovations of one channel in a row that are taken for its noise from then on, where
/// there are other channels. A sensor that was dead and comes back would otherwise be wild for
/// thousands of samples, and each takes 3 % of confidence back from what all have learnt: 1.6
/// times the variance in all here. With half as many a burst of eight samples passes for noise
/// of the sensor, with twice as many what is taken back is 2.6.
const WILD_RUN: u32 = 16;

/// Λ and what bounds it.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    channels: usize,
    pub weights: Weights,
    /// Λ, row by row, input units squared.
    lambda: Vec<f64>,
    /// L, row by row, without its diagonal of ones.
    l: Vec<f64>,
    /// D.
    d: Vec<f64>,
    /// Diagonal of Λ over the last few tens of samples.
    recent: Vec<f64>,
    /// Mean square of the input over a long memory.
    pub power: Vec<f64>,
    /// Gain of the next innovations on Λ.
    gain: f64,
    /// Wild innovations of each channel in a row, and the sum of their squares.
    wild: Vec<(u32, f64)>,
}

impl Noise {
    pub fn new(channels: usize, weights: Weights) -> Self {
        Self {
            channels,
            weights,
            lambda: vec![0.0; channels * channels],
            l: vec![0.0; channels * channels],
            d: vec![0.0; channels],
            recent: vec![0.0; channels],
            power: vec![0.0; channels],
            gain: 1.0,
            wild: vec![(0, 0.0); channels],
        }
    }

    pub fn clear(&mut self) {
        *self = Self::new(self.channels, self.weights);
    }

    /// Begins with the mean of e·eᵀ over so many samples of the start.
    pub fn begin(&mut self, lambda: Vec<f64>, samples: u32) {
        self.lambda = lambda;
        for k in 0..self.channels {
            self.recent[k] = self.at(k, k);
        }
        self.gain = 1.0 / f64::from(samples);
    }

    /// Element of Λ.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.lambda[row * self.channels + column]
    }

    /// Row k of L left of its diagonal.
    pub fn row(&self, k: usize) -> &[f64] {
        &self.l[k * self.channels..k * self.channels + k]
    }

    /// D of channel k: what of its innovation those of the channels before do not tell.
    pub fn d(&self, k: usize) -> f64 {
        self.d[k]
    }

    /// Follows the power of the input.
    pub fn hear(&mut self, y: &[f64], config: &RarmaConfig<f64>) {
        for (power, y) in self.power.iter_mut().zip(y) {
            *power += config.power_gain * (y * y - *power);
        }
    }

    /// L and D of Λ, of its diagonal alone with [`Weights::Own`]. A variance is not above the power of the input (a model that predicts worse
    /// than none would take its own errors for noise) and not below the dynamic range; a channel
    /// that is held keeps its correlations. Nor is any of D below the dynamic range: two
    /// sensors that say the same are no contradiction.
    pub fn factor(&mut self, config: &RarmaConfig<f64>) {
        let k = self.channels;
        for i in 0..k {
            let floor = self.power[i] * config.dynamic_range + SMALLEST_VARIANCE;
            let (variance, scale_i) = self.held(i, config);
            let mut d = variance;
            let correlated = match self.weights {
                Weights::Own => 0,
                Weights::Joint => i,
            };
            for j in 0..correlated {
                let (_, scale_j) = self.held(j, config);
                let mut sum = self.at(i, j) * scale_i * scale_j;
                for m in 0..j {
                    sum -= self.l[i * k + m] * self.l[j * k + m] * self.d[m];
                }
                let l = sum / self.d[j];
                self.l[i * k + j] = l;
                d -= l * l * self.d[j];
            }
            self.d[i] = d.max(floor);
        }
    }

    /// Variance of a channel in range, and the factor to its deviation that does it.
    fn held(&self, i: usize, config: &RarmaConfig<f64>) -> (f64, f64) {
        let found = self.at(i, i);
        let floor = self.power[i] * config.dynamic_range + SMALLEST_VARIANCE;
        let variance = found.min(self.power[i]).max(floor);
        let scale = if variance == found {
            1.0
        } else {
            libm::sqrt(variance / found.max(SMALLEST_VARIANCE))
        };
        (variance, scale)
    }

    /// Λ ← Λ + g·(v·vᵀ − Λ) with v = L·`apart`: the plain mean at first, then over its memory;
    /// after a loud passage no more than a few times what the last samples had.
    pub fn track(&mut self, apart: &mut [f64], config: &RarmaConfig<f64>) {
        let k = self.channels;
        for i in (0..k).rev() {
            for j in 0..i {
                apart[i] += self.l[i * k + j] * apart[j];
            }
        }
        for i in 0..k {
            self.recent[i] += (apart[i] * apart[i] - self.recent[i]) * RECENT_GAIN;
            for j in 0..k {
                let at = &mut self.lambda[i * k + j];
                *at += self.gain * (apart[i] * apart[j] - *at);
            }
        }
        for i in 0..k {
            let most = self.recent[i] * RECENT_RATIO;
            if self.at(i, i) > most {
                let scale = libm::sqrt(most / self.at(i, i));
                for j in 0..k {
                    self.lambda[i * k + j] *= scale;
                    self.lambda[j * k + i] *= scale;
                }
            }
        }
        if self.gain > config.variance_gain {
            self.gain = (self.gain / (1.0 + self.gain)).max(config.variance_gain);
        }
    }

    /// Whether the innovation e of channel k is wild; after too many in a row its variance is
    /// theirs.
    pub fn judge(&mut self, k: usize, e: f64, wild: bool) {
        if self.channels == 1 || !wild {
            self.wild[k] = (0, 0.0);
            return;
        }
        let (run, sum) = (self.wild[k].0 + 1, self.wild[k].1 + e * e);
        self.wild[k] = (run, sum);
        if run < WILD_RUN {
            return;
        }
        self.wild[k] = (0, 0.0);
        let variance = sum / f64::from(run);
        let scale = libm::sqrt(variance / self.at(k, k).max(SMALLEST_VARIANCE));
        for j in 0..self.channels {
            if j != k {
                self.lambda[k * self.channels + j] *= scale;
                self.lambda[j * self.channels + k] *= scale;
            }
        }
        self.lambda[k * self.channels + k] = variance;
        self.recent[k] = variance;
    }

    /// The run of wild innovations of each channel.
    pub fn runs(&mut self) -> impl Iterator<Item = (&mut u32, &mut f64)> {
        self.wild.iter_mut().map(|(run, sum)| (run, sum))
    }

    /// Every number that the next sample needs, but for the runs.
    pub fn all(&mut self) -> impl Iterator<Item = &mut f64> {
        let Self {
            channels: _,
            weights: _,
            lambda,
            l: _,
            d: _,
            recent,
            power,
            gain,
            wild: _,
        } = self;
        lambda
            .iter_mut()
            .chain(recent)
            .chain(power)
            .chain(core::iter::once(gain))
    }
}
