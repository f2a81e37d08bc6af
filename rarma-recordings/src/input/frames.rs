//! Records of a box (`.frames`): the raw samples of one of their streams, as they come.

use super::blocks::{Begin, Blocks, End};
use super::bytes::Bytes;
use super::{InputError, Problem};
use crate::frame_reader::FrameReader;
use crate::raw_streams::{Piece, RawStreams, Stream, value};
use std::collections::VecDeque;
use std::convert::Infallible;

/// Streams that are named where one is to be chosen.
const NAMED: usize = 8;

/// `asked`: the stream, counted from 1 (none: the only one).
pub(super) fn begin(
    bytes: Bytes,
    fs: Option<f64>,
    asked: Option<usize>,
) -> Result<Begin, InputError> {
    let mut frames = Frames {
        bytes,
        reader: FrameReader::default(),
        raw: RawStreams::default(),
        survey: Survey::new(asked),
        ready: VecDeque::new(),
        missing: 0,
        fs,
    };
    // As far as the first sample that is wanted: the rate is told before it.
    while frames.ready.is_empty() && frames.read()? {}
    if frames.reader.whole == 0 {
        return Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "there is no whole frame in it",
            "make a record with `rarma connect --record`",
        ));
    }
    if frames.ready.is_empty() {
        frames.survey.chosen(frames.raw.now())?;
    }
    let told = frames.raw.now().and_then(|stream| stream.fs_hz);
    Ok(Begin {
        format: "frames of a box".to_owned(),
        fs: fs.or(told),
        step: Some(1.0 / 32767.0),
        channels: 1,
        blocks: Box::new(frames),
    })
}

/// What comes next of the stream that is wanted.
enum Chunk {
    Missing(usize),
    Samples(Vec<f64>),
}

/// A record that is being read.
struct Frames {
    bytes: Bytes,
    reader: FrameReader,
    raw: RawStreams,
    survey: Survey,
    ready: VecDeque<Chunk>,
    /// Of the samples just given.
    missing: u64,
    fs: Option<f64>,
}

impl Frames {
    /// Takes the bytes that come next; false at the end.
    fn read(&mut self) -> Result<bool, InputError> {
        if self.bytes.waiting().is_empty() && !self.bytes.more()? {
            return Ok(false);
        }
        let here = self.bytes.waiting();
        let (raw, survey, ready) = (&mut self.raw, &mut self.survey, &mut self.ready);
        self.reader.take(here, |head, message| {
            let Ok(()) = raw.take(head.session, &message, |piece| {
                match piece {
                    Piece::Begin(stream) => survey.now = stream.number,
                    Piece::End(stream) => survey.add(stream),
                    Piece::Gap(n) if survey.wants() => ready.push_back(Chunk::Missing(n as usize)),
                    Piece::Samples(codes) if survey.wants() => {
                        let samples = codes.iter().map(|code| value(*code));
                        ready.push_back(Chunk::Samples(samples.collect()));
                    }
                    _ => {}
                }
                Ok::<(), Infallible>(())
            });
        });
        let taken = here.len();
        self.bytes.take(taken);
        Ok(true)
    }
}

impl Blocks for Frames {
    fn want(&mut self, _channels: &[usize]) {}

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        self.missing = 0;
        while self.ready.is_empty() {
            if !self.read()? {
                return Ok(false);
            }
            // A second one: all are named, and none is taken by guess.
            if self.survey.asked.is_none() && self.survey.now > 1 {
                while self.read()? {
                    self.ready.clear();
                }
                self.survey.chosen(self.raw.now())?;
            }
        }
        match self.ready.pop_front() {
            Some(Chunk::Missing(n)) => {
                self.missing = n as u64;
                rows.iter_mut()
                    .for_each(|row| row.resize(row.len() + n, 0.0));
            }
            Some(Chunk::Samples(samples)) => {
                rows.iter_mut().for_each(|row| row.extend(&samples));
            }
            None => {}
        }
        Ok(true)
    }

    fn missing(&self) -> u64 {
        self.missing
    }

    fn end(&mut self) -> Result<End, InputError> {
        let stream = self.survey.chosen(self.raw.now())?;
        let Some(fs) = self.fs.or(stream.fs_hz) else {
            return Err(InputError::new(
                Problem::Rate,
                "end of file",
                "the record does not say the sampling rate",
                "give --fs in hertz",
            ));
        };
        let mut notices: Vec<String> = self
            .reader
            .losses()
            .into_iter()
            .chain(self.raw.notice())
            .collect();
        if stream.gaps > 0 || self.survey.streams > 1 {
            notices.push(stream.words());
        }
        Ok(End { fs, notices })
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        super::no_channel("record", asked, channels)
    }
}

/// What streams there are: the first few, and the one that was asked for.
struct Survey {
    /// Number of the stream that is running.
    now: usize,
    asked: Option<usize>,
    found: Option<Stream>,
    first: Vec<Stream>,
    streams: usize,
}

impl Survey {
    fn new(asked: Option<usize>) -> Self {
        Self {
            now: 0,
            asked,
            found: None,
            first: Vec::new(),
            streams: 0,
        }
    }

    fn add(&mut self, stream: &Stream) {
        self.streams += 1;
        if self.asked == Some(stream.number) {
            self.found = Some(stream.clone());
        }
        if self.first.len() < NAMED {
            self.first.push(stream.clone());
        }
    }

    /// Whether the stream that is running is one that may be wanted.
    fn wants(&self) -> bool {
        self.asked.is_none_or(|asked| asked == self.now)
    }

    /// The one that was asked for, or the only one, `last` being the one the record ends in. None is taken by guess: a verdict on one
    /// says nothing of the others.
    fn chosen(&mut self, last: Option<&Stream>) -> Result<Stream, InputError> {
        if let Some(last) = last.filter(|last| last.number > self.streams) {
            self.add(last);
        }
        let what = match (self.asked, &self.found, &self.first[..]) {
            (Some(_), Some(found), _) => return Ok(found.clone()),
            (None, _, [only]) => return Ok(only.clone()),
            (_, _, []) => {
                return Err(InputError::new(
                    Problem::NoSamples,
                    "end of file",
                    "the record holds no raw samples",
                    "send `stream SECONDS` while it is made",
                ));
            }
            (Some(asked), None, _) => format!("there is no stream {asked}, but {}", self.words()),
            (None, _, _) => format!("there are {}", self.words()),
        };
        Err(InputError::new(
            Problem::Stream,
            "record",
            what,
            "choose one with --stream N",
        ))
    }

    fn words(&self) -> String {
        let each = self.first.iter().map(|stream| {
            let fs_hz = stream.fs_hz.unwrap_or(f64::NAN);
            format!(
                "{} of {:.3} s",
                stream.number,
                stream.samples as f64 / fs_hz
            )
        });
        let mut each: Vec<String> = each.collect();
        if self.streams > each.len() {
            each.push("…".to_owned());
        }
        let streams = if self.streams == 1 {
            "stream"
        } else {
            "streams"
        };
        format!("{} {streams}: {}", self.streams, each.join(", "))
    }
}
