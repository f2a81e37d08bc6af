//! Options of `advise`.

use super::{MachineArgs, MonitorArgs, pair, within};
use clap::Args;
use std::path::PathBuf;

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
    /// The machine, where it is known.
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Cuts with the same tool that are known, stable or not: a table with the columns rpm, state (stable
    /// or chatter) and, if they are known, f in Hz and depth in mm.
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// Depth of this cut, mm, where those of `--known` have one.
    #[arg(long, value_name = "MM", value_parser = |text: &str| within(text, 1e-4, 1e4))]
    pub depth_mm: Option<f64>,
    /// What is heard is added to the file of `--known`, which is made if there is none.
    #[arg(long, requires = "known")]
    pub remember: bool,
    /// The feed is not changed with the speed: the feed of a tooth changes, the power does not.
    #[arg(long)]
    pub same_feed: bool,
    /// How far the speed may swing about its mean where no speed is stable, percent
    /// [default: 20].
    #[arg(long, value_name = "PERCENT", value_parser = |text: &str| within(text, 1.0, 50.0))]
    pub swing: Option<f64>,
    /// How fast the spindle may speed up in such a swing, rad/s²: 0.105 times its largest
    /// speed, 1/min, over its time to run up, s [default: 300].
    #[arg(long, value_name = "RAD/S2", value_parser = |text: &str| within(text, 0.1, 1e6))]
    pub swing_acceleration: Option<f64>,
    /// How often it may swing, times a second [default: 4].
    #[arg(long, value_name = "HZ", value_parser = |text: &str| within(text, 0.01, 100.0))]
    pub swing_hz: Option<f64>,
}

fn reach(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI in percent, such as 50:120")?;
    (low >= 1.0 && high > low && high <= 4.0 * low && high <= 1000.0)
        .then_some((low, high))
        .ok_or("must rise from 1 % or more, by at most 4 times, to 1000 % at most".to_owned())
}
