//! What a format's reader gives: its beginning, blocks of samples, its end.

use super::InputError;

/// Samples without a header, as a pipe brings them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Raw {
    /// 16 bit integers, little endian; full scale is 1.
    S16,
    /// 32 bit floats, little endian.
    F32,
}

/// What the caller knows of a file.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Known {
    /// Sampling rate, Hz (default: what the file says).
    pub fs: Option<f64>,
    /// Stream of a record of a box, counted from 1 (default: the only one).
    pub stream: Option<usize>,
}

/// What is known when all has been read.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Odd, but not fatal: one sentence each.
    pub notices: Vec<String>,
}

/// What a format says at its beginning.
pub struct Begin {
    /// For people: `WAV, PCM 16 bit`.
    pub format: String,
    /// Sampling rate, Hz, where it is known at the beginning.
    pub fs: Option<f64>,
    /// Smallest step of a sample, as part of full scale; none where there is none.
    pub step: Option<f64>,
    /// Channels there are.
    pub channels: usize,
    /// What follows.
    pub blocks: Box<dyn Blocks>,
}

/// One format's reader behind its header.
pub trait Blocks {
    /// The channels that are wanted, all of which are there.
    fn want(&mut self, channels: &[usize]);

    /// Appends the samples that come next to `rows`, one for each wanted channel; false
    /// at the end.
    ///
    /// # Errors
    /// They cannot be read, or are no samples.
    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError>;

    /// Of the samples just given, so many at the beginning stand for missing ones.
    fn missing(&self) -> u64 {
        0
    }

    /// What the end tells.
    ///
    /// # Errors
    /// The recording lacks something that is only missed at its end.
    fn end(&mut self) -> Result<End, InputError>;

    /// Unit of a channel's samples, where the file says it; asked for at the end.
    fn unit(&self, channel: usize) -> Option<String> {
        let _ = channel;
        None
    }

    /// The error for a channel that is not there.
    fn no_channel(&self, asked: usize, channels: usize) -> InputError;
}
