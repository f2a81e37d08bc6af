//! Files to listen to: good ones, and the bytes of bad ones.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder that goes with the test.
#[derive(Debug)]
pub struct Folder(TempDir);

impl Default for Folder {
    fn default() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }
}

impl Folder {
    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file.
    ///
    /// # Panics
    /// It cannot be written.
    #[must_use]
    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, bytes).expect("a file in a temporary folder");
        path
    }

    /// One channel of 16-bit PCM; ±1 is full scale.
    #[must_use]
    pub fn pcm16(&self, name: &str, fs_hz: u32, samples: &[f64]) -> PathBuf {
        self.file(name, &wav(PCM, 1, fs_hz, 16, &pcm16(samples)))
    }

    /// One channel of 32-bit float.
    #[must_use]
    pub fn float(&self, name: &str, fs_hz: u32, samples: &[f32]) -> PathBuf {
        let data: Vec<u8> = samples.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.file(name, &wav(FLOAT, 1, fs_hz, 32, &data))
    }

    /// Raw 64-bit floats.
    #[must_use]
    pub fn raw(&self, name: &str, samples: &[f64]) -> PathBuf {
        let data: Vec<u8> = samples.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.file(name, &data)
    }
}

/// Format tag of integer samples.
pub const PCM: u16 = 1;
/// Format tag of floating-point samples.
pub const FLOAT: u16 = 3;
/// Bytes before the samples in a file of [`wav`].
pub const HEADER: usize = 44;

/// A WAV file, byte for byte, whatever nonsense its header says.
#[must_use]
pub fn wav(tag: u16, channels: u16, fs_hz: u32, bits: u16, data: &[u8]) -> Vec<u8> {
    let length = u32::try_from(data.len()).expect("a short file");
    let frame = channels * bits.div_ceil(8);
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((length + 36).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16u32.to_le_bytes());
    bytes.extend(tag.to_le_bytes());
    bytes.extend(channels.to_le_bytes());
    bytes.extend(fs_hz.to_le_bytes());
    bytes.extend((fs_hz * u32::from(frame)).to_le_bytes());
    bytes.extend(frame.to_le_bytes());
    bytes.extend(bits.to_le_bytes());
    bytes.extend(b"data");
    bytes.extend(length.to_le_bytes());
    bytes.extend(data);
    bytes
}

/// Samples of ±1 as 16-bit integers, cut at full scale.
#[must_use]
pub fn pcm16(samples: &[f64]) -> Vec<u8> {
    let code = |x: &f64| (x * 32_768.0).round().clamp(-32_768.0, 32_767.0) as i16;
    samples.iter().flat_map(|x| code(x).to_le_bytes()).collect()
}
