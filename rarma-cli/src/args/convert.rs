//! Options of `convert`.

use super::{ChannelSet, InputArgs, channels};
use clap::Args;
use std::path::PathBuf;

/// A recording to another format.
#[derive(Debug, Clone, Args)]
pub struct ConvertArgs {
    /// The recording.
    #[command(flatten)]
    pub input: InputArgs,
    /// Channels to be written, counted from 0 [default: all].
    #[arg(long, value_name = "all|0,1,...", value_parser = channels::set, conflicts_with = "channel")]
    pub channels: Option<ChannelSet>,
    /// Where to: .csv, .uff, .unv (universal file, dataset 58) or .mat (MATLAB level 5).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Unit of the samples, such as m/s^2 [default: what the recording says, else 1, parts of full scale].
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    pub unit: Option<String>,
}

pub(super) fn unit(text: &str) -> Result<String, String> {
    let fits = (1..=20).contains(&text.len()) && text.chars().all(|c| c.is_ascii_graphic());
    fits.then(|| text.to_owned())
        .ok_or("must have 1 to 20 letters, signs or digits, without a blank".to_owned())
}
