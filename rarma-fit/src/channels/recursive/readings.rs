//! What can be read off the model. Decision rate, or rarer.

use super::{MOST_ORDER, MOST_PARAMETERS, RecursiveChannels, Weights};
use alloc::vec::Vec;
use nalgebra::{Complex, DMatrix};
use rarma_core::UdFactors;
use rarma_core::spectrum::{FactorTracker, modal};

/// What one channel shows of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedPart {
    /// Real part over the channel that shows the most, 1.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Root mean square of the mode in this channel, input units.
    pub amplitude: f64,
}

/// A mode that all channels share.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedMode {
    /// Undamped natural frequency, Hz.
    pub frequency: f64,
    /// Standard deviation of it, Hz.
    pub frequency_sd: f64,
    /// Damping ratio, 1.
    pub damping: f64,
    /// Standard deviation of it.
    pub damping_sd: f64,
    /// One for each channel.
    pub parts: Vec<SharedPart>,
}

/// Sweeps over the roots at most; a search from nothing takes about thirty.
const SWEEPS: u32 = 500;

impl RecursiveChannels {
    /// Coefficients a₁…a_p, without the leading 1.
    pub fn a(&self) -> &[f64] {
        &self.theta[..self.p]
    }

    /// Coefficients c₁…c_q of one channel after the other, q·channels of them.
    pub fn c(&self) -> &[f64] {
        &self.theta[self.p..]
    }

    /// What the channels weigh.
    pub fn weights(&self) -> Weights {
        self.noise.weights
    }

    /// How many there are.
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Element of Λ, the covariance of the innovations; units of both channels.
    pub fn innovation_covariance(&self, row: usize, column: usize) -> f64 {
        self.noise.at(row, column)
    }

    /// Samples taken since the last reset.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The start is over: there is a model.
    pub fn ready(&self) -> bool {
        self.ready
    }

    /// Factors of the covariance of θ = (a, c₁ … c_K); multiply by
    /// [`covariance_factor`](Self::covariance_factor).
    pub fn covariance(&self) -> &UdFactors<f64, MOST_PARAMETERS> {
        &self.covariance
    }

    /// Σw²/Σw of the weights w = λᵏ, those of the start's samples being equal: 1 without
    /// forgetting, 1/(1 + λ) in the long run with it.
    pub fn covariance_factor(&self) -> f64 {
        let lambda = self.config.forgetting;
        if lambda == 1.0 || self.count == 0 {
            return 1.0;
        }
        let left = libm::exp(f64::from(self.count.saturating_sub(self.known)) * libm::log(lambda));
        let known = f64::from(self.known) * left;
        let sum = known + (1.0 - left) / (1.0 - lambda);
        let squares = known * left + (1.0 - left * left) / (1.0 - lambda * lambda);
        squares / sum
    }

    /// The modes of the model as it is now, by frequency; none before there is a model. The roots
    /// are sought anew. Slow path.
    ///
    /// Shapes and amplitudes are those of the covariances between the channels, as long as the
    /// memory is, of which least squares over the first lags gives each mode its share G:
    /// ψ_k = G_kr/G_rr over the channel r that shows the most, and √|G_kk| in units of channel k.
    pub fn modes(&self, fs: f64) -> Vec<SharedMode> {
        let mut roots = FactorTracker::<f64, MOST_ORDER>::new();
        if !self.ready || self.p == 0 || roots.solve(self.a(), SWEEPS).is_none() {
            return Vec::new();
        }
        let factors = roots.factors(self.p);
        let common = self.moments.of_modes(factors);
        let mut modes: Vec<SharedMode> = factors
            .iter()
            .zip(&common)
            .filter_map(|(factor, common)| {
                let (mode, sd) = (modal(factor, fs)?, self.deviation(factor, fs)?);
                Some(SharedMode {
                    frequency: mode.frequency,
                    frequency_sd: sd.frequency,
                    damping: mode.damping,
                    damping_sd: sd.damping,
                    parts: parts(common.as_ref()?),
                })
            })
            .collect();
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        modes
    }
}

/// Shape and amplitudes from what a mode has of the covariances.
fn parts(common: &DMatrix<Complex<f64>>) -> Vec<SharedPart> {
    let size = |k: usize| common[(k, k)].norm_sqr();
    let first = (0..common.nrows())
        .max_by(|i, j| size(*i).total_cmp(&size(*j)))
        .unwrap_or(0);
    (0..common.nrows())
        .map(|k| {
            let shape = common[(k, first)] / common[(first, first)];
            SharedPart {
                re: shape.re,
                im: shape.im,
                amplitude: libm::sqrt(libm::sqrt(size(k))),
            }
        })
        .collect()
}
