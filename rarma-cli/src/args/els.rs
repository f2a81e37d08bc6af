//! Options of `els`.

use super::{pair, within};
use clap::{Args, Subcommand, ValueEnum};
use rarma_rigs::els::CutConfig;
use rarma_scenarios::els::diagram::Cut;
use rarma_scenarios::els::hammer;
use std::path::PathBuf;

/// What the sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Sensor {
    /// m/s².
    Acceleration,
    /// m/s.
    Velocity,
    /// m.
    Displacement,
}

impl From<Sensor> for hammer::Sensor {
    fn from(sensor: Sensor) -> Self {
        match sensor {
            Sensor::Acceleration => Self::Acceleration,
            Sensor::Velocity => Self::Velocity,
            Sensor::Displacement => Self::Displacement,
        }
    }
}

/// The commands of `els`.
#[derive(Debug, Clone, Subcommand)]
pub enum ElsCommand {
    /// The computational model: frequencies against load, shapes, deflection, limits.
    Model(ElsModelArgs),
    /// Limits and static stiffness all round, from measured receptances.
    Limit(ElsLimitArgs),
    /// A hammer record: receptance, modes by two methods, limits.
    Hammer(ElsHammerArgs),
    /// Stiffness of joints and bearings from load steps and receptances.
    Fit(ElsFitArgs),
}

/// What is cut.
#[derive(Debug, Clone, Copy, Args)]
pub struct CutArgs {
    /// Specific cutting stiffness, N/mm².
    #[arg(long, value_name = "N/MM2", default_value_t = 2000.0, value_parser = stiffness)]
    pub ks: f64,
    /// Teeth in the cut on average.
    #[arg(long, default_value_t = 1.0, value_parser = teeth)]
    pub teeth_in_cut: f64,
    /// Share of the last wave that is cut again, 0 to 1.
    #[arg(long, default_value_t = 1.0, value_parser = share)]
    pub overlap: f64,
    /// Angle from the cutting force to the direction of the chip thickness, degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = angle)]
    pub chip_angle: f64,
    /// Replace the two cross receptances by their mean.
    #[arg(long)]
    pub symmetrise: bool,
}

impl CutArgs {
    /// In SI units.
    pub fn cut(&self) -> Cut {
        Cut {
            config: CutConfig {
                ks_n_per_m2: 1e6 * self.ks,
                teeth_in_cut: self.teeth_in_cut,
                overlap: self.overlap,
            },
            chip_angle_rad: self.chip_angle.to_radians(),
            symmetrise: self.symmetrise,
        }
    }
}

/// Where results go.
#[derive(Debug, Clone, Args)]
pub struct OutArgs {
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Write a page with the pictures into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Options of `els model`.
#[derive(Debug, Clone, Args)]
pub struct ElsModelArgs {
    /// A TOML file, or the name of a shipped system.
    #[arg(required_unless_present_any = ["list", "schema"])]
    pub scenario: Option<String>,
    /// Write the receptances at the tool joint as a universal file.
    #[arg(long, value_name = "FILE.uff")]
    pub uff: Option<PathBuf>,
    /// Load of the link there, and in the diagram of limits, N.
    #[arg(long, value_name = "N", default_value_t = 0.0, value_parser = load)]
    pub load: f64,
    /// List the shipped systems.
    #[arg(long)]
    pub list: bool,
    /// Print the JSON schema of a system's file.
    #[arg(long)]
    pub schema: bool,
    /// Where results go.
    #[command(flatten)]
    pub out: OutArgs,
}

/// Options of `els limit`.
#[derive(Debug, Clone, Args)]
pub struct ElsLimitArgs {
    /// Receptances: a universal file (.uff) or a table (.csv).
    #[arg(required_unless_present = "uu")]
    pub input: Option<PathBuf>,
    /// Direct receptance in u, a file of its own.
    #[arg(long, value_name = "FILE")]
    pub uu: Option<PathBuf>,
    /// Response in u to a force in v.
    #[arg(long, value_name = "FILE")]
    pub uv: Option<PathBuf>,
    /// Response in v to a force in u.
    #[arg(long, value_name = "FILE")]
    pub vu: Option<PathBuf>,
    /// Direct receptance in v.
    #[arg(long, value_name = "FILE")]
    pub vv: Option<PathBuf>,
    /// Band in Hz that is looked at [default: all].
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<(f64, f64)>,
    /// Band in Hz below the first mode, for the static stiffness.
    #[arg(long = "static", value_name = "LO:HI", value_parser = band)]
    pub static_band: Option<(f64, f64)>,
    /// What is cut.
    #[command(flatten)]
    pub cut: CutArgs,
    /// Write the receptances in m/N as a universal file.
    #[arg(long, value_name = "FILE.uff")]
    pub uff: Option<PathBuf>,
    /// Where results go.
    #[command(flatten)]
    pub out: OutArgs,
}

/// Options of `els hammer`.
#[derive(Debug, Clone, Args)]
pub struct ElsHammerArgs {
    /// Recording of the force in N.
    pub force: PathBuf,
    /// Recording of the response in SI units.
    pub response: PathBuf,
    /// Channel of the force, counted from 0.
    #[arg(long, default_value_t = 0)]
    pub force_channel: usize,
    /// Channel of the response, counted from 0.
    #[arg(long, default_value_t = 0)]
    pub response_channel: usize,
    /// What the response is.
    #[arg(long, value_enum, default_value_t = Sensor::Acceleration)]
    pub sensor: Sensor,
    /// Band in Hz whose modes are sought.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: (f64, f64),
    /// Band in Hz below the first mode, for the static stiffness.
    #[arg(long = "static", value_name = "LO:HI", value_parser = band)]
    pub static_band: Option<(f64, f64)>,
    /// The tool is the same in v as in the measured direction u, without cross talk;
    /// without this v is rigid.
    #[arg(long)]
    pub round: bool,
    /// What is cut.
    #[command(flatten)]
    pub cut: CutArgs,
    /// Write the receptance as a universal file.
    #[arg(long, value_name = "FILE.uff")]
    pub uff: Option<PathBuf>,
    /// Where results go.
    #[command(flatten)]
    pub out: OutArgs,
}

/// Options of `els fit`.
#[derive(Debug, Clone, Args)]
pub struct ElsFitArgs {
    /// A TOML file, or the name of a shipped system; where the search starts.
    pub scenario: String,
    /// What is sought, separated by commas: joint.N, joint.N.tilt, bearing.N.major,
    /// bearing.N.minor, N counted from 0.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true)]
    pub unknown: Vec<String>,
    /// Load steps: a table angle_deg,load_n,deflection_um.
    #[arg(long, value_name = "FILE.csv")]
    pub loads: Option<PathBuf>,
    /// Receptances at the tool joint: uu, vv and a cross receptance.
    #[arg(long, value_name = "FILE")]
    pub receptance: Option<PathBuf>,
    /// Band in Hz of the receptances that is used [default: all].
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<(f64, f64)>,
    /// Standard deviation of the receptances over their largest value.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = small)]
    pub receptance_sd: f64,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1.0)
}

fn small(text: &str) -> Result<f64, String> {
    within(text, 1e-9, 1.0)
}

fn angle(text: &str) -> Result<f64, String> {
    within(text, -360.0, 360.0)
}

fn load(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1e5)
}

fn stiffness(text: &str) -> Result<f64, String> {
    within(text, 1e-3, 1e5)
}

fn teeth(text: &str) -> Result<f64, String> {
    within(text, 1e-3, 100.0)
}

fn band(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI in Hz, such as 500:3000")?;
    (low >= 0.0 && high > low)
        .then_some((low, high))
        .ok_or("must start at 0 or above, the lower edge first".to_owned())
}
