//! Options of `act`.

use super::{MachineArgs, MonitorArgs, pair, within};
use clap::Args;
use std::path::PathBuf;

/// Override within which speeds are looked for where nobody says so, percent.
pub const USUAL_LIMITS: (f64, f64) = (80.0, 120.0);

/// Options of `act`: those of `monitor`, and what may be ordered of whom.
#[derive(Debug, Clone, Args)]
pub struct ActArgs {
    /// How it listens. The input may be a box, `box:PORT` or `box:tcp:HOST:PORT`: it hears, by its own settings, and is
    /// told the speed.
    #[command(flatten)]
    pub monitor: MonitorArgs,
    /// The machine's controller: `dry` (none), `grbl:PORT`, `grbl:tcp:HOST:PORT`, `linuxcnc` or
    /// `linuxcnc:HOST:PORT`.
    #[arg(long, value_name = "WHICH", value_parser = which)]
    pub controller: Which,
    /// Order what is proposed. Without it, it is only said what would be ordered.
    #[arg(long, requires = "limits")]
    pub act: bool,
    /// Smallest and largest override of the spindle that may be ordered, percent of the
    /// programmed speed [without --act: 80:120].
    #[arg(long = "override", value_name = "MIN:MAX", value_parser = limits)]
    pub limits: Option<(f64, f64)>,
    /// The override changes by so many percent a second at most.
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0,
          value_parser = |text: &str| within(text, 5.0, 500.0))]
    pub rate: f64,
    /// Speeds that are tried one after the other in one program.
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u32).range(1..=10))]
    pub tries: u32,
    /// Power that the spindle can give over what the cut takes, such as 1.3.
    #[arg(long, value_name = "RATIO", value_parser = |text: &str| within(text, 0.1, 100.0))]
    pub power: Option<f64>,
    /// The machine, where it is known.
    #[command(flatten)]
    pub machine: MachineArgs,
    /// The feed is not ordered: it stays, and the feed of a tooth changes with the speed.
    #[arg(long)]
    pub same_feed: bool,
    /// Lines of JSON, one for everything that happens, are added to this file [with --act:
    /// rarma-act.jsonl].
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Bits a second of a serial port.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200,
          value_parser = clap::value_parser!(u32).range(1200..=4_000_000))]
    pub baud: u32,
    /// Seal what is said to the box with the key in this file, 64 hexadecimal digits.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Bits a second of the serial port of a box.
    #[arg(long, value_name = "BAUD", default_value_t = 2_000_000,
          value_parser = clap::value_parser!(u32).range(1200..=4_000_000))]
    pub box_baud: u32,
}

impl ActArgs {
    /// Where it is logged to, if anywhere: orders always are.
    pub fn log_file(&self) -> Option<PathBuf> {
        let usual = || self.act.then(|| PathBuf::from("rarma-act.jsonl"));
        self.log.clone().or_else(usual)
    }
}

/// Which controller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Which {
    /// None.
    Dry,
    /// Grbl or grblHAL at this port.
    Grbl(String),
    /// LinuxCNC at this address, if one is told.
    LinuxCnc(Option<String>),
}

fn which(text: &str) -> Result<Which, String> {
    let (name, rest) = match text.split_once(':') {
        Some((name, rest)) => (name, Some(rest)),
        None => (text, None),
    };
    match (name, rest) {
        ("dry", None) => Ok(Which::Dry),
        ("grbl", Some(port)) if !port.is_empty() => Ok(Which::Grbl(port.to_owned())),
        ("linuxcnc", None) => Ok(Which::LinuxCnc(None)),
        ("linuxcnc", Some(address)) if address.contains(':') => {
            Ok(Which::LinuxCnc(Some(address.to_owned())))
        }
        _ => Err("must be dry, grbl:PORT (such as grbl:/dev/ttyUSB0), grbl:tcp:HOST:PORT, linuxcnc, or linuxcnc:HOST:PORT".to_owned()),
    }
}

fn limits(text: &str) -> Result<(f64, f64), String> {
    let (least, most) = pair(text, ':', "MIN:MAX in percent, such as 80:120")?;
    ((10.0..=100.0).contains(&least) && (100.0..=200.0).contains(&most) && least < most)
        .then_some((least, most))
        .ok_or("must lie in 10 to 200 % and hold 100 %, such as 80:120".to_owned())
}
