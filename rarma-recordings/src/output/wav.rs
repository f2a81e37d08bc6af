//! A WAV in the making.

use super::{NewFile, Whole, WriteError, WriteProblem, failed};
use hound::{Sample, WavSpec, WavWriter};
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Bytes of samples a WAV's header can tell of.
const MOST_BYTES: u64 = u32::MAX as u64 - 64;

/// Samples (of all channels) that fit into one WAV.
pub fn most_samples(spec: &WavSpec) -> u64 {
    MOST_BYTES / u64::from(spec.bits_per_sample.div_ceil(8))
}

/// A WAV that takes its name when it is whole.
pub struct WavFile {
    new: NewFile,
    writer: WavWriter<BufWriter<File>>,
    spec: WavSpec,
    left: u64,
}

impl WavFile {
    /// Begins one.
    ///
    /// # Errors
    /// See [`NewFile::create`].
    pub fn create(path: &Path, spec: WavSpec) -> Result<Self, WriteError> {
        let new = NewFile::create(path)?;
        let file = new.file().try_clone();
        let file = file.map_err(|why| failed(path, "open", &why))?;
        let writer = WavWriter::new(BufWriter::new(file), spec);
        Ok(Self {
            writer: writer.map_err(|why| broken(path, why))?,
            left: most_samples(&spec),
            new,
            spec,
        })
    }

    /// Adds a sample.
    ///
    /// # Errors
    /// It cannot be written, or there is no room for it in a WAV.
    pub fn sample(&mut self, x: impl Sample) -> Result<(), WriteError> {
        let Some(left) = self.left.checked_sub(1) else {
            return Err(WriteError::new(
                WriteProblem::System,
                self.new.path(),
                "write",
                "a WAV holds no more than 4 GiB",
                "make it shorter",
            ));
        };
        self.left = left;
        let written = self.writer.write_sample(x);
        written.map_err(|why| broken(self.new.path(), why))
    }

    /// Writes the header; the rate is only known now where `rate_hz` is given.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(self, rate_hz: Option<u32>) -> Result<Whole, WriteError> {
        let mut new = self.new;
        let ended = self.writer.finalize();
        ended.map_err(|why| broken(new.path(), why))?;
        if let Some(rate_hz) = rate_hz.filter(|hz| *hz != self.spec.sample_rate) {
            let frame = u32::from(self.spec.channels) * u32::from(self.spec.bits_per_sample) / 8;
            let mut fields = [0; 8];
            fields[..4].copy_from_slice(&rate_hz.to_le_bytes());
            fields[4..].copy_from_slice(&rate_hz.saturating_mul(frame).to_le_bytes());
            // The sampling rate and the bytes a second, which follow the tags RIFF, WAVE and
            // fmt, the encoding and the channels.
            new.seek(SeekFrom::Start(24))
                .and_then(|_| new.write_all(&fields))
                .map_err(|why| failed(new.path(), "write", &why))?;
        }
        new.done()
    }
}

pub(super) fn broken(path: &Path, why: hound::Error) -> WriteError {
    match why {
        hound::Error::IoError(why) => failed(path, "write", &why),
        other => WriteError::new(WriteProblem::System, path, "write", other.to_string(), ""),
    }
}
