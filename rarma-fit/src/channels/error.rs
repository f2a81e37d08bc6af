//! Why channels give no modes.

use core::fmt;

/// Cause of a refusal; nothing is computed from such input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelError {
    /// No channel, or no reference.
    NoChannel,
    /// A channel is shorter or longer than the first.
    DifferentLengths {
        /// Which, from 0.
        channel: usize,
    },
    /// A sample is NaN or infinite.
    NotFinite {
        /// Which channel, from 0.
        channel: usize,
        /// Its place, from 0.
        index: usize,
    },
    /// All samples of a channel are 0.
    Silent {
        /// Which channel, from 0.
        channel: usize,
    },
    /// A reference is no channel.
    NoSuchReference {
        /// What was asked for.
        reference: usize,
    },
    /// The record is too short for so many block rows and stretches.
    TooFewSamples {
        /// Least number of samples.
        needed: usize,
    },
    /// A setting is out of its range.
    OutOfRange {
        /// Its name.
        setting: &'static str,
    },
    /// The order is 0, or above what so many rows and channels hold.
    Order {
        /// Largest one.
        most: usize,
    },
    /// The decomposition did not converge, or the record holds fewer states than the order.
    Singular,
}

impl fmt::Display for ChannelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoChannel => write!(f, "there is no channel, or no reference"),
            Self::DifferentLengths { channel } => {
                write!(f, "channel {channel} is not as long as the first")
            }
            Self::NotFinite { channel, index } => {
                write!(
                    f,
                    "sample {index} of channel {channel} is not a finite number"
                )
            }
            Self::Silent { channel } => write!(f, "channel {channel} is silent"),
            Self::NoSuchReference { reference } => {
                write!(f, "reference {reference} is no channel")
            }
            Self::TooFewSamples { needed } => {
                write!(f, "too few samples: these settings need {needed}")
            }
            Self::OutOfRange { setting } => write!(f, "{setting} is out of its range"),
            Self::Order { most } => write!(f, "the order must lie between 1 and {most}"),
            Self::Singular => write!(f, "the record does not determine a model of this order"),
        }
    }
}

impl core::error::Error for ChannelError {}
