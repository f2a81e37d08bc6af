//! The command line.

mod act;
mod advise;
mod band;
mod cers;
mod channels;
mod convert;
mod els;
mod examples;
mod files;
mod fit;
mod fleet;
mod gateway;
mod ldbb;
mod listen;
mod machine;
mod manual;
mod note;
mod numbers;
mod psd;
mod screen;
mod sensor_box;
mod virtual_machine;

pub use act::{ActArgs, USUAL_LIMITS, Which};
pub use advise::{AdviseArgs, USUAL_REACH};
pub use band::{BandArgs, BandChoice, FULL_UP_TO_HZ};
pub use cers::{CersAnalyseArgs, CersCommand, CersRunArgs, KindArg, ReadingArgs};
pub use channels::{ChannelArgs, ChannelSet};
pub use convert::ConvertArgs;
pub use els::{
    CutArgs, ElsCommand, ElsFitArgs, ElsHammerArgs, ElsLimitArgs, ElsModelArgs, OutArgs,
};
pub use fit::{Detrend, IdentifyArgs, Method, OrderArgs};
pub use fleet::{
    PlantArgs, Question, SplitBy, StoreAddArgs, StoreArgs, StoreAskArgs, StoreCommand,
    StoreExportArgs, StoreReceiveArgs, StoreShowArgs, StoreThinArgs, TableArgs, TrendsArgs,
};
pub use gateway::GatewayArgs;
pub use ldbb::{KnownArgs, LdbbAnalyseArgs, LdbbCommand, LdbbCompareArgs, LdbbRunArgs};
pub use listen::ListenArgs;
pub use machine::MachineArgs;
pub use manual::{CompletionsArgs, ManArgs};
pub use note::by_key as notes_by_key;
pub use numbers::NumbersArgs;
pub use psd::{Criterion, PsdArgs, PsdMethod};
pub use screen::ScreenArg;
pub use sensor_box::{BoxArgs, ConnectArgs, DecodeArgs};
pub use virtual_machine::{ChooseOrderArgs, LobesArgs, PopulationArgs, SimulateArgs, SweepArgs};

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use rarma_core::condition::Band;
use rarma_recordings::input::{Known, RATES_HZ, Raw};
use std::ffi::OsString;
use std::path::PathBuf;

/// Listens to machine tools: operational damping of a cut, at every sample.
#[derive(Debug, Parser)]
#[command(name = "rarma", version, about = "Listens to machine tools: the operational damping of a cut, at every sample", after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// No notices and no progress on standard error; errors are told.
    #[arg(long, global = true)]
    pub quiet: bool,
}

impl Cli {
    /// The command line, with examples under the help of each command.
    pub fn command_line() -> clap::Command {
        examples::with_examples(Self::command())
    }

    /// What was written on the command line.
    ///
    /// # Errors
    /// It is wrong, or asks for help or the version: print it.
    pub fn read<W: Into<OsString> + Clone>(
        words: impl IntoIterator<Item = W>,
    ) -> Result<Self, clap::Error> {
        let mut command = Self::command_line();
        let said = command.try_get_matches_from_mut(words)?;
        Self::from_arg_matches(&said).map_err(|why| why.format(&mut command))
    }
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 chatter was found (monitor, listen, advise, act, target, box) or outputs were switched off (box); \
2 wrong usage; 3 bad input, with one line naming file, place and reason; \
4 something else is missing or failed, such as a write to a full disk, or a box that went away (connect, decode); \
5 a silent input, 6 a sound card that went away (listen); \
141 whoever read standard output has gone away.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Listen to a recording and say when it chatters.
    ///
    /// Exit code 1 if chatter was found.
    Monitor(MonitorArgs),
    /// Listen to a sound card, until Ctrl-C or for --seconds; on a terminal on a live screen.
    ///
    /// Exit code 1 if chatter was found, 5 if the input is silent, 6 if the card went away. Level
    /// and clipping are checked first. Switch automatic gain and noise suppression off: they change
    /// what is measured. Needs a program that was built with `--features sound-card`.
    #[command(mut_args(listen::sound_card))]
    Listen(ListenArgs),
    /// The same through the firmware image on the emulated chip.
    ///
    /// Exit code 1 if chatter was found. Builds the image first if it must.
    #[command(mut_args(one_channel))]
    Target(MonitorArgs),
    /// Listen as `monitor` does, then say which speed to turn instead.
    ///
    /// Exit code 1 if chatter was found.
    #[command(mut_args(one_recording))]
    Advise(AdviseArgs),
    /// Listen as `monitor` does, and order another speed of the machine's controller where it
    /// chatters.
    ///
    /// Exit code 1 if chatter was found.
    #[command(mut_args(one_recording))]
    Act(ActArgs),
    /// Fit one ARMA model to a whole recording.
    Identify(IdentifyArgs),
    /// Fit candidate orders and say which a criterion chooses.
    Order(OrderArgs),
    /// Power spectral density of a recording.
    Psd(PsdArgs),
    /// A recording to a format of other programs: CSV, universal file, MATLAB.
    Convert(ConvertArgs),
    /// Stability lobes of scenarios: limit depth and chatter frequency over speed.
    Lobes(LobesArgs),
    /// Cut virtually: a scenario to a recording and what is true of it.
    Simulate(SimulateArgs),
    /// Find the model order that reads a virtual cut right, and write it down.
    ChooseOrder(ChooseOrderArgs),
    /// One virtual cut at many depths: true damping, what is read, and the surface.
    Sweep(SweepArgs),
    /// Judge the monitor, and simpler detectors beside it, on machines drawn at random.
    Population(PopulationArgs),
    /// The elastic linked system: receptances in any direction, limits all round, the
    /// computational model.
    #[command(subcommand)]
    Els(ElsCommand),
    /// The loaded double ball bar: machine errors under load, stiffness in every direction.
    #[command(subcommand)]
    Ldbb(LdbbCommand),
    /// The exciter: responses, modes and tracks of a turning spindle.
    #[command(subcommand)]
    Cers(CersCommand),
    /// Run the whole box, its firmware on simulated hardware.
    ///
    /// Exit code 1 if chatter was called or a fault switched outputs off.
    Box(BoxArgs),
    /// Decode frames of a box from a file, standard input, a serial port or a socket.
    Decode(DecodeArgs),
    /// Talk to a box: live screen, commands, settings, records.
    ///
    /// Exit code 4 if the box goes away or is none.
    Connect(ConnectArgs),
    /// Records of many machines over months: taken in, asked, thinned.
    ///
    /// Needs a program that was built with `--features fleet`.
    #[command(subcommand)]
    Store(StoreCommand),
    /// Which machines have changed beyond their uncertainty, since when, and what it does to the limit.
    ///
    /// Needs a program that was built with `--features fleet`.
    Trends(TrendsArgs),
    /// A simulated plant: records of many machines over months, and the truth.
    ///
    /// Needs a program that was built with `--features fleet`.
    Plant(PlantArgs),
    /// Many boxes on one side, the plant's broker on the other: records, live values, speeds.
    ///
    /// Until Ctrl-C; with recordings only, until they have ended and are at the store. Needs a program
    /// that was built with `--features fleet`.
    Gateway(GatewayArgs),
    /// Let the virtual machine tool cut into chatter and monitor it through the
    /// simulated hardware.
    Demo(DemoArgs),
    /// Completions of this command line for a shell, on standard output.
    Completions(CompletionsArgs),
    /// Pages for `man`, one for each command.
    Man(ManArgs),
}

/// What a file is.
#[derive(Debug, Clone, Args)]
pub struct InputArgs {
    /// WAV (PCM 8/16/24/32, float), .m4a, .mp4, .mov, .mp3, .flac, .ogg, CSV, .uff, .tdms, or raw .f32/.f64
    /// (little endian, with --fs); `-` for WAV from standard input, or raw samples with --raw.
    pub input: PathBuf,
    /// Channel, counted from 0.
    #[arg(long, default_value_t = 0)]
    pub channel: usize,
    /// Sampling rate in Hz, where the file does not say it.
    #[arg(long, value_parser = rate)]
    pub fs: Option<f64>,
    /// Stream of a record of a box (.frames) that holds several, counted from 1.
    #[arg(long, value_name = "N", value_parser = sensor_box::stream)]
    pub stream: Option<usize>,
    /// The input is samples without a header, one channel, little endian.
    #[arg(long, value_enum, requires = "fs")]
    pub raw: Option<RawArg>,
}

impl InputArgs {
    /// What the caller knows of the file.
    pub fn known(&self) -> Known {
        Known {
            fs: self.fs,
            stream: self.stream,
        }
    }

    /// What comes without a header.
    pub fn raw(&self) -> Option<Raw> {
        self.raw.map(|raw| match raw {
            RawArg::S16 => Raw::S16,
            RawArg::F32 => Raw::F32,
        })
    }
}

/// Samples without a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RawArg {
    /// 16 bit integers.
    S16,
    /// 32 bit floats.
    F32,
}

/// Options of `monitor` and `target`.
#[derive(Debug, Clone, Args)]
pub struct MonitorArgs {
    /// The recording.
    #[command(flatten)]
    pub input: InputArgs,
    /// More recordings, each listened to by itself with the same options: with --report a page
    /// for each and one that compares them.
    #[arg(value_name = "MORE")]
    pub more: Vec<PathBuf>,
    /// Model order; the box has 2,1 2,2 4,3 4,4 6,5 6,6 8,7 8,8.
    #[arg(long, value_name = "P,Q", default_value = "8,7", value_parser = any_order)]
    pub order: (usize, usize),
    /// Spindle speed in 1/min: lines on its multiples count as forced, and are taken out of
    /// the signal where the sound shows them.
    #[arg(long, value_parser = positive)]
    pub rpm: Option<f64>,
    /// Teeth on the cutter.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub teeth: Option<u32>,
    /// Band in Hz that is analysed [default: 300:2500, lower for slow recordings].
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Damping ratio below which a mode counts as undamped.
    #[arg(long, value_name = "ZETA", default_value_t = 0.01, value_parser = threshold)]
    pub threshold: f64,
    /// Seconds that are known to be idle; without it idle is found.
    #[arg(long, value_name = "FROM:TO", value_parser = stretch)]
    pub idle: Option<(f64, f64)>,
    /// Second channel of the same file, counted from 0: two sensors, one verdict.
    #[arg(long, value_name = "CHANNEL")]
    pub second: Option<usize>,
    /// Channel of the same file, counted from 0, that holds the pulses of a tacho: its
    /// speed goes before --rpm.
    #[arg(long, value_name = "CHANNEL")]
    pub tacho: Option<usize>,
    /// Pulses of the tacho a turn.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tacho",
          value_parser = clap::value_parser!(u32).range(1..=100))]
    pub pulses: u32,
    /// Speeds as a control tells them, lines of time in s and 1/min: a file, a pipe, or - for
    /// standard input. Each counts from its time on, in place of --rpm.
    #[arg(long, value_name = "FILE")]
    pub speed_from: Option<PathBuf>,
    /// Modes of the structure at rest (JSON of `identify`, or CSV with columns
    /// f,f_sd,zeta,zeta_sd): what the process adds to their damping is told.
    #[arg(long, value_name = "FILE")]
    pub structure: Option<PathBuf>,
    /// The sampler has no anti-alias filter: multiples of the speed may lie folded anywhere.
    #[arg(long)]
    pub aliased: bool,
    /// Numbers of the verdict.
    #[command(flatten)]
    pub numbers: NumbersArgs,
    /// Seconds between two lines, 0.0001 to 3600.
    #[arg(long, value_name = "SECONDS", default_value_t = USUAL_EVERY_S, value_parser = every)]
    pub every: f64,
    /// One JSON object a line on standard output, the summary last.
    #[arg(long)]
    pub json: bool,
    /// Show a live screen [default: auto]; `on` plays a file at the speed it was recorded with.
    #[arg(long, value_enum, value_name = "WHEN")]
    pub screen: Option<ScreenArg>,
    /// Write a page with pictures into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Seconds that the page's pictures show; its words and tables are of all of the recording
    /// [default: all].
    #[arg(long, value_name = "FROM:TO", value_parser = stretch, requires = "report")]
    pub window: Option<(f64, f64)>,
    /// What is to be remembered of the recording, such as machine=, tool= or operator=, again
    /// for more: on the page and in the summary.
    #[arg(long = "note", value_name = "KEY=VALUE", value_parser = note::note)]
    pub notes: Vec<(String, String)>,
}

/// Advice and orders are for one recording: more are refused by name, and not offered.
fn one_recording(option: clap::Arg) -> clap::Arg {
    match option.get_id().as_str() {
        "more" => option.hide(true),
        "screen" => screen::none(option),
        _ => option,
    }
}

/// A job for the box names one channel: what needs two is refused by name, and not offered.
fn one_channel(option: clap::Arg) -> clap::Arg {
    let needs_two =
        ["more", "second", "tacho", "pulses", "speed_from"].contains(&option.get_id().as_str());
    if option.get_id() == "screen" {
        return screen::none(option);
    }
    option.hide(needs_two)
}

/// Seconds between two lines where nobody says so.
pub const USUAL_EVERY_S: f64 = 0.01;

/// Options of `demo`.
#[derive(Debug, Clone, Args)]
pub struct DemoArgs {
    /// Folder for the page and the telemetry.
    #[arg(long, default_value = "target/demo")]
    pub out: PathBuf,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Nearer to 0 nothing is: it would only leave the range of numbers further on.
const TINY: f64 = 1e-30;

fn number(text: &str) -> Result<f64, String> {
    let x: f64 = text
        .trim()
        .parse()
        .map_err(|_| format!("`{text}` is not a number"))?;
    if !x.is_finite() {
        return Err(format!("`{text}` is not finite"));
    }
    if x != 0.0 && x.abs() < TINY {
        return Err(format!("`{text}` is too near to 0 (write 0)"));
    }
    Ok(x)
}

fn within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let x = number(text)?;
    (low..=high)
        .contains(&x)
        .then_some(x)
        .ok_or(format!("must lie between {low} and {high}"))
}

fn positive(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    (x > 0.0).then_some(x).ok_or("must be above 0".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, *RATES_HZ.start(), *RATES_HZ.end())
}

fn every(text: &str) -> Result<f64, String> {
    within(text, 1e-4, 3600.0)
}

fn threshold(text: &str) -> Result<f64, String> {
    within(text, 0.0005, 0.2)
}

fn forgetting(text: &str) -> Result<f64, String> {
    within(text, 0.9, 1.0)
}

fn random_walk(text: &str) -> Result<f64, String> {
    within(text, 0.0, 0.01)
}

fn pair(text: &str, separator: char, form: &str) -> Result<(f64, f64), String> {
    let (a, b) = text
        .split_once(separator)
        .ok_or(format!("must have the form {form}"))?;
    Ok((number(a)?, number(b)?))
}

fn band(text: &str) -> Result<Band, String> {
    let (low_hz, high_hz) = pair(text, ':', "LO:HI, such as 300:2500")?;
    Ok(Band { low_hz, high_hz })
}

fn stretch(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = pair(text, ':', "FROM:TO in seconds, such as 0:1.5")?;
    (from >= 0.0 && to > from)
        .then_some((from, to))
        .ok_or("must start at 0 or later and end after it starts".to_owned())
}

fn any_order(text: &str) -> Result<(usize, usize), String> {
    order_up_to(text, 30)
}

/// Whether the method goes as far is checked when it is known.
fn long_order(text: &str) -> Result<(usize, usize), String> {
    order_up_to(text, 60)
}

fn order_up_to(text: &str, most: usize) -> Result<(usize, usize), String> {
    let form =
        || format!("must have the form P,Q, P from 0 to {most}, Q from 0 to 30, such as 8,7");
    let (p, q) = text.split_once(',').ok_or_else(form)?;
    let one = |x: &str, most: usize| {
        let n = x.trim().parse().ok();
        n.filter(|n| *n <= most).ok_or_else(form)
    };
    Ok((one(p, most)?, one(q, 30)?))
}
