//! What `monitor` listens to: one channel or two of a recording, and a tacho's, block by
//! block.
//!
//! A file is read twice: once to judge it, so that what is not fit to be analysed is
//! refused before a word is said, and once to listen. A pipe comes only once: it is
//! judged as it goes, and what was wrong with it is said, with the same exit code, at its
//! end.

use super::tacho::Tacho;
use crate::args::{InputArgs, MonitorArgs};
use crate::failure::Failure;
use rarma_recordings::input::{self, End, FileHealth, InputError, ReadOptions, Recording, Stream};
use std::path::PathBuf;

/// What settings are checked against.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// Where the samples come from.
    pub path: PathBuf,
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Largest value the format can hold, if there is a limit.
    pub full_scale: Option<f64>,
    /// Samples there are; none as long as a pipe runs.
    pub samples: Option<u64>,
}

impl From<&Recording> for About {
    fn from(recording: &Recording) -> Self {
        Self {
            path: recording.path.clone(),
            fs: recording.fs,
            full_scale: recording.full_scale,
            samples: Some(recording.samples.len() as u64),
        }
    }
}

/// A recording that is being listened to.
pub(super) struct Source {
    pub(super) about: About,
    /// Channels that are listened to, counted from 0.
    pub(super) channels: Vec<usize>,
    /// Which of them the pictures are made of: the first that is well.
    pub(super) pictured: usize,
    stream: Stream,
    rows: Vec<Vec<f64>>,
    tacho: Option<Tacho>,
    pulses: Vec<Option<f32>>,
    /// Of a pipe: what there is to say of each channel.
    judged: Option<Vec<FileHealth>>,
}

/// A block of samples in step.
pub(super) struct Block<'a> {
    /// One row for each channel that is listened to.
    pub(super) rows: &'a [Vec<f64>],
    /// Of these samples, so many at the beginning stand for missing ones.
    pub(super) missing: u64,
    /// For every sample, where a pulse of the tacho has begun since the one before: how
    /// long ago, samples. Empty without a tacho.
    pub(super) pulses: &'a [Option<f32>],
}

impl Source {
    /// Opens what `args` name, and judges it where it is a file.
    ///
    /// # Errors
    /// Bad input, or channels that do not go together, in one line.
    pub(super) fn open(args: &MonitorArgs) -> Result<Self, Failure> {
        let channels = listened(args)?;
        let mut stream = opened(args, &channels)?;
        let (mut pictured, mut samples, mut span, mut fs) = (0, None, None, stream.fs);
        if stream.again {
            let mut judged = judges(&stream, &channels);
            let mut rows = vec![Vec::new(); channels.len() + usize::from(args.tacho.is_some())];
            let mut ends = (f64::MAX, f64::MIN);
            while stream.next(&mut rows)? {
                judge(&mut judged, &rows);
                for x in rows.get(channels.len()).into_iter().flatten() {
                    if x.is_finite() {
                        ends = (ends.0.min(*x), ends.1.max(*x));
                    }
                }
            }
            let end = stream.end()?;
            pictured = told(&stream, &end, &channels, &judged)?;
            samples = judged.first().map(FileHealth::samples);
            span = Some(ends.1 - ends.0);
            fs = Some(end.fs);
            stream = opened(args, &channels)?;
        }
        stream.fs = fs;
        let judged = samples.is_none().then(|| judges(&stream, &channels));
        Self::begin(args, stream, channels, (pictured, samples, span), judged)
    }

    /// What comes live, judged as it comes.
    ///
    /// # Errors
    /// Channels that do not go together, or are not there, in one line.
    pub(super) fn live(args: &MonitorArgs, mut stream: Stream) -> Result<Self, Failure> {
        let channels = listened(args)?;
        choose(args, &mut stream, &channels)?;
        let judged = judges(&stream, &channels);
        Self::begin(args, stream, channels, (0, None, None), Some(judged))
    }

    /// `known` of a file: the channel that the pictures are made of, its samples, and the range
    /// of the tacho's.
    fn begin(
        args: &MonitorArgs,
        stream: Stream,
        channels: Vec<usize>,
        known: (usize, Option<u64>, Option<f64>),
        judged: Option<Vec<FileHealth>>,
    ) -> Result<Self, Failure> {
        let (pictured, samples, span) = known;
        let Some(fs) = stream.fs else {
            return Err(Failure::Input(format!(
                "{}: time column: its rate is known only at the end, and a pipe cannot be read twice (save it in a file, or send WAV)",
                stream.path.display()
            )));
        };
        let tacho = args.tacho.map(|_| Tacho::new(fs, span));
        Ok(Self {
            about: About {
                path: stream.path.clone(),
                fs,
                full_scale: stream.step.map(|_| 1.0),
                samples,
            },
            pictured,
            rows: vec![Vec::new(); channels.len() + usize::from(tacho.is_some())],
            judged,
            stream,
            channels,
            tacho,
            pulses: Vec::new(),
        })
    }

    /// The samples that come next; none at the end. A pipe is waited for.
    ///
    /// # Errors
    /// What is wrong with the file there.
    pub(super) fn next(&mut self) -> Result<Option<Block<'_>>, Failure> {
        if !self.stream.next(&mut self.rows)? {
            return Ok(None);
        }
        if let Some(judged) = &mut self.judged {
            judge(judged, &self.rows);
        }
        let (rows, tacho) = self.rows.split_at(self.channels.len());
        self.pulses.clear();
        if let (Some(pulses), Some(row)) = (&mut self.tacho, tacho.first()) {
            self.pulses.extend(row.iter().map(|x| pulses.process(*x)));
        }
        Ok(Some(Block {
            rows,
            missing: self.stream.missing(),
            pulses: &self.pulses,
        }))
    }

    /// What the end of a pipe tells: notices, and what is wrong with its samples.
    ///
    /// # Errors
    /// As those with which a file is refused at the beginning.
    pub(super) fn end(&mut self) -> Result<(), Failure> {
        let Some(judged) = self.judged.take() else {
            return Ok(());
        };
        let end = self.stream.end()?;
        self.about.samples = judged.first().map(FileHealth::samples);
        told(&self.stream, &end, &self.channels, &judged)?;
        Ok(())
    }
}

/// The channels that are listened to, counted from 0.
///
/// # Errors
/// Both are one.
fn listened(args: &MonitorArgs) -> Result<Vec<usize>, Failure> {
    let first = args.input.channel;
    if args.second == Some(first) {
        return Err(Failure::Usage(format!(
            "--second: must be another channel than --channel (both are {first})"
        )));
    }
    Ok([first].into_iter().chain(args.second).collect())
}

/// The stream of a job with all its channels chosen.
fn opened(args: &MonitorArgs, channels: &[usize]) -> Result<Stream, Failure> {
    let mut stream = Stream::open(&args.input.input, args.input.known(), args.input.raw())?;
    choose(args, &mut stream, channels)?;
    Ok(stream)
}

/// Chooses all channels of a job.
fn choose(args: &MonitorArgs, stream: &mut Stream, channels: &[usize]) -> Result<(), Failure> {
    stream.want(&channels[..1])?;
    if let Some(second) = args.second {
        require(
            stream,
            "--second",
            second,
            "record both sensors into one file",
        )?;
    }
    if let Some(tacho) = args.tacho {
        if channels.contains(&tacho) {
            return Err(Failure::Usage(format!(
                "--tacho: must be another channel than those that are listened to (channel {tacho} is)"
            )));
        }
        require(
            stream,
            "--tacho",
            tacho,
            "record the tacho into the same file",
        )?;
    }
    let all: Vec<usize> = channels.iter().copied().chain(args.tacho).collect();
    stream.want(&all)?;
    Ok(())
}

/// That a recording has the channel that `option` asks for; `remedy` is what else may be
/// done.
fn require(stream: &Stream, option: &str, channel: usize, remedy: &str) -> Result<(), Failure> {
    if channel < stream.channels {
        return Ok(());
    }
    let have = match stream.channels {
        1 => "one channel, number 0".to_owned(),
        n => format!("{n} channels, numbered 0 to {}", n - 1),
    };
    Err(Failure::Input(format!(
        "{}: channels: {option} asks for channel {channel}, but the file has {have} ({remedy}, or leave out {option})",
        stream.path.display()
    )))
}

fn judges(stream: &Stream, channels: &[usize]) -> Vec<FileHealth> {
    channels
        .iter()
        .map(|_| FileHealth::new(stream.step))
        .collect()
}

fn judge(judged: &mut [FileHealth], rows: &[Vec<f64>]) {
    for (health, row) in judged.iter_mut().zip(rows) {
        row.iter().for_each(|x| health.push(*x));
    }
}

/// Says what is odd about a recording; the first of its channels that is well. Of two
/// channels one may be sick: the monitor leaves it out.
///
/// # Errors
/// Nothing is well.
fn told(
    stream: &Stream,
    end: &End,
    channels: &[usize],
    judged: &[FileHealth],
) -> Result<usize, Failure> {
    for notice in &end.notices {
        eprintln!("{}: {notice}", stream.path.display());
    }
    let verdicts: Vec<Result<(), InputError>> = judged
        .iter()
        .zip(channels)
        .map(|(health, channel)| {
            let verdict = health.verdict(end.fs, *channel);
            verdict.map_err(|why| why.in_file(&stream.path))
        })
        .collect();
    let Some(well) = verdicts.iter().position(Result::is_ok) else {
        return match verdicts.into_iter().next() {
            Some(Err(why)) => Err(why.into()),
            _ => Ok(0),
        };
    };
    for (verdict, channel) in verdicts.into_iter().zip(channels) {
        if let Err(why) = verdict {
            eprintln!("{why}; channel {channel}: left out while it is so");
        }
    }
    Ok(well)
}

/// Reads the recording whole, and passes on what is odd about it.
///
/// # Errors
/// Bad input, in one line.
pub fn read(args: &InputArgs) -> Result<Recording, Failure> {
    let options = ReadOptions {
        channel: args.channel,
        fs: args.fs,
        stream: args.stream,
        check: true,
    };
    let recording = input::read_raw(&args.input, &options, args.raw())?;
    for notice in &recording.notices {
        eprintln!("{}: {notice}", recording.path.display());
    }
    Ok(recording)
}
