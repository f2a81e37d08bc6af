//! Recordings in: WAV, CSV, raw little-endian floats and what phones write become one
//! [`Recording`].
//!
//! A [`Stream`] gives a recording block by block, of any length and from a pipe as well;
//! [`read`] takes one channel whole (a minute at 48 kHz is 23 MB of `f64`). What is
//! wrong with a file is said in one line that names the file, the place, the
//! reason and what to do ([`InputError`]); what is only odd, such as a recording
//! cut short, is read as far as it goes and listed in [`Recording::notices`].
//!
//! | extension | content | sampling rate |
//! |---|---|---|
//! | `.wav`, `.wave` | PCM 8/16/24/32 bit, float 32/64 bit, any channel count | header, or [`ReadOptions::fs`] |
//! | `.csv`, `.tsv`, `.txt` | `value`, or `time,value[,value…]` | time column, `# fs = 5000`, or [`ReadOptions::fs`] |
//! | `.f32`, `.f64` | little-endian floats, one channel | [`ReadOptions::fs`] |
//! | `.m4a`, `.mp4`, `.mov` | AAC-LC, MP3 or FLAC in MPEG-4, of a video its sound | header, or [`ReadOptions::fs`] |
//! | `.mp3`, `.flac`, `.ogg`, `.oga` | MP3, FLAC, Ogg Vorbis or Ogg FLAC | header, or [`ReadOptions::fs`] |
//! | `.uff`, `.unv`, `.bun` | universal file, datasets 58 and 58b over time, each a channel | its step, or [`ReadOptions::fs`] |
//! | `.tdms` | TDMS of National Instruments, each channel of numbers over time | its `wf_increment`, or [`ReadOptions::fs`] |
//! | `.frames` | record of a box with raw samples | the record, or [`ReadOptions::fs`] |
//!
//! Those of phones need the feature `codecs`, which is on unless switched off.

mod blocks;
mod bytes;
mod circle;
mod circle_data;
mod circle_write;
#[cfg(feature = "codecs")]
mod compressed;
mod content;
mod cuts;
mod error;
mod frames;
mod health;
mod load_steps;
mod named;
mod raw;
mod receptance;
mod speed;
mod stream;
mod structure;
mod table;
mod tdms;
mod time;
mod uff_time;
mod until;
mod wav;
mod whole;

pub use blocks::{Begin, Blocks, End, Known, Raw};
pub use circle::{Circles, read_circles};
pub use circle_data::{Conditions, RunData, Static};
pub use circle_write::circle_file;
pub use cuts::{CUTS_HEADER, CutRow, has_header as has_cuts_header, read as read_cuts};
pub use error::{InputError, Problem};
pub use health::{FileHealth, check, check_size};
pub use load_steps::{LoadStep, read_load_steps};
pub(crate) use receptance::exponent;
pub use receptance::{Function, Plane, Role, merge, read_receptances, write_uff};
pub use speed::Speeds;
pub use stream::Stream;
pub use structure::read as read_structure;
pub use time::RATES_HZ;
pub use until::{Stall, Until};
pub use whole::{bytes, text};

use crate::raw_streams::Gap;
use content::Content;
use std::path::{Path, PathBuf};

/// What the caller knows or wants about a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// Channel to analyse, counted from 0 (default 0). In a CSV with a time
    /// column, channel 0 is the first column after the time.
    pub channel: usize,
    /// Sampling rate, Hz (default: what the file says). Needed by raw files and
    /// one-column CSV; wins over a header, with a notice; must agree with a
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
    /// Unit of `samples`, such as `m/s^2`, where the file says it.
    pub unit: Option<String>,
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
    /// Where samples are missing, zeros standing in their place: in records of a box, and in
    /// compressed files that are damaged.
    pub gaps: Vec<Gap>,
    /// Length, s.
    pub seconds: f64,
    /// Odd, but not fatal: one sentence each.
    pub notices: Vec<String>,
}

impl Recording {
    /// Samples that are in memory already; `name` is what messages call them.
    pub fn in_memory(name: &str, samples: Vec<f64>, fs: f64) -> Self {
        Self {
            path: name.into(),
            format: "memory".to_owned(),
            fs,
            seconds: samples.len() as f64 / fs,
            samples,
            unit: None,
            full_scale: None,
            step: None,
            channel: 0,
            channels: 1,
            gaps: Vec::new(),
            notices: Vec::new(),
        }
    }

    /// The samples as the box sees them.
    pub fn samples_f32(&self) -> Vec<f32> {
        self.samples.iter().map(|&x| x as f32).collect()
    }
}

/// The formats told apart by the extension.
#[derive(Clone, Copy)]
enum Format {
    Wav,
    Table,
    RawF32,
    RawF64,
    RawS16,
    Frames,
    Uff,
    Tdms,
    /// Named one of these kinds of compressed files.
    Compressed(Content),
}

impl Format {
    fn of(path: &Path) -> Result<Self, InputError> {
        let extension = path.extension().map(|e| e.to_string_lossy());
        match extension.as_deref().map(str::to_ascii_lowercase).as_deref() {
            Some("wav" | "wave") => Ok(Self::Wav),
            Some("csv" | "tsv" | "txt") => Ok(Self::Table),
            Some("f32") => Ok(Self::RawF32),
            Some("f64") => Ok(Self::RawF64),
            Some("frames") => Ok(Self::Frames),
            Some("uff" | "unv" | "bun") => Ok(Self::Uff),
            Some("tdms") => Ok(Self::Tdms),
            Some("m4a" | "mp4" | "mov") => Ok(Self::Compressed(Content::Mp4)),
            Some("mp3") => Ok(Self::Compressed(Content::Mp3)),
            Some("flac") => Ok(Self::Compressed(Content::Flac)),
            Some("ogg" | "oga") => Ok(Self::Compressed(Content::Ogg)),
            _ => Err(InputError::new(
                Problem::Extension,
                "name",
                match extension {
                    Some(e) => format!("unknown extension '.{e}'"),
                    None => "no extension, so the format is unknown".into(),
                },
                "use .wav, .flac, .m4a, .mp4, .mov, .mp3, .ogg, .csv, .uff, .tdms, .f32, .f64 or .frames",
            )),
        }
    }
}

/// Reads one channel of the recording at `path`, `-` being standard input.
///
/// # Errors
/// The file cannot be opened or is no recording, its structure is broken, the
/// channel or the rate is missing, or (unless `opts.check` is off) its samples
/// are not fit to be analysed. See [`Problem`] for the list.
pub fn read(path: &Path, opts: &ReadOptions) -> Result<Recording, InputError> {
    read_raw(path, opts, None)
}

/// [`read`], where `raw` says what comes without a header.
///
/// # Errors
/// See [`read`].
pub fn read_raw(
    path: &Path,
    opts: &ReadOptions,
    raw: Option<Raw>,
) -> Result<Recording, InputError> {
    let mut one = read_channels(path, opts, raw, Some(&[opts.channel]))?;
    one.pop()
        .ok_or_else(|| no_channel("option --channel", opts.channel, 0).in_file(path))
}

/// [`read_raw`] of several channels, or of all where none are named, in one pass; the channel of
/// `opts` does not count. The notices are those of the first.
///
/// # Errors
/// See [`read`].
pub fn read_channels(
    path: &Path,
    opts: &ReadOptions,
    raw: Option<Raw>,
    channels: Option<&[usize]>,
) -> Result<Vec<Recording>, InputError> {
    let known = Known {
        fs: opts.fs,
        stream: opts.stream,
    };
    let mut stream = Stream::open(path, known, raw)?;
    let channels = channels.map_or_else(|| (0..stream.channels).collect(), <[usize]>::to_vec);
    stream.want(&channels)?;
    let mut rows = vec![Vec::new(); channels.len()];
    let (mut gaps, mut block) = (Vec::new(), vec![Vec::new(); channels.len()]);
    while stream.next(&mut block)? {
        if stream.missing() > 0 {
            gaps.push(Gap {
                at: rows.first().map_or(0, |row: &Vec<f64>| row.len() as u64),
                samples: stream.missing(),
            });
        }
        for (row, block) in rows.iter_mut().zip(&block) {
            row.extend_from_slice(block);
        }
    }
    let mut end = stream.end()?;
    let mut recordings = Vec::new();
    for (channel, samples) in channels.into_iter().zip(rows) {
        let recording = Recording {
            fs: end.fs,
            unit: stream.unit(channel),
            full_scale: stream.step.map(|_| 1.0),
            step: stream.step,
            channel,
            channels: stream.channels,
            seconds: samples.len() as f64 / end.fs,
            gaps: gaps.clone(),
            samples,
            notices: std::mem::take(&mut end.notices),
            path: stream.path.clone(),
            format: stream.format.clone(),
        };
        if opts.check {
            check(&recording)?;
        }
        recordings.push(recording);
    }
    Ok(recordings)
}

/// The rate that counts: what the caller says, with a notice, or the header.
fn rate_of(
    place: &str,
    header: u32,
    fs: Option<f64>,
    notices: &mut Vec<String>,
) -> Result<f64, InputError> {
    match fs {
        Some(fs) => {
            if fs != f64::from(header) {
                notices.push(format!(
                    "header says {header} Hz: --fs {fs} Hz used instead"
                ));
            }
            Ok(fs)
        }
        None if header == 0 => Err(InputError::new(
            Problem::Rate,
            place,
            "the header says a sampling rate of 0 Hz",
            "give --fs in hertz",
        )),
        None => Ok(f64::from(header)),
    }
}

/// The error for a channel the file does not have.
pub fn no_channel(place: &str, asked: usize, channels: usize) -> InputError {
    let what = match channels {
        1 => format!("channel {asked} asked for, but there is one channel, number 0"),
        n => format!(
            "channel {asked} asked for, but there are {n}, numbered 0 to {}",
            n - 1
        ),
    };
    InputError::new(Problem::Channel, place, what, "choose another --channel")
}
