//! Covariances between channels, of the whole record and of each of its stretches.

use super::config::SubspaceConfig;
use super::error::ChannelError;
use crate::series::dot;
use alloc::vec;
use alloc::vec::Vec;
use nalgebra::DMatrix;

/// R(k), k = 1 … 2·rows − 1, of each stretch of the record.
pub(super) struct Covariances {
    channels: usize,
    references: usize,
    rows: usize,
    /// R of stretch b at ((b·lags + k − 1)·references + j)·channels + i, of channels of unit
    /// power.
    values: Vec<f64>,
    stretches: usize,
    /// Root mean square of each channel, input units.
    pub scale: Vec<f64>,
}

impl Covariances {
    /// Of channels that have been checked. A product belongs to the stretch that its earlier
    /// sample lies in, so the stretches together are the whole.
    pub fn of(
        series: &[&[f64]],
        references: &[usize],
        config: &SubspaceConfig,
    ) -> Result<Self, ChannelError> {
        let lags = 2 * config.rows - 1;
        let n = check(series, references)?;
        // A stretch shorter than the memory of the covariances tells nothing of its own.
        let needed = lags + config.stretches * lags;
        if n < needed {
            return Err(ChannelError::TooFewSamples { needed });
        }
        let length = (n - lags) / config.stretches;
        let scale: Vec<f64> = series
            .iter()
            .map(|y| libm::sqrt(dot(y, y) / n as f64))
            .collect();
        if let Some(channel) = scale.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(ChannelError::Silent { channel });
        }
        let mut values = Vec::with_capacity(config.stretches * lags * references.len());
        for b in 0..config.stretches {
            let from = b * length;
            for k in 1..=lags {
                for &j in references {
                    let early = &series[j][from..from + length];
                    for (y, s) in series.iter().zip(&scale) {
                        let late = &y[from + k..from + k + length];
                        values.push(dot(early, late) / (length as f64 * s * scale[j]));
                    }
                }
            }
        }
        Ok(Self {
            channels: series.len(),
            references: references.len(),
            rows: config.rows,
            values,
            stretches: config.stretches,
            scale,
        })
    }

    /// Stretches.
    pub fn stretches(&self) -> usize {
        self.stretches
    }

    /// Mean over all stretches.
    pub fn mean(&self) -> DMatrix<f64> {
        let all = self.per_stretch();
        let mut sum = vec![0.0; all];
        for one in self.values.chunks_exact(all) {
            for (s, x) in sum.iter_mut().zip(one) {
                *s += x / self.stretches as f64;
            }
        }
        self.hankel(&sum)
    }

    /// Stretch b.
    pub fn stretch(&self, b: usize) -> DMatrix<f64> {
        let all = self.per_stretch();
        self.hankel(&self.values[b * all..(b + 1) * all])
    }

    fn per_stretch(&self) -> usize {
        (2 * self.rows - 1) * self.channels * self.references
    }

    fn hankel(&self, values: &[f64]) -> DMatrix<f64> {
        let (r, s) = (self.channels, self.references);
        DMatrix::from_fn(self.rows * r, self.rows * s, |row, column| {
            let lag = row / r + column / s;
            values[(lag * s + column % s) * r + row % r]
        })
    }
}

/// Samples of each channel.
fn check(series: &[&[f64]], references: &[usize]) -> Result<usize, ChannelError> {
    let n = series.first().ok_or(ChannelError::NoChannel)?.len();
    if references.is_empty() {
        return Err(ChannelError::NoChannel);
    }
    for (channel, y) in series.iter().enumerate() {
        if y.len() != n {
            return Err(ChannelError::DifferentLengths { channel });
        }
        if let Some(index) = y.iter().position(|x| !x.is_finite()) {
            return Err(ChannelError::NotFinite { channel, index });
        }
    }
    match references.iter().find(|j| **j >= series.len()) {
        Some(&reference) => Err(ChannelError::NoSuchReference { reference }),
        None => Ok(n),
    }
}
