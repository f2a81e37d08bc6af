//! `rarma decode`: frames from anywhere to words, JSON or WAVs, as they come.

use crate::args::DecodeArgs;
use crate::failure::Failure;
use crate::frames::Teller;
use crate::output::{self, WavFile, Whole, most_samples, stdout};
use crate::port::Port;
use rarma_recordings::FrameReader;
use rarma_recordings::raw_streams::{Piece, RawStreams, Stream};
use std::path::{Path, PathBuf};

/// WAVs that one record is taken apart into.
const MOST_WAVS: usize = 1000;
/// Sixteen bits, as they come; the rate is written when it is known.
const SPEC: hound::WavSpec = hound::WavSpec {
    channels: 1,
    sample_rate: 48_000,
    bits_per_sample: 16,
    sample_format: hound::SampleFormat::Int,
};

pub(super) fn main(args: &DecodeArgs) -> Result<u8, Failure> {
    let mut port = Port::open(&args.input, args.baud)?;
    let mut reader = FrameReader::default();
    let mut teller = Teller::default();
    let mut raw = RawStreams::default();
    let mut wavs = args
        .wav
        .as_deref()
        .map(|path| Wavs::new(path, &args.input, args.stream));
    let mut bytes = [0; 4096];
    loop {
        let Some(n) = port.read(&mut bytes)? else {
            continue;
        };
        if n == 0 {
            break;
        }
        let mut done = Ok(());
        reader.take(&bytes[..n], |head, message| {
            if done.is_ok() {
                done = raw.take(head.session, &message, |piece| {
                    if let Piece::End(stream) = piece {
                        eprintln!("{}: {}", args.input, stream.words());
                    }
                    wavs.as_mut().map_or(Ok(()), |wavs| wavs.take(piece))
                });
            }
            if args.json {
                say!("{}", teller.json(head, &message));
            } else if let Some(text) = teller.words(&message) {
                say!("{text}");
            }
        });
        done?;
        stdout::check()?;
    }
    if let Some(last) = raw.now().filter(|s| s.number > 1 || s.gaps > 0) {
        eprintln!("{}: {}", args.input, last.words());
    }
    if let Some(notice) = raw.notice() {
        eprintln!("{}: {notice}", args.input);
    }
    let losses = reader.losses();
    if reader.whole == 0 {
        let losses = losses.map_or(String::new(), |losses| format!(": {losses}"));
        return Err(Failure::Input(format!(
            "{}: end of input: no whole frame in it{losses} (is it a record of a box, and the baud rate right?)",
            args.input
        )));
    }
    if let Some(losses) = losses {
        eprintln!("{}: {losses}", args.input);
    }
    wavs.map_or(Ok(()), |wavs| wavs.keep(raw.now()))?;
    Ok(0)
}

/// One WAV a stream, or the WAV of one stream. They are written as the samples come, and take
/// their names together at the end.
struct Wavs<'a> {
    path: &'a Path,
    input: &'a str,
    only: Option<usize>,
    /// Those of the stream that is running: a second one where the first is full.
    open: Vec<WavFile>,
    /// Samples the last of them has room for.
    room: u64,
    stream: usize,
    done: Vec<Whole>,
}

impl<'a> Wavs<'a> {
    fn new(path: &'a Path, input: &'a str, only: Option<usize>) -> Self {
        Self {
            path,
            input,
            only,
            open: Vec::new(),
            room: 0,
            stream: 0,
            done: Vec::new(),
        }
    }

    fn take(&mut self, piece: Piece<'_>) -> Result<(), Failure> {
        match piece {
            Piece::Begin(stream) => {
                self.stream = stream.number;
                if self.is_wanted() {
                    self.open()?;
                }
            }
            Piece::End(stream) => self.end(stream)?,
            Piece::Gap(samples) => {
                for _ in 0..samples {
                    self.sample(0)?;
                }
            }
            Piece::Samples(codes) => {
                for code in codes {
                    self.sample(*code)?;
                }
            }
        }
        Ok(())
    }

    fn is_wanted(&self) -> bool {
        self.only.is_none_or(|only| only == self.stream)
    }

    fn sample(&mut self, code: i16) -> Result<(), Failure> {
        if !self.is_wanted() {
            return Ok(());
        }
        if self.room == 0 {
            self.open()?;
        }
        self.room -= 1;
        match self.open.last_mut() {
            Some(wav) => Ok(wav.sample(code)?),
            None => Ok(()),
        }
    }

    fn open(&mut self) -> Result<(), Failure> {
        if self.done.len() + self.open.len() == MOST_WAVS {
            return Err(Failure::Input(format!(
                "{}: stream {}: more than {MOST_WAVS} WAVs would come of it (choose one stream with --stream)",
                self.input, self.stream
            )));
        }
        let name = self.name();
        if name != self.path {
            self.free(&name)?;
        }
        self.open.push(WavFile::create(&name, SPEC)?);
        self.room = most_samples(&SPEC);
        Ok(())
    }

    /// A name that was not given may be that of another's file.
    fn free(&self, name: &Path) -> Result<(), Failure> {
        match std::fs::symlink_metadata(name) {
            Err(_) => Ok(()),
            Ok(_) => Err(Failure::System(format!(
                "{}: open: stream {} would be written there, but a file of that name is there (move it, or choose one stream with --stream)",
                name.display(),
                self.stream
            ))),
        }
    }

    /// The name that was given for the first stream or the only one, `NAME-2` for the second;
    /// where a WAV was full `-part2` goes on.
    fn name(&self) -> PathBuf {
        let mut name = self.path.file_stem().unwrap_or_default().to_os_string();
        if self.only.is_none() && self.stream > 1 {
            name.push(format!("-{}", self.stream));
        }
        if !self.open.is_empty() {
            name.push(format!("-part{}", self.open.len() + 1));
        }
        if let Some(extension) = self.path.extension() {
            name.push(".");
            name.push(extension);
        }
        self.path.with_file_name(name)
    }

    fn end(&mut self, stream: &Stream) -> Result<(), Failure> {
        for wav in self.open.drain(..) {
            let Some(fs_hz) = stream.fs_hz else {
                return Err(Failure::Input(format!(
                    "{}: stream {}: its rate is not told (send `identify` while recording)",
                    self.input, stream.number
                )));
            };
            self.done.push(wav.finish(Some(fs_hz.round() as u32))?);
        }
        Ok(())
    }

    fn keep(mut self, last: Option<&Stream>) -> Result<(), Failure> {
        let Some(last) = last else {
            return Err(Failure::Input(format!(
                "{}: end of input: no raw samples in it (send `stream SECONDS` while recording)",
                self.input
            )));
        };
        self.end(last)?;
        match self.done.len() {
            0 => {
                return Err(Failure::Input(format!(
                    "{}: --stream: there are {} streams, counted from 1",
                    self.input, last.number
                )));
            }
            1 => {}
            n => eprintln!(
                "{}: {n} WAVs, {} and its like",
                self.input,
                self.path.display()
            ),
        }
        Ok(output::keep(self.done)?)
    }
}
