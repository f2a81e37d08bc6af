//! The JSON of `rarma identify --channels`.

use serde::Serialize;

/// A mode without its shape, and what became of it since the model with two states less.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelPole {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Standard deviation of it, Hz.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Standard deviation of it.
    pub zeta_sd: f64,
    /// The frequency is within 1 % of a mode of the model below.
    pub stable_f: bool,
    /// So is the damping ratio within 5 %, and the shape is the same (MAC at least 0.95).
    pub stable: bool,
    /// Modal assurance criterion with the nearest mode of the model below, 0 to 1; null where
    /// there is none.
    pub mac: Option<f64>,
}

/// What one channel shows of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShapeRecord {
    /// Channel, counted from 0.
    pub channel: usize,
    /// Real part, over the channel that shows the most, which is 1.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Magnitude.
    pub magnitude: f64,
    /// Standard deviation of it; 0 of the channel that is 1.
    pub magnitude_sd: f64,
    /// Phase, degrees, −180 to 180.
    pub phase_deg: f64,
    /// Standard deviation of it, degrees.
    pub phase_deg_sd: f64,
}

/// A mode with its shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelModeRecord {
    /// Frequency and damping.
    #[serde(flatten)]
    pub pole: ChannelPole,
    /// One for each channel.
    pub shape: Vec<ShapeRecord>,
}

/// The modes of one order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelModel {
    /// States.
    pub order: usize,
    /// Modes in the band, sorted by frequency.
    pub modes: Vec<ChannelPole>,
}

/// All that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channels {
    /// `ssi-cov`.
    pub method: &'static str,
    /// States.
    pub order: usize,
    /// Channels of the file that were fitted.
    pub channels: Vec<usize>,
    /// Those that the others were correlated with.
    pub references: Vec<usize>,
    /// Block rows.
    pub rows: usize,
    /// Stretches for the deviations.
    pub stretches: usize,
    /// Band that was looked at, `[LO, HI]`, Hz; null for all of the recording.
    pub band: Option<[f64; 2]>,
    /// Rate of the samples that were fitted, Hz.
    pub fs: f64,
    /// How many they are.
    pub n: usize,
    /// Modes of the order that was asked for, in the band, sorted by frequency.
    pub modes: Vec<ChannelModeRecord>,
    /// The models of 2, 4 and so on states up to that order: the stabilisation diagram.
    pub orders: Vec<ChannelModel>,
    /// Singular values of the covariances of channels of unit power, from the largest on.
    pub singular_values: Vec<f64>,
}
