//! Options of the commands about a box.

use super::ScreenArg;
use clap::Args;
use std::path::PathBuf;

/// Options of `box`.
#[derive(Debug, Clone, Args)]
pub struct BoxArgs {
    /// Scenario: a TOML file, a shipped name (see --list), or a cut of `rarma simulate` that the
    /// box listens to.
    #[arg(long, value_name = "SCENARIO", required_unless_present_any = ["list", "schema", "faults", "settings"])]
    pub sim: Option<String>,
    /// Seed of everything random, in place of the scenario's.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Keep every byte the box sends, after what the file holds already.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Serve the box on a socket in real time, for `rarma connect tcp:HOST:PORT`, in place of
    /// the scenario's own host. It is a network: only hosts with the key may change anything.
    #[arg(long, value_name = "HOST:PORT")]
    pub listen: Option<String>,
    /// The box has the key in this file, 64 hexadecimal digits.
    #[arg(long, value_name = "FILE", requires = "listen")]
    pub key: Option<PathBuf>,
    /// One JSON object a message on standard output, and a summary last.
    #[arg(long)]
    pub json: bool,
    /// Name the shipped scenarios.
    #[arg(long)]
    pub list: bool,
    /// JSON schema of a scenario file.
    #[arg(long)]
    pub schema: bool,
    /// Name the faults a scenario can make.
    #[arg(long)]
    pub faults: bool,
    /// The box's settings as a page; with --json as a schema.
    #[arg(long)]
    pub settings: bool,
}

/// Options of `decode`.
#[derive(Debug, Clone, Args)]
pub struct DecodeArgs {
    /// A file, `-` for standard input, a serial port such as /dev/ttyACM0, or tcp:HOST:PORT.
    pub input: String,
    /// Speed of a serial port, baud.
    #[arg(long, default_value_t = 2_000_000)]
    pub baud: u32,
    /// One JSON object a message on standard output.
    #[arg(long)]
    pub json: bool,
    /// Write the raw samples in the frames into a WAV; the second stream and those after it
    /// into files of their own, FILE-2 and so on.
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// Write this stream only, counted from 1: a restart of the box or a gap of more than a
    /// second begins a new one.
    #[arg(long, value_name = "N", requires = "wav", value_parser = stream)]
    pub stream: Option<usize>,
}

/// Options of `connect`.
#[derive(Debug, Clone, Args)]
pub struct ConnectArgs {
    /// A serial port such as /dev/ttyACM0, or tcp:HOST:PORT.
    pub port: String,
    /// Speed of a serial port, baud.
    #[arg(long, default_value_t = 2_000_000)]
    pub baud: u32,
    /// Say this first; may be given several times. Commands may be typed, too.
    #[arg(long = "say", value_name = "COMMAND")]
    pub say: Vec<String>,
    /// Print every setting of the box, and go.
    #[arg(long)]
    pub settings: bool,
    /// Keep every byte the box sends, after what the file holds already; `rarma decode` reads
    /// it, and `rarma monitor` if its name
    /// ends in .frames and it holds raw samples.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Go after so many seconds.
    #[arg(long, value_name = "SECONDS")]
    pub seconds: Option<f64>,
    /// Look on: do not take control where nobody has it.
    #[arg(long)]
    pub look: bool,
    /// Seal what is said with the key in this file, 64 hexadecimal digits.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Give the box the key in this file, at its own port, and go; `none` removes it. Where
    /// there is one, --key is the old one, or somebody holds the emergency stop pressed.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["settings", "say", "look", "json", "seconds"])]
    pub set_key: Option<PathBuf>,
    /// Show a live screen [default: auto].
    #[arg(long, value_enum, value_name = "WHEN")]
    pub screen: Option<ScreenArg>,
    /// One JSON object a message on standard output.
    #[arg(long)]
    pub json: bool,
}

/// A stream of a record, counted from 1.
pub(super) fn stream(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|n| *n > 0);
    number.ok_or("must be a whole number from 1 on".to_owned())
}
