//! Options of the commands around the virtual machine tool.

use super::NumbersArgs;
use super::{any_order, pair, within};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Options of `lobes`.
#[derive(Debug, Clone, Args)]
pub struct LobesArgs {
    /// TOML files or names of shipped scenarios; several are overlaid.
    #[arg(required = true, value_name = "SCENARIO")]
    pub scenarios: Vec<String>,
    /// Spindle speeds in 1/min [default: half to one and a half times the scenario's].
    #[arg(long, value_name = "LO:HI", value_parser = speeds)]
    pub rpm: Option<(f64, f64)>,
    /// Number of speeds.
    #[arg(long, default_value_t = 121,
          value_parser = |text: &str| text.parse::<usize>().ok().filter(|n| (1..=20_000).contains(n)).ok_or("must lie between 1 and 20000"))]
    pub speeds: usize,
    /// Largest depth in mm [default: twice the scenario's].
    #[arg(long, value_name = "MM", value_parser = depth)]
    pub max_depth_mm: Option<f64>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Write a page with the pictures into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Options of `choose-order`.
#[derive(Debug, Clone, Args)]
pub struct ChooseOrderArgs {
    /// A TOML file, or the name of a shipped scenario.
    pub scenario: String,
    /// Depth in mm [default: the scenario's largest, or 0.8 of the limit below it].
    #[arg(long, value_name = "MM", value_parser = depth)]
    pub depth_mm: Option<f64>,
    /// Largest p.
    #[arg(long, value_name = "P", default_value_t = 8,
          value_parser = |text: &str| text.parse::<usize>().ok().filter(|p| (2..=30).contains(p)).ok_or("must lie between 2 and 30"))]
    pub max: usize,
    /// Seconds of each run.
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, value_parser = length)]
    pub seconds: f64,
    /// Runs with different noise.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub runs: u32,
    /// Seed of the first run.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Compare the candidates with the forced vibration in; without this the cut
    /// without noise is subtracted.
    #[arg(long)]
    pub with_forced: bool,
    /// Write the box's settings: .json, or postcard with any other ending.
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Options of `sweep`.
#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// TOML files or names of shipped scenarios; several are overlaid.
    #[arg(required = true, value_name = "SCENARIO")]
    pub scenarios: Vec<String>,
    /// Depths in mm.
    #[arg(long, value_name = "LO:HI", value_parser = depths)]
    pub depth_mm: (f64, f64),
    /// Number of depths.
    #[arg(long, default_value_t = 25,
          value_parser = |text: &str| text.parse::<usize>().ok().filter(|n| (1..=5000).contains(n)).ok_or("must lie between 1 and 5000"))]
    pub steps: usize,
    /// Spindle speeds in 1/min instead of the scenario's, separated by commas.
    #[arg(long, value_name = "RPM", value_delimiter = ',', value_parser = speed)]
    pub rpm: Vec<f64>,
    /// Order of the model that reads the damping, 0 to 30 each.
    #[arg(long, value_name = "P,Q", default_value = "6,5", value_parser = any_order)]
    pub order: (usize, usize),
    /// Seconds of sound at each depth.
    #[arg(long, value_name = "SECONDS", default_value_t = 4.0, value_parser = length)]
    pub seconds: f64,
    /// Seed of everything random.
    #[arg(long)]
    pub seed: Option<u64>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Write a page with the pictures into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Options of `simulate`.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// A TOML file, or the name of a shipped scenario.
    pub scenario: Option<String>,
    /// Recording to write (WAV).
    #[arg(long, value_name = "FILE.wav")]
    pub out: Option<PathBuf>,
    /// What is true of it (JSON).
    #[arg(long, value_name = "FILE.json")]
    pub truth: Option<PathBuf>,
    /// Seed of everything random; wins over the file's.
    #[arg(long)]
    pub seed: Option<u64>,
    /// The truth on standard output as JSON.
    #[arg(long)]
    pub json: bool,
    /// List the shipped scenarios.
    #[arg(long)]
    pub list: bool,
    /// Print the JSON schema of a scenario file.
    #[arg(long)]
    pub schema: bool,
}

fn length(text: &str) -> Result<f64, String> {
    within(text, 0.5, 600.0)
}

fn depths(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI in mm, such as 0.05:1")?;
    (low >= 1e-6 && high >= low && high <= 200.0)
        .then_some((low, high))
        .ok_or("must lie between 1e-6 and 200, the lower depth first".to_owned())
}

fn depth(text: &str) -> Result<f64, String> {
    within(text, 1e-6, 400.0)
}

fn speed(text: &str) -> Result<f64, String> {
    within(text, 60.0, 200_000.0)
}

fn speeds(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = pair(text, ':', "LO:HI in 1/min, such as 5000:25000")?;
    (low >= 60.0 && high >= low && high <= 200_000.0)
        .then_some((low, high))
        .ok_or("must lie between 60 and 200000, the lower speed first".to_owned())
}

/// How the speed is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Told {
    /// To the last digit.
    Exact,
    /// Up to 1 % off.
    #[value(name = "1")]
    One,
    /// 3 % too high or too low.
    #[value(name = "3")]
    Three,
    /// That of another job: 0.6 to 1.6 times, at least 10 % off.
    Wrong,
    /// Not at all.
    None,
    /// As the control knows it, ten times a second, a little late.
    Live,
}

impl From<Told> for rarma_population::Told {
    fn from(told: Told) -> Self {
        match told {
            Told::Exact => Self::Exact,
            Told::One => Self::One,
            Told::Three => Self::Three,
            Told::Wrong => Self::Wrong,
            Told::None => Self::None,
            Told::Live => Self::Live,
        }
    }
}

/// What a box has heard before a cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Before {
    /// The room, for 4 s.
    Air,
    /// The room, and something that is hit, 30 dB louder than the cut at its peak.
    Knock,
    /// The room, and 3 s of compressed air, 15 dB louder than the cut.
    Jet,
    /// A dark hall for 5 s, then the machine is switched on.
    Night,
    /// The same cut, and the room for 2 s.
    Cut,
}

impl From<Before> for rarma_plants::population::before::Before {
    fn from(before: Before) -> Self {
        match before {
            Before::Air => Self::Air,
            Before::Knock => Self::Knock,
            Before::Jet => Self::Jet,
            Before::Night => Self::Night,
            Before::Cut => Self::Cut,
        }
    }
}

/// Options of `population`.
#[derive(Debug, Clone, Args)]
pub struct PopulationArgs {
    /// First seed and the one after the last.
    #[arg(long, value_name = "A:B", default_value = "0:100", value_parser = seeds)]
    pub seeds: (u64, u64),
    /// How the speed is told, one or more separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "1,3,none")]
    pub told: Vec<Told>,
    /// Who is judged, separated by commas: monitor, verdict, plain, bare-damping, or none.
    #[arg(long, default_value = "monitor,verdict,plain,bare-damping", value_parser = detectors)]
    pub detectors: Chosen,
    /// Numbers of the verdict.
    #[command(flatten)]
    pub numbers: NumbersArgs,
    /// Half and double of every number of the verdict, each alone, with the first way the
    /// speed is told.
    #[arg(long)]
    pub sensitivity: bool,
    /// How often the monitor answers otherwise where the recording begins later, is quieter, has
    /// noise 60 dB below it, or the order is another, with the first way the speed is told.
    #[arg(long)]
    pub changed: bool,
    /// What the box has heard before each cut; times are told from the cut's first sample on.
    #[arg(long, value_enum, conflicts_with_all = ["changed", "sensitivity"])]
    pub heard_before: Option<Before>,
    /// The monitor at several damping thresholds, not at its usual one only.
    #[arg(long)]
    pub curve: bool,
    /// One JSON object a cut on standard output, the summary last.
    #[arg(long)]
    pub json: bool,
    /// Write a page with curves and tables into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Write every cut as a WAV into this folder, and labels.json with what is true of it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Detectors by their places.
#[derive(Debug, Clone)]
pub struct Chosen(pub Vec<usize>);

fn detectors(text: &str) -> Result<Chosen, String> {
    if text == "none" {
        return Ok(Chosen(Vec::new()));
    }
    let known = |name: &str| {
        rarma_population::detectors::named(name).ok_or_else(|| format!("{name}: no such detector"))
    };
    let mut places: Vec<usize> = text.split(',').map(known).collect::<Result<_, _>>()?;
    places.sort_unstable();
    places.dedup();
    Ok(Chosen(places))
}

/// Most cuts in one run.
const MOST_CUTS: u64 = 1_000_000;

fn seeds(text: &str) -> Result<(u64, u64), String> {
    let ends = text
        .split_once(':')
        .and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match ends {
        Some((from, to)) if from < to && to - from <= MOST_CUTS => Ok((from, to)),
        Some(_) => Err(format!(
            "the second must be above the first, by at most {MOST_CUTS}"
        )),
        None => Err("must be two whole numbers such as 0:100".to_owned()),
    }
}
