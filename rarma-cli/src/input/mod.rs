//! Recordings in: WAV, CSV and raw little-endian floats become one [`Recording`].
//!
//! Whole files are read at once (a minute at 48 kHz is 23 MB of `f64`). What is
//! wrong with a file is said in one line that names the file, the place, the
//! reason and what to do ([`InputError`]); what is only odd, such as a recording
//! cut short, is read as far as it goes and listed in [`Recording::notices`].
//!
//! | extension | content | sampling rate |
//! |---|---|---|
//! | `.wav`, `.wave` | PCM 8/16/24/32 bit, float 32/64 bit, any channel count | header, or [`ReadOptions::fs`] |
//! | `.csv`, `.tsv`, `.txt` | `value`, or `time,value[,value…]` | time column, `# fs = 5000`, or [`ReadOptions::fs`] |
//! | `.f32`, `.f64` | little-endian floats, one channel | [`ReadOptions::fs`] |
//! | `.frames` | record of a box with raw samples | the record, or [`ReadOptions::fs`] |

mod circle;
mod circle_write;
mod error;
mod frames;
mod health;
mod load_steps;
mod raw;
mod receptance;
mod structure;
mod table;
mod time;
mod wav;
mod whole;

pub use circle::{Circles, read_circles};
pub use circle_write::circle_file;
pub(crate) use error::system_words;
pub use error::{InputError, Problem};
pub use health::{check, check_size};
pub use load_steps::read_load_steps;
pub use receptance::{Function, Plane, Role, merge, read_receptances, write_uff};
pub use structure::read as read_structure;
pub use whole::{bytes, text};

use crate::raw_streams::Gap;
use std::fs;
use std::path::{Path, PathBuf};

/// What the caller knows or wants about a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// Channel to analyse, counted from 0 (default 0). In a CSV with a time
    /// column, channel 0 is the first column after the time.
    pub channel: usize,
    /// Sampling rate, Hz (default: what the file says). Needed by raw files and
    /// one-column CSV; wins over a WAV header, with a notice; must agree with a
    /// time column within 1 %.
    pub fs: Option<f64>,
    /// Stream of a record of a box, counted from 1 (default: the only one).
    pub stream: Option<usize>,
    /// Refuse sick samples, see [`check`] (default true).
    pub check: bool,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            channel: 0,
            fs: None,
            stream: None,
            check: true,
        }
    }
}

/// One channel of a recording, in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Where it came from.
    pub path: PathBuf,
    /// What it was, for people: `WAV, PCM 16 bit`.
    pub format: String,
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Samples of the chosen channel; integer PCM is scaled to ±1.
    pub samples: Vec<f64>,
    /// Largest value the format can hold: 1 for integer PCM, `None` where
    /// there is no limit (float, CSV).
    pub full_scale: Option<f64>,
    /// Smallest step the format can hold, in the units of `samples`; `None`
    /// where `full_scale` is.
    pub step: Option<f64>,
    /// Channel these samples are from, counted from 0.
    pub channel: usize,
    /// Channels in the file.
    pub channels: usize,
    /// Where samples are missing, zeros standing in their place; of records of a box only.
    pub gaps: Vec<Gap>,
    /// Length, s.
    pub seconds: f64,
    /// Odd, but not fatal: one sentence each.
    pub notices: Vec<String>,
}

impl Recording {
    /// The samples as the box sees them.
    pub fn samples_f32(&self) -> Vec<f32> {
        self.samples.iter().map(|&x| x as f32).collect()
    }
}

/// What a format reader hands back: [`Recording`] without the file's name.
#[derive(Debug)]
struct Decoded {
    format: String,
    fs: f64,
    samples: Vec<f64>,
    step: Option<f64>,
    channels: usize,
    gaps: Vec<Gap>,
    notices: Vec<String>,
}

/// The formats told apart by the extension.
#[derive(Clone, Copy)]
enum Format {
    Wav,
    Table,
    RawF32,
    RawF64,
    Frames,
}

impl Format {
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "wav" | "wave" => Some(Self::Wav),
            "csv" | "tsv" | "txt" => Some(Self::Table),
            "f32" => Some(Self::RawF32),
            "f64" => Some(Self::RawF64),
            "frames" => Some(Self::Frames),
            _ => None,
        }
    }
}

/// Reads one channel of the recording at `path`.
///
/// # Errors
/// The file cannot be opened or is no recording, its structure is broken, the
/// channel or the rate is missing, or (unless `opts.check` is off) its samples
/// are not fit to be analysed. See [`Problem`] for the list.
pub fn read(path: &Path, opts: &ReadOptions) -> Result<Recording, InputError> {
    let fail = |problem, place: &str, what: String, remedy: &str| {
        InputError::new(problem, place, what, remedy).in_file(path)
    };
    if let Some(fs) = opts.fs.filter(|fs| !(fs.is_finite() && *fs > 0.0)) {
        return Err(fail(
            Problem::Rate,
            "option --fs",
            format!("{fs} is not a sampling rate"),
            "give a positive number of hertz",
        ));
    }
    let meta = fs::metadata(path).map_err(|e| InputError::from_io(&e).in_file(path))?;
    if meta.is_dir() {
        return Err(fail(
            Problem::Directory,
            "open",
            "is a directory".into(),
            "name one recording inside it",
        ));
    }
    let Some(format) = Format::of(path) else {
        return Err(fail(
            Problem::Extension,
            "name",
            match path.extension() {
                Some(e) => format!("unknown extension '.{}'", e.to_string_lossy()),
                None => "no extension, so the format is unknown".into(),
            },
            "use .wav, .csv, .f32, .f64 or .frames",
        ));
    };
    let bytes = fs::read(path).map_err(|e| InputError::from_io(&e).in_file(path))?;
    let decoded = decode(format, &bytes, opts).map_err(|e| e.in_file(path))?;
    let recording = Recording {
        path: path.to_path_buf(),
        format: decoded.format,
        fs: decoded.fs,
        full_scale: decoded.step.map(|_| 1.0),
        step: decoded.step,
        channel: opts.channel,
        channels: decoded.channels,
        gaps: decoded.gaps,
        seconds: decoded.samples.len() as f64 / decoded.fs,
        samples: decoded.samples,
        notices: decoded.notices,
    };
    if opts.check {
        check(&recording)?;
    }
    Ok(recording)
}

fn decode(format: Format, bytes: &[u8], opts: &ReadOptions) -> Result<Decoded, InputError> {
    if bytes.is_empty() {
        return Err(InputError::new(
            Problem::Empty,
            "byte 0",
            "the file is empty",
            "record again, or copy it again",
        ));
    }
    if opts.stream.is_some() && !matches!(format, Format::Frames) {
        return Err(InputError::new(
            Problem::Stream,
            "option --stream",
            "only a record of a box has streams",
            "leave it out",
        ));
    }
    match format {
        Format::Wav => wav::decode(bytes, opts),
        Format::Table => table::decode(bytes, opts),
        Format::RawF32 => raw::decode(bytes, opts, raw::Width::F32),
        Format::RawF64 => raw::decode(bytes, opts, raw::Width::F64),
        Format::Frames => frames::decode(bytes, opts),
    }
}

/// The error for a channel the file does not have.
fn no_channel(place: &str, asked: usize, channels: usize) -> InputError {
    let what = match channels {
        1 => format!("channel {asked} asked for, but there is one channel, number 0"),
        n => format!(
            "channel {asked} asked for, but there are {n}, numbered 0 to {}",
            n - 1
        ),
    };
    InputError::new(Problem::Channel, place, what, "choose another --channel")
}
