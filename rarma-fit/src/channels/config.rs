//! Settings of the subspace method.

use super::error::ChannelError;

/// Settings of [`Subspace`](super::Subspace).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubspaceConfig {
    /// Block rows and block columns of the Hankel matrix, 2..=200, default 20: covariances of
    /// lags 1 to 2·rows − 1. The lags should reach over a period of the slowest mode.
    pub rows: usize,
    /// Stretches that the record is cut into for the deviations, 10..=1000, default 100.
    pub stretches: usize,
    /// Stretches on either side that one is taken to be correlated with, 0..=5, default 1.
    pub neighbours: usize,
    /// Largest order that is going to be asked for, 1..=200, default 40; less where the rows and
    /// channels hold less.
    pub most_order: usize,
}

impl Default for SubspaceConfig {
    fn default() -> Self {
        Self {
            rows: 20,
            stretches: 100,
            neighbours: 1,
            most_order: 40,
        }
    }
}

/// Rows of the Hankel matrix at most: beyond, the decomposition takes minutes.
const MOST_ROWS: usize = 2000;
impl SubspaceConfig {
    pub(super) fn check(&self, channels: usize) -> Result<(), ChannelError> {
        let settings = [
            ("rows", self.rows, 2..=200),
            ("stretches", self.stretches, 10..=1000),
            ("neighbours", self.neighbours, 0..=5),
            ("most_order", self.most_order, 1..=200),
            ("rows times channels", self.rows * channels, 2..=MOST_ROWS),
        ];
        match settings
            .into_iter()
            .find(|(_, value, range)| !range.contains(value))
        {
            Some((setting, ..)) => Err(ChannelError::OutOfRange { setting }),
            None => Ok(()),
        }
    }
}
