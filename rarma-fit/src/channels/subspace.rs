//! The decomposition of the covariances, and what the stretches say of it.

use super::config::SubspaceConfig;
use super::error::ChannelError;
use super::hankel::Covariances;
use alloc::vec::Vec;
use nalgebra::{DMatrix, DVector, SVD};

/// Sweeps of a decomposition at most.
pub(super) const SWEEPS: usize = 10_000;

/// What the difference of one stretch to the whole does to the singular vectors.
pub(super) struct Turn {
    /// Uᵀ·ΔH·V, the columns of V up to the largest order.
    pub left: DMatrix<f64>,
    /// Vᵀ·ΔHᵀ·U, the columns of U up to the largest order.
    pub right: DMatrix<f64>,
    /// What of ΔH·V lies outside of U.
    pub outside: DMatrix<f64>,
}

/// Covariances of several channels, decomposed once, from which models of any order follow; see
/// the head of this module for the formulas.
///
/// Pass channels with their mean removed, all of one length. Each channel is brought to unit
/// power first, so that its unit does not decide what it counts for; shapes come back in input
/// units.
///
/// ```
/// use rarma_fit::{Subspace, SubspaceConfig};
/// // One mode, driven by noise, seen by two sensors, the second half as strong and turned over.
/// let (mut y1, mut y2, mut seed) = (0.0, 0.0, 1u32);
/// let first: Vec<f64> = (0..20_000)
///     .map(|_| {
///         seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///         let e = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
///         let y = 1.6 * y1 - 0.95 * y2 + e;
///         (y2, y1) = (y1, y);
///         y
///     })
///     .collect();
/// let second: Vec<f64> = first.iter().map(|y| -0.5 * y).collect();
/// let subspace = Subspace::of(&[&first, &second], &[0, 1], SubspaceConfig::default())?;
/// let modes = subspace.modes(2, 1000.0)?;
/// assert!((modes[0].shape[1].re + 0.5).abs() < 1e-6);
/// assert!((modes[0].frequency - 96.8).abs() < 5.0 * modes[0].frequency_sd);
/// # Ok::<(), rarma_fit::ChannelError>(())
/// ```
pub struct Subspace {
    pub(super) u: DMatrix<f64>,
    pub(super) sigma: DVector<f64>,
    pub(super) turns: Vec<Turn>,
    /// Root mean square of each channel, input units.
    pub(super) scale: Vec<f64>,
    pub(super) neighbours: usize,
    most: usize,
}

impl Subspace {
    /// Decomposes the covariances of `series`, one slice a channel, with the channels
    /// `references` (counted from 0).
    ///
    /// # Errors
    /// The cause of the refusal, see [`ChannelError`].
    pub fn of(
        series: &[&[f64]],
        references: &[usize],
        config: SubspaceConfig,
    ) -> Result<Self, ChannelError> {
        config.check(series.len())?;
        let covariances = Covariances::of(series, references, &config)?;
        let mean = covariances.mean();
        let svd = SVD::try_new(mean.clone(), true, true, f64::EPSILON, SWEEPS)
            .ok_or(ChannelError::Singular)?;
        let (u, vt) = svd.u.zip(svd.v_t).ok_or(ChannelError::Singular)?;
        let sigma = svd.singular_values;
        let most = config
            .most_order
            .min((config.rows - 1) * series.len())
            .min(sigma.len() - 1);
        let v = vt.transpose();
        let (leading_u, leading_v) = (u.columns(0, most), v.columns(0, most));
        let weight = 1.0 / stretch_weight(covariances.stretches());
        let turns = (0..covariances.stretches())
            .map(|b| {
                let delta = (covariances.stretch(b) - &mean) * weight;
                let along = &delta * leading_v;
                let left = u.tr_mul(&along);
                Turn {
                    outside: &along - &u * &left,
                    right: vt.clone() * delta.tr_mul(&leading_u),
                    left,
                }
            })
            .collect();
        Ok(Self {
            u,
            sigma,
            turns,
            scale: covariances.scale,
            neighbours: config.neighbours,
            most,
        })
    }

    /// Singular values of the covariances of channels of unit power, from the largest on: the
    /// order shows as a step in them.
    pub fn singular_values(&self) -> &[f64] {
        self.sigma.as_slice()
    }

    /// Largest order that can be asked for.
    pub fn most_order(&self) -> usize {
        self.most
    }
}

/// √(b·(b − 1)): the covariance of a mean of b stretches is Σ ΔΔᵀ over its square.
fn stretch_weight(stretches: usize) -> f64 {
    let b = stretches as f64;
    libm::sqrt(b * (b - 1.0))
}
