//! Recursive ARMA of several channels that share their poles: a new model at every sample.
//!
//! Rate: once a sample, on a host; allocates when it is made and when it starts, not in between.
//! See [`RecursiveChannels`].

mod channel;
mod modal;
mod moments;
mod noise;
mod readings;
mod scores;
mod start;
mod state;
mod step;

pub use readings::{SharedMode, SharedPart};
pub use step::{ChannelStatus, ChannelStep};

use super::error::ChannelError;
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use channel::Channel;
use moments::Moments;
use noise::Noise;
use rarma_core::UdFactors;
use rarma_core::estimate::{Gain, Gradient, RarmaConfig};
use scores::Scores;

/// Parameters p + channels·q at most.
pub const MOST_PARAMETERS: usize = 128;
/// Largest p and q.
pub const MOST_ORDER: usize = 30;
/// Channels at most.
pub const MOST_CHANNELS: usize = 16;

/// What the innovations of the channels weigh beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weights {
    /// Each by the variance of its own: right whatever shakes the structure and whatever noise
    /// the sensors have, for it asks of each channel's innovations only that they are white.
    #[default]
    Own,
    /// By the inverse of Λ: reaches the bound of the model where the innovations of a channel
    /// cannot be predicted from the *others'* past either. Where they can (two noisy sensors of
    /// one mode), it is biased, and its deviations are too small.
    Joint,
}

/// Recursive prediction error estimator of K channels with one A and a C each.
///
/// Model, with plus signs as in [`RecursiveArma`](rarma_core::estimate::RecursiveArma):
///
/// ```text
/// A(q)·y_k(t) = C_k(q)·e_k(t),   k = 1 … K,   E e(t)·e(t)ᵀ = Λ,   e white
/// ```
///
/// The poles of a structure are the same wherever it is listened to: K channels tell of one A,
/// and what one does not see, being in the node of a mode, another does. Sensors of one
/// structure hear the same force, so the innovations are correlated, and Λ is full.
///
/// Recurrence, with θ = (a, c₁ … c_K), φ_k the regressor of channel k (0 at the others' c), and
/// Λ = L·D·Lᵀ running, L with ones on its diagonal:
///
/// ```text
/// e_k = y_k − φ_kᵀθ,   ψ_k = φ_k filtered by 1/C_k(q)
/// (u, η) = L⁻¹·(e, ψ)                           no longer correlated
/// for k = 1 … K, one scalar equation after the other:
///     α = d_k + η_kᵀPη_k,   K = Pη_k/α
///     θ ← θ + K·(u_k − η_kᵀ·Δθ)                 Δθ what this sample has moved so far
///     P ← P − Pη_k·η_kᵀP/α                      λd_k for d_k, and P/λ, at the first
/// Λ ← Λ + g·(v·vᵀ − Λ)                          v = L·(u, shortened by √(d/α))
/// ```
///
/// which together is one step of Gauss and Newton for Σ eᵀΛ⁻¹e. That is [`Weights::Joint`]; with
/// [`Weights::Own`], the default, L = 1. With one channel both are
/// [`RecursiveArma`](rarma_core::estimate::RecursiveArma), line by line.
///
/// Deviations: P·[`covariance_factor`](Self::covariance_factor) is the covariance of θ where the
/// channels' equations are independent of each other, and too small where the channels hear the
/// same. With `Own`, what the scores η_k·u_k/d_k of all channels together scatter by, stretch by
/// stretch, tells how much too small (see `scores`).
///
/// The settings are that model's: memory 1/(1 − λ) samples, random walk, samples of the start
/// (least squares in rounds over all channels together, with equal weights, so that no λ has to
/// grow at first), radius of the roots of each C. A gradient or gain other than the default is
/// refused.
///
/// docs/channels.md has what either reaches beside the bound.
///
/// ```
/// use rarma_core::estimate::RarmaConfig;
/// use rarma_fit::{RecursiveChannels, Weights};
/// // One mode; the second sensor hears it half as strong, turned over and with noise of its own.
/// let (mut y1, mut y2, mut seed) = (0.0, 0.0, 1u32);
/// let mut noise = || {
///     seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     f64::from(seed >> 8) / 8_388_608.0 - 1.0
/// };
/// let mut model = RecursiveChannels::new(2, 2, 2, Weights::Own, RarmaConfig::default())?;
/// for _ in 0..20_000 {
///     let y = 1.6 * y1 - 0.95 * y2 + noise();
///     (y2, y1) = (y1, y);
///     model.update(&[y, -0.5 * y + 0.3 * noise()]);
/// }
/// let modes = model.modes(1000.0);
/// assert!((modes[0].frequency - 96.8).abs() < 5.0 * modes[0].frequency_sd);
/// assert!((modes[0].parts[1].re + 0.5).abs() < 0.1);
/// # Ok::<(), rarma_fit::ChannelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct RecursiveChannels {
    p: usize,
    q: usize,
    config: RarmaConfig<f64>,
    /// (a, c of channel 0, c of channel 1 …).
    theta: Vec<f64>,
    channels: Vec<Channel>,
    covariance: Box<UdFactors<f64, MOST_PARAMETERS>>,
    noise: Noise,
    scores: Scores,
    moments: Moments,
    /// Samples of the start, one channel after the other within each.
    stored: Vec<f64>,
    ready: bool,
    /// Samples of the start that the model has worked through.
    known: u32,
    count: u32,
    /// Factor of the covariance whose turn it is to be held in range.
    turn: usize,
    at_ceiling: usize,
    /// θ before and how far it moves, kept so that a sample allocates nothing.
    scratch: step::Scratch,
}

impl RecursiveChannels {
    /// A model of K = `channels` that has seen nothing: p, q up to 30, p + K·q up to 128.
    ///
    /// # Errors
    /// `NoChannel`; `OutOfRange` with the name of what is out of its range, `start_samples`
    /// also where it is 0: this model has no cold start.
    pub fn new(
        p: usize,
        q: usize,
        channels: usize,
        weights: Weights,
        config: RarmaConfig<f64>,
    ) -> Result<Self, ChannelError> {
        if channels == 0 {
            return Err(ChannelError::NoChannel);
        }
        let n = p + q * channels;
        let usual = config.gradient == Gradient::Filtered && config.gain == Gain::Covariance;
        let refused = [
            ("p", p > MOST_ORDER),
            ("q", q > MOST_ORDER),
            ("channels", channels > MOST_CHANNELS),
            ("p + q·channels", n == 0 || n > MOST_PARAMETERS),
            ("gradient, gain", !usual),
            ("start_samples", config.start_samples < least_start(p, q)),
            ("settings", config.checked().is_err()),
        ];
        if let Some((setting, _)) = refused.into_iter().find(|(_, wrong)| *wrong) {
            return Err(ChannelError::OutOfRange { setting });
        }
        Ok(Self {
            p,
            q,
            theta: vec![0.0; n],
            channels: vec![Channel::new(p, q); channels],
            covariance: Box::new(UdFactors::diagonal(config.start_variance)),
            noise: Noise::new(channels, weights),
            scores: Scores::new(n),
            moments: Moments::new(channels, p),
            stored: Vec::with_capacity(channels * config.start_samples as usize),
            ready: false,
            known: 0,
            count: 0,
            turn: 0,
            at_ceiling: 0,
            scratch: step::Scratch::new(n, channels),
            config,
        })
    }

    /// Forgets everything but the settings.
    pub fn reset(&mut self) {
        self.theta.fill(0.0);
        self.clear_filters();
        self.covariance.reset(self.config.start_variance);
        self.noise.clear();
        self.scores.clear();
        self.moments.clear();
        self.stored.clear();
        self.ready = false;
        (self.known, self.count, self.turn, self.at_ceiling) = (0, 0, 0, 0);
    }

    fn clear_filters(&mut self) {
        self.channels.iter_mut().for_each(Channel::clear);
    }

    /// Place of the first c of a channel in θ.
    fn place(&self, channel: usize) -> usize {
        self.p + channel * self.q
    }
}

/// Samples that the start needs at least: as many as the least squares of one channel.
pub(crate) fn least_start(p: usize, q: usize) -> u32 {
    4 * (p + q) as u32 + 8
}
