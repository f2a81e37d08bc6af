//! Records of a box (`.frames`): the raw samples of one of their streams, as a recording.

use super::{Decoded, InputError, Problem, ReadOptions, no_channel};
use crate::frames::FrameReader;
use crate::raw_streams::{Gap, Piece, RawStreams, Stream, value};
use std::convert::Infallible;

/// Streams that are named where one is to be chosen.
const NAMED: usize = 8;

pub(super) fn decode(bytes: &[u8], opts: &ReadOptions) -> Result<Decoded, InputError> {
    if opts.channel != 0 {
        return Err(no_channel("record", opts.channel, 1));
    }
    let mut survey = Survey::new(opts.stream);
    let (reader, raw) = pass(bytes, |piece| {
        if let Piece::End(stream) = piece {
            survey.add(stream);
        }
    });
    if reader.whole == 0 {
        return Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "there is no whole frame in it",
            "make a record with `rarma connect --record`",
        ));
    }
    if let Some(last) = raw.now() {
        survey.add(last);
    }
    let stream = survey.chosen()?;
    let mut samples = Vec::new();
    let mut gaps = Vec::new();
    let mut wanted = false;
    pass(bytes, |piece| match piece {
        Piece::Begin(s) => wanted = s.number == stream.number,
        Piece::Gap(n) if wanted => {
            gaps.push(Gap {
                at: samples.len() as u64,
                samples: n,
            });
            samples.resize(samples.len() + n as usize, 0.0);
        }
        Piece::Samples(codes) if wanted => samples.extend(codes.iter().map(|code| value(*code))),
        _ => {}
    });
    let Some(fs) = opts.fs.or(stream.fs_hz) else {
        return Err(InputError::new(
            Problem::Rate,
            "end of file",
            "the record does not say the sampling rate",
            "give --fs in hertz",
        ));
    };
    let mut notices: Vec<String> = reader.losses().into_iter().chain(raw.notice()).collect();
    if stream.gaps > 0 || survey.streams > 1 {
        notices.push(stream.words());
    }
    Ok(Decoded {
        format: "frames of a box".to_owned(),
        fs,
        samples,
        step: Some(1.0 / 32767.0),
        channels: 1,
        gaps,
        notices,
    })
}

fn pass(bytes: &[u8], mut with: impl FnMut(Piece<'_>)) -> (FrameReader, RawStreams) {
    let mut reader = FrameReader::default();
    let mut raw = RawStreams::default();
    reader.take(bytes, |head, message| {
        let Ok(()) = raw.take(head.session, &message, |piece| {
            with(piece);
            Ok::<(), Infallible>(())
        });
    });
    (reader, raw)
}

/// What streams there are: the first few, and the one that was asked for.
struct Survey {
    asked: Option<usize>,
    found: Option<Stream>,
    first: Vec<Stream>,
    streams: usize,
}

impl Survey {
    fn new(asked: Option<usize>) -> Self {
        Self {
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

    /// The one that was asked for, or the only one. None is taken by guess: a verdict on one
    /// says nothing of the others.
    fn chosen(&self) -> Result<Stream, InputError> {
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
