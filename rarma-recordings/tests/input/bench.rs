//! Files to read: a directory for each test, and the bytes of a WAV.

use rarma_recordings::input::{self, InputError, ReadOptions, Recording};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// A directory that lives as long as the test.
pub struct Bench(pub TempDir);

impl Bench {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    pub fn read(&self, name: &str, bytes: &[u8]) -> Result<Recording, InputError> {
        self.with(name, bytes, &ReadOptions::default())
    }

    pub fn with(
        &self,
        name: &str,
        bytes: &[u8],
        opts: &ReadOptions,
    ) -> Result<Recording, InputError> {
        input::read(&self.file(name, bytes), opts)
    }

    /// The error, after a check of its shape.
    pub fn refused(&self, name: &str, bytes: &[u8], opts: &ReadOptions) -> InputError {
        let e = self.with(name, bytes, opts).unwrap_err();
        let text = e.to_string();
        assert!(!text.contains('\n'), "{text}");
        assert!(text.contains(&format!("{name}: {}: ", e.place)), "{text}");
        assert!(text.ends_with(&format!("({})", e.remedy)), "{text}");
        assert!(!e.place.is_empty() && !e.what.is_empty() && !e.remedy.is_empty());
        e
    }
}

pub fn opts() -> ReadOptions {
    ReadOptions::default()
}

pub fn at(fs: f64) -> ReadOptions {
    ReadOptions {
        fs: Some(fs),
        ..opts()
    }
}

pub fn fmt(tag: u16, channels: u16, rate: u32, bits: u16) -> Vec<u8> {
    let frame = channels * bits.div_ceil(8);
    let mut b = Vec::new();
    b.extend(tag.to_le_bytes());
    b.extend(channels.to_le_bytes());
    b.extend(rate.to_le_bytes());
    b.extend(rate.wrapping_mul(frame.into()).to_le_bytes());
    b.extend(frame.to_le_bytes());
    b.extend(bits.to_le_bytes());
    b
}

pub fn chunk(id: &[u8; 4], body: &[u8]) -> Vec<u8> {
    let mut b = id.to_vec();
    b.extend((body.len() as u32).to_le_bytes());
    b.extend(body);
    if body.len() % 2 == 1 {
        b.push(0);
    }
    b
}

pub fn riff(chunks: &[Vec<u8>]) -> Vec<u8> {
    let body: Vec<u8> = chunks.concat();
    let mut b = b"RIFF".to_vec();
    b.extend((body.len() as u32 + 4).to_le_bytes());
    b.extend(b"WAVE");
    b.extend(body);
    b
}

pub fn wav(tag: u16, channels: u16, rate: u32, bits: u16, data: &[u8]) -> Vec<u8> {
    riff(&[
        chunk(b"fmt ", &fmt(tag, channels, rate, bits)),
        chunk(b"data", data),
    ])
}

pub fn pcm16(samples: &[i16]) -> Vec<u8> {
    samples.iter().flat_map(|s| s.to_le_bytes()).collect()
}

/// A healthy 16 bit tone.
pub fn tone(n: usize) -> Vec<i16> {
    (0..n)
        .map(|i| (9000.0 * (i as f64 * 0.7).sin()) as i16)
        .collect()
}
