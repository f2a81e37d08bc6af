//! A WAV of what is heard now.

use super::wav::{broken, most_samples};
use super::{WriteError, WriteProblem, failed};
use hound::{SampleFormat, WavSpec, WavWriter};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// A recording in the making, under its own name from the beginning. Its header is brought up to
/// date every second, so that a program that is killed loses at most the last one. A file that
/// is there already is never touched. Where a WAV is full (4 GiB), the next part goes on.
pub struct LiveWav {
    path: PathBuf,
    spec: WavSpec,
    writer: WavWriter<BufWriter<File>>,
    part: u32,
    /// Samples of all channels the file has room for.
    room: u64,
    /// Samples since the header was true.
    since: u64,
}

impl LiveWav {
    /// Begins one of PCM with so many bits, or of floats.
    ///
    /// # Errors
    /// The file is there already, or cannot be made.
    pub fn create(
        path: &Path,
        rate_hz: u32,
        channels: usize,
        bits: Option<u32>,
    ) -> Result<Self, WriteError> {
        let spec = WavSpec {
            channels: channels as u16,
            sample_rate: rate_hz,
            bits_per_sample: bits.map_or(32, |bits| (bits.div_ceil(8) * 8).clamp(16, 32)) as u16,
            sample_format: match bits {
                Some(_) => SampleFormat::Int,
                None => SampleFormat::Float,
            },
        };
        Self::begin(path, spec, 1)
    }

    fn begin(path: &Path, spec: WavSpec, part: u32) -> Result<Self, WriteError> {
        let name = part_of(path, part);
        must_be_new(&name)?;
        let file = OpenOptions::new().write(true).create_new(true).open(&name);
        let file = file.map_err(|why| failed(&name, "open", &why))?;
        // So that no other program replaces it meanwhile; not every disk has locks.
        let _ = file.try_lock();
        let writer = WavWriter::new(BufWriter::new(file), spec);
        Ok(Self {
            writer: writer.map_err(|why| broken(&name, why))?,
            path: path.to_path_buf(),
            spec,
            part,
            room: most_samples(&spec),
            since: 0,
        })
    }

    /// Adds samples, one row for each channel.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&mut self, rows: &[Vec<f64>]) -> Result<(), WriteError> {
        let channels = u64::from(self.spec.channels);
        for n in 0..rows.first().map_or(0, Vec::len) {
            if self.room < channels {
                self.next_part()?;
            }
            for row in rows.iter().take(channels as usize) {
                let written = match self.spec.sample_format {
                    SampleFormat::Int => self.writer.write_sample(self.code(row[n])),
                    SampleFormat::Float => self.writer.write_sample(row[n] as f32),
                };
                written.map_err(|why| broken(&self.name(), why))?;
            }
            self.room -= channels;
            self.since += channels;
        }
        if self.since >= channels * u64::from(self.spec.sample_rate) {
            self.since = 0;
            let told = self.writer.flush();
            told.map_err(|why| broken(&self.name(), why))?;
        }
        Ok(())
    }

    /// Ends it, safely on disk. One that holds nothing is removed: false.
    ///
    /// # Errors
    /// It cannot be written to its end.
    pub fn finish(self) -> Result<bool, WriteError> {
        let name = self.name();
        let empty = self.writer.len() == 0;
        let ended = self.writer.finalize();
        ended.map_err(|why| broken(&name, why))?;
        let safe = match empty {
            true => fs::remove_file(&name),
            false => File::open(&name).and_then(|file| file.sync_all()),
        };
        safe.map_err(|why| failed(&name, "write", &why))?;
        Ok(!empty)
    }

    fn next_part(&mut self) -> Result<(), WriteError> {
        let next = Self::begin(&self.path, self.spec, self.part + 1)?;
        std::mem::replace(self, next).finish().map(|_| ())
    }

    /// The file that is written now.
    pub fn name(&self) -> PathBuf {
        part_of(&self.path, self.part)
    }

    fn code(&self, x: f64) -> i32 {
        let full = 2_f64.powi(i32::from(self.spec.bits_per_sample) - 1);
        (x * full).round().clamp(-full, full - 1.0) as i32
    }
}

/// That there is no file of that name.
///
/// # Errors
/// There is one.
pub fn must_be_new(path: &Path) -> Result<(), WriteError> {
    match fs::symlink_metadata(path) {
        Err(why) if why.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(why) => Err(failed(path, "open", &why)),
        Ok(_) => Err(WriteError::new(
            WriteProblem::System,
            path,
            "open",
            "a file of that name is there, and a recording replaces none",
            "name another file, or move that one",
        )),
    }
}

/// The name that was given for the first part, `NAME-part2` for the second.
fn part_of(path: &Path, part: u32) -> PathBuf {
    if part == 1 {
        return path.to_path_buf();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-part{part}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a reader finds, as codes.
    fn read(path: &Path) -> (WavSpec, Vec<i32>) {
        let reader = hound::WavReader::open(path).expect("a WAV");
        let spec = reader.spec();
        let samples = reader.into_samples::<i32>();
        (spec, samples.map(|x| x.expect("a sample")).collect())
    }

    #[test]
    fn a_wav_that_is_cut_off_by_a_kill_holds_all_but_the_last_second() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.wav");
        let mut wav = LiveWav::create(&path, 1000, 2, Some(16)).expect("begun");
        let rows = |x: f64| vec![vec![x / 32_768.0; 250], vec![-x / 32_768.0; 250]];
        for k in 0..7 {
            wav.write(&rows(f64::from(k))).expect("written");
        }
        // A program that is killed runs no destructor.
        std::mem::forget(wav);
        let (spec, codes) = read(&path);
        assert_eq!((spec.channels, spec.sample_rate), (2, 1000));
        assert_eq!(codes.len(), 2 * 1000, "one second of 1.75 s");
        assert_eq!(codes[..2], [0, 0]);
        assert_eq!(codes[2 * 999..], [3, -3]);
    }

    #[test]
    fn codes_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        for bits in [16, 24, 32] {
            let path = folder.path().join(format!("{bits}.wav"));
            let full = 2_f64.powi(bits - 1);
            let codes = [0.0, 1.0, -1.0, full - 1.0, -full];
            let rows = vec![codes.iter().map(|c| c / full).collect::<Vec<f64>>()];
            let mut wav = LiveWav::create(&path, 48_000, 1, Some(bits as u32)).expect("begun");
            wav.write(&rows).expect("written");
            wav.finish().expect("whole");
            let (spec, read) = read(&path);
            assert_eq!(i32::from(spec.bits_per_sample), bits);
            let expected: Vec<i32> = codes.iter().map(|c| *c as i32).collect();
            assert_eq!(read, expected);
        }
    }

    #[test]
    fn a_file_that_is_there_is_never_touched() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("kept.wav");
        crate::output::write(&path, b"mine").expect("written");
        let why = LiveWav::create(&path, 48_000, 1, Some(16));
        let why = why.err().expect("refused").to_string();
        assert!(why.contains("kept.wav") && why.contains("another"), "{why}");
        assert_eq!(fs::read(&path).expect("there"), b"mine");
    }

    #[test]
    fn one_that_holds_nothing_is_not_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("none.wav");
        let wav = LiveWav::create(&path, 48_000, 1, Some(16)).expect("begun");
        assert!(path.exists());
        assert_eq!(wav.finish(), Ok(false));
        assert!(!path.exists());
    }

    #[test]
    fn a_full_wav_goes_on_in_the_next_part() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("day.wav");
        let mut wav = LiveWav::create(&path, 1000, 1, Some(16)).expect("begun");
        // As if 4 GiB less 300 samples had been written.
        wav.room = 300;
        wav.write(&[vec![0.5; 500]]).expect("written");
        wav.finish().expect("whole");
        assert_eq!(read(&path).1.len(), 300);
        assert_eq!(read(&folder.path().join("day-part2.wav")).1.len(), 200);
    }
}
