//! Options of `advise`.

use super::{MonitorArgs, pair, within};
use clap::Args;

/// Override that may be turned where nobody says so, percent of the present speed.
pub const USUAL_REACH: (f64, f64) = (50.0, 150.0);

/// Options of `advise`: those of `monitor`, and what may be turned.
#[derive(Debug, Clone, Args)]
pub struct AdviseArgs {
    /// How it listens.
    #[command(flatten)]
    pub monitor: MonitorArgs,
    /// Override that may be turned, percent of the speed at the alarm [default: 50:150].
    #[arg(long, value_name = "LO:HI", value_parser = reach)]
    pub reach: Option<(f64, f64)>,
    /// Power that the spindle can give over what the cut takes, such as 1.3: a faster speed at
    /// the same feed of a tooth takes more.
    #[arg(long, value_name = "RATIO", value_parser = |text: &str| within(text, 0.1, 100.0))]
    pub power: Option<f64>,
    /// The feed is not changed with the speed: the feed of a tooth changes, the power does not.
    #[arg(long)]
    pub same_feed: bool,
}

fn reach(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI in percent, such as 50:120")?;
    (low >= 1.0 && high > low && high <= 4.0 * low && high <= 1000.0)
        .then_some((low, high))
        .ok_or("must rise from 1 % or more, by at most 4 times, to 1000 % at most".to_owned())
}
