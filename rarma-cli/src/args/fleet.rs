//! Options of `store`, `trends` and `plant`.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Where the store is.
#[derive(Debug, Clone, Args)]
pub struct StoreArgs {
    /// A file, which is made where it is not there; or postgres://USER:PASSWORD@HOST/DATABASE,
    /// clickhouse://USER:PASSWORD@HOST:8123/DATABASE. To another computer with ?sslrootcert=FILE behind it, the
    /// certificates that are trusted, or ?sslmode=disable.
    #[arg(long, value_name = "STORE")]
    pub store: String,
}

/// Records kept, asked, thinned.
#[derive(Debug, Clone, Subcommand)]
pub enum StoreCommand {
    /// Take records, or what other commands print with `--json`.
    ///
    /// Each record is taken once, in whatever order and however often it comes. A line that is no record is
    /// told and passed over; exit code 3 then.
    Add(StoreAddArgs),
    /// Take records off the plant's broker, until Ctrl-C.
    ///
    /// Gateways are told what is stored and keep the rest: a store that was away gets what it has missed.
    Receive(StoreReceiveArgs),
    /// What is there: kinds and machines.
    Show(StoreShowArgs),
    /// Alarms, advice and states by machine, tool, operator, speed or month.
    Ask(StoreAskArgs),
    /// The records as they came, one JSON object a line, by time.
    Export(StoreExportArgs),
    /// Sum verdicts before a day by machine, day and state, and take them out.
    ///
    /// Everything else is kept for ever. What comes later of before that day is left out and counted.
    Thin(StoreThinArgs),
}

/// Options of `store add`.
#[derive(Debug, Clone, Args)]
pub struct StoreAddArgs {
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// Records, one a line (`-`: standard input); the journal of a gateway that does not run; a log of `act`, which needs
    /// --machine; or the JSON of `ldbb run`, `ldbb analyse`, `cers run`, `cers analyse`, `els limit`, `monitor`, which need
    /// --machine and --time.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Of which machine.
    #[arg(long)]
    pub machine: Option<String>,
    /// When: of a recording its first sample. As 2026-03-01T12:00:00Z, or with another offset.
    #[arg(long)]
    pub time: Option<String>,
    /// Who says so, as the record's `box`.
    #[arg(long, value_name = "NAME", default_value = "file")]
    pub sender: String,
    /// Tool in the spindle.
    #[arg(long)]
    pub tool: Option<String>,
    /// Who ran the machine; a pseudonym does as well.
    #[arg(long)]
    pub operator: Option<String>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Options of `store receive`.
#[derive(Debug, Clone, Args)]
pub struct StoreReceiveArgs {
    /// The host's file (TOML): group, name, broker; docs/plant.md has an example.
    pub file: PathBuf,
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// Seconds between two lines that tell how it stands; none while nothing comes.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = super::every)]
    pub every: f64,
    /// One JSON object a line on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Options of `store show`.
#[derive(Debug, Clone, Args)]
pub struct StoreShowArgs {
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Question {
    /// How many alarms, and how long they stood.
    Alarms,
    /// How often advice was followed, and helped; and how often the chatter ended without.
    Advice,
    /// Seconds in each state, by machine and month.
    States,
    /// Every number of every capability, with its deviation.
    Readings,
}

/// By what an answer is split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SplitBy {
    /// Machine.
    Machine,
    /// Tool.
    Tool,
    /// Operator.
    Operator,
    /// Spindle speed, in steps of 500 1/min.
    Speed,
    /// Month.
    Month,
}

/// Options of `store ask`.
#[derive(Debug, Clone, Args)]
pub struct StoreAskArgs {
    /// What.
    pub question: Question,
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// By what; states are always by machine and month, readings one by one.
    #[arg(long, value_enum, default_value_t = SplitBy::Machine)]
    pub by: SplitBy,
    /// First month, such as 2026-03.
    #[arg(long, value_name = "MONTH", value_parser = month)]
    pub from: Option<i64>,
    /// Last month, included.
    #[arg(long, value_name = "MONTH", value_parser = month)]
    pub to: Option<i64>,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// The answer.
    #[command(flatten)]
    pub table: TableArgs,
}

/// A table for other programs.
#[derive(Debug, Clone, Args)]
pub struct TableArgs {
    /// The table as text.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// The table in columns, for pandas, DuckDB, ClickHouse and others.
    #[arg(long, value_name = "FILE")]
    pub parquet: Option<PathBuf>,
}

/// Options of `store export`.
#[derive(Debug, Clone, Args)]
pub struct StoreExportArgs {
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// Of one machine.
    #[arg(long)]
    pub machine: Option<String>,
    /// Into a file instead of standard output.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Options of `store thin`.
#[derive(Debug, Clone, Args)]
pub struct StoreThinArgs {
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// The first day that is kept whole, such as 2026-03-01 (UTC). Choose one before which every box has
    /// delivered.
    #[arg(long, value_name = "DAY")]
    pub before: String,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

/// Options of `trends`.
#[derive(Debug, Clone, Args)]
pub struct TrendsArgs {
    /// The store.
    #[command(flatten)]
    pub store: StoreArgs,
    /// False changes of a machine in a year, at most.
    #[arg(long, value_name = "N", default_value_t = 0.2, value_parser = rate)]
    pub false_per_year: f64,
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// The changes.
    #[command(flatten)]
    pub table: TableArgs,
    /// A page with pictures.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Options of `plant`.
#[derive(Debug, Clone, Args)]
pub struct PlantArgs {
    /// Machines.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=5000))]
    pub machines: u32,
    /// Months of 30.4 days.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=120))]
    pub months: u32,
    /// The same seed gives the same plant.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// First day.
    #[arg(long, value_name = "DAY", default_value = "2025-01-01")]
    pub start: String,
    /// Tests only: no verdicts, alarms and advice.
    #[arg(long)]
    pub tests_only: bool,
    /// Where to: records.jsonl in the order of arrival, and truth.json.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// A month as a number: 2026-03 is 202603.
fn month(text: &str) -> Result<i64, String> {
    let parsed = text.split_once('-').and_then(|(year, month)| {
        let (year, month) = (year.parse::<i64>().ok()?, month.parse::<i64>().ok()?);
        ((2000..2200).contains(&year) && (1..=12).contains(&month)).then_some(year * 100 + month)
    });
    parsed.ok_or_else(|| "must be a month such as 2026-03".to_owned())
}

/// Above 0, at most 1.
fn rate(text: &str) -> Result<f64, String> {
    let n: Option<f64> = text.parse().ok();
    n.filter(|&n| n > 0.0 && n <= 1.0)
        .ok_or_else(|| "must be above 0 and at most 1".to_owned())
}
