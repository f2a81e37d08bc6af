//! A WAV file in memory, read and judged as `rarma monitor` does it.

use rarma_cli::Failure;
use rarma_recordings::input::{FileHealth, Known, Stream};
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// What is known of a file before it is listened to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct About {
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Samples of a channel.
    pub samples: u64,
    /// Channels there are; the first is listened to.
    pub channels: usize,
    /// Largest value of the format, where it has one.
    pub full_scale: Option<f64>,
    /// Odd, but not fatal: one sentence each.
    pub notices: Vec<String>,
}

/// A file that is being listened to.
pub struct Opened {
    about: About,
    stream: Stream,
    row: [Vec<f64>; 1],
}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Opened")
            .field("about", &self.about)
            .finish_non_exhaustive()
    }
}

impl Opened {
    /// Reads all of it once, to know that it is fit to be analysed.
    ///
    /// # Errors
    /// It is no WAV, is broken, silent or clipped, in one line; see docs/faults.md.
    pub fn new(name: &str, bytes: Vec<u8>) -> Result<Self, Failure> {
        let bytes: Arc<[u8]> = bytes.into();
        let open = || -> Result<Stream, Failure> {
            let name = Path::new(name).to_path_buf();
            let mut stream = Stream::in_memory(name, Arc::clone(&bytes), Known::default())?;
            stream.want(&[0])?;
            Ok(stream)
        };
        let mut stream = open()?;
        let mut health = FileHealth::new(stream.step);
        let mut row = [Vec::new()];
        while stream.next(&mut row)? {
            row[0].iter().for_each(|x| health.push(*x));
        }
        let end = stream.end()?;
        let verdict = health.verdict(end.fs, 0);
        verdict.map_err(|why| why.in_file(Path::new(name)))?;
        Ok(Self {
            about: About {
                fs: end.fs,
                samples: health.samples(),
                channels: stream.channels,
                full_scale: stream.step.map(|_| 1.0),
                notices: end.notices,
            },
            stream: open()?,
            row,
        })
    }

    /// What is known of it.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The samples that come next; none at the end.
    ///
    /// # Errors
    /// What is wrong with the file there.
    pub fn next_samples(&mut self) -> Result<Option<Vec<f32>>, Failure> {
        if !self.stream.next(&mut self.row)? {
            return Ok(None);
        }
        Ok(Some(self.row[0].iter().map(|x| *x as f32).collect()))
    }
}

/// Judges samples that somebody else has decoded, as [`Opened::new`] does.
///
/// # Errors
/// They are silent, clipped or no numbers, in one line.
pub fn judge(name: &str, samples: &[f32], fs: f64) -> Result<(), Failure> {
    let mut health = FileHealth::new(None);
    samples.iter().for_each(|x| health.push(f64::from(*x)));
    let verdict = health.verdict(fs, 0);
    Ok(verdict.map_err(|why| why.in_file(Path::new(name)))?)
}
