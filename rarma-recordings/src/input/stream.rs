//! A recording block by block: as much memory for a day as for a second.
//!
//! What is found only at the end (a file that is cut short, a time column that does not
//! run evenly) is said by [`Stream::end`].

use super::blocks::{Begin, Blocks, End, Known, Raw};
use super::bytes::Bytes;
use super::{Format, InputError, Problem, frames, raw, table, tdms, uff_time, wav};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What standard input is called in messages.
const STANDARD_INPUT: &str = "standard input";

/// A recording that is being read.
pub struct Stream {
    /// Where it comes from.
    pub path: PathBuf,
    /// What it is, for people: `WAV, PCM 16 bit`.
    pub format: String,
    /// Sampling rate, Hz; none where only the end tells it (a column of times).
    pub fs: Option<f64>,
    /// Smallest step the format can hold, full scale being 1; none where there is no limit.
    pub step: Option<f64>,
    /// Channels there are.
    pub channels: usize,
    /// It is a file, and can be opened again.
    pub again: bool,
    blocks: Box<dyn Blocks>,
}

impl Stream {
    /// Opens the recording at `path`, `-` being standard input; `raw` is what comes
    /// without a header.
    ///
    /// # Errors
    /// The file cannot be opened or is no recording, or its header is broken.
    pub fn open(path: &Path, known: Known, raw: Option<Raw>) -> Result<Self, InputError> {
        if path == Path::new("-") {
            return Self::piped(Box::new(io::stdin()), known, raw);
        }
        Self::of_file(path, known, raw).map_err(|why| why.in_file(path))
    }

    /// What comes through standard input, by whoever reads it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn piped(
        source: Box<dyn Read>,
        known: Known,
        raw: Option<Raw>,
    ) -> Result<Self, InputError> {
        let name = PathBuf::from(STANDARD_INPUT);
        let format = chosen(raw, known, || Ok(Format::Wav));
        match format.and_then(|format| uncompressed(format, source, None, known)) {
            Ok(begin) => Ok(Self::of(name, begin, false)),
            Err(why) => Err(why.in_file(&name)),
        }
    }

    fn of_file(path: &Path, known: Known, raw: Option<Raw>) -> Result<Self, InputError> {
        there(path)?;
        let format = chosen(raw, known, || Format::of(path))?;
        let file = File::open(path).map_err(|e| InputError::from_io(&e))?;
        let meta = file.metadata().map_err(|e| InputError::from_io(&e))?;
        let length = meta.is_file().then_some(meta.len());
        let begin = match format {
            Format::Compressed(_) | Format::Tdms if length == Some(0) => return Err(empty(false)),
            Format::Tdms => tdms::begin(Box::new(file), length, known.fs)?,
            Format::Compressed(named) => compressed(file, length, named, known.fs)?,
            _ => uncompressed(format, Box::new(file), length, known)?,
        };
        Ok(Self::of(path.to_path_buf(), begin, length.is_some()))
    }

    /// A WAV file that is in memory; `name` is for messages.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn in_memory(name: PathBuf, bytes: Arc<[u8]>, known: Known) -> Result<Self, InputError> {
        let length = Some(bytes.len() as u64);
        let source = Box::new(io::Cursor::new(bytes));
        match uncompressed(Format::Wav, source, length, known) {
            Ok(begin) => Ok(Self::of(name, begin, false)),
            Err(why) => Err(why.in_file(&name)),
        }
    }

    /// What comes live, and but once.
    pub fn live(name: PathBuf, begin: Begin) -> Self {
        Self::of(name, begin, false)
    }

    fn of(path: PathBuf, begin: Begin, again: bool) -> Self {
        Self {
            path,
            format: begin.format,
            fs: begin.fs,
            step: begin.step,
            channels: begin.channels,
            again,
            blocks: begin.blocks,
        }
    }

    /// Chooses the channels to be read, counted from 0.
    ///
    /// # Errors
    /// One of them is not there.
    pub fn want(&mut self, channels: &[usize]) -> Result<(), InputError> {
        match channels.iter().find(|c| **c >= self.channels) {
            Some(&asked) => {
                let why = self.blocks.no_channel(asked, self.channels);
                Err(why.in_file(&self.path))
            }
            None => {
                self.blocks.want(channels);
                Ok(())
            }
        }
    }

    /// Puts the samples that come next into `rows`, one for each wanted channel; false at
    /// the end. A pipe is waited for.
    ///
    /// # Errors
    /// What is wrong with the file there, and where.
    pub fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        rows.iter_mut().for_each(Vec::clear);
        let more = self.blocks.next(rows);
        more.map_err(|why| why.in_file(&self.path))
    }

    /// Of the samples that [`next`](Self::next) has just given, so many at the beginning
    /// stand for missing ones: zeros.
    pub fn missing(&self) -> u64 {
        self.blocks.missing()
    }

    /// Unit of a channel's samples, such as `m/s^2`, where the file says it; known when
    /// [`next`](Self::next) has come to the end.
    pub fn unit(&self, channel: usize) -> Option<String> {
        self.blocks.unit(channel)
    }

    /// What is known when [`next`](Self::next) has come to the end.
    ///
    /// # Errors
    /// There were no samples, or the end is broken.
    pub fn end(&mut self) -> Result<End, InputError> {
        let end = self.blocks.end();
        end.map_err(|why| why.in_file(&self.path))
    }
}

/// The format: that of samples without a header, or what `otherwise` finds.
fn chosen(
    raw: Option<Raw>,
    Known { fs, stream }: Known,
    otherwise: impl FnOnce() -> Result<Format, InputError>,
) -> Result<Format, InputError> {
    if let Some(fs) = fs.filter(|fs| !(fs.is_finite() && *fs > 0.0)) {
        return Err(InputError::new(
            Problem::Rate,
            "option --fs",
            format!("{fs} is not a sampling rate"),
            "give a positive number of hertz",
        ));
    }
    let format = match raw {
        Some(Raw::S16) => Format::RawS16,
        Some(Raw::F32) => Format::RawF32,
        None => otherwise()?,
    };
    if stream.is_some() && !matches!(format, Format::Frames) {
        return Err(InputError::new(
            Problem::Stream,
            "option --stream",
            "only a record of a box has streams",
            "leave it out",
        ));
    }
    Ok(format)
}

/// That a file is there, and no directory.
fn there(path: &Path) -> Result<(), InputError> {
    let meta = fs::metadata(path).map_err(|e| InputError::from_io(&e))?;
    if meta.is_dir() {
        return Err(InputError::new(
            Problem::Directory,
            "open",
            "is a directory",
            "name one recording inside it",
        ));
    }
    Ok(())
}

/// A file of no bytes, or a pipe that ends before it begins.
fn empty(piped: bool) -> InputError {
    InputError::new(
        Problem::Empty,
        "byte 0",
        if piped {
            "nothing came"
        } else {
            "the file is empty"
        },
        "record again, or copy it again",
    )
}

/// Reads the header of what is read byte by byte; `length` is that of a file, none for a pipe.
fn uncompressed(
    format: Format,
    source: Box<dyn Read>,
    length: Option<u64>,
    Known { fs, stream }: Known,
) -> Result<Begin, InputError> {
    let mut bytes = Bytes::new(source);
    if bytes.look(1)?.is_empty() {
        return Err(empty(length.is_none()));
    }
    match format {
        Format::Wav | Format::Compressed(_) | Format::Tdms => wav::begin(bytes, length, fs),
        Format::Table => table::begin(bytes, fs),
        Format::RawF32 => raw::begin(bytes, fs, raw::Width::F32),
        Format::RawF64 => raw::begin(bytes, fs, raw::Width::F64),
        Format::RawS16 => raw::begin(bytes, fs, raw::Width::S16),
        Format::Frames => frames::begin(bytes, fs, stream),
        Format::Uff => uff_time::begin(bytes, fs),
    }
}

#[cfg(feature = "codecs")]
use super::compressed::begin as compressed;

/// What a program without decoders says of a compressed file.
#[cfg(not(feature = "codecs"))]
fn compressed(
    _file: File,
    _length: Option<u64>,
    named: super::content::Content,
    _fs: Option<f64>,
) -> Result<Begin, InputError> {
    Err(InputError::new(
        Problem::Unsupported,
        "name",
        format!(
            "{} is not read by this program, which was built without codecs",
            named.name()
        ),
        "build it without --no-default-features, or convert the file to WAV",
    ))
}
