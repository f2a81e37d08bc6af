//! The state of a model as bytes, for pickles.
//!
//! A mark with the version of the layout, then every number in little endian as it comes, then a
//! CRC-32 of all of it. Another version of this package may refuse it, and says so.

use crc::{CRC_32_ISO_HDLC, Crc};
use rarma_core::estimate::StateVisitor;

const MARK: &[u8; 8] = b"rarma\x00\x00\x01";
const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Writes numbers down.
pub struct Writer(Vec<u8>);

impl Writer {
    pub fn new() -> Self {
        Self(MARK.to_vec())
    }

    pub fn whole(&mut self, n: u64) {
        self.0.extend(n.to_le_bytes());
    }

    pub fn finish(mut self) -> Vec<u8> {
        let check = CHECK.checksum(&self.0);
        self.0.extend(check.to_le_bytes());
        self.0
    }
}

impl StateVisitor<f64> for Writer {
    fn number(&mut self, x: &mut f64) {
        self.0.extend(x.to_le_bytes());
    }

    fn count(&mut self, n: &mut u32) {
        self.0.extend(n.to_le_bytes());
    }
}

/// Puts them back.
pub struct Reader<'a> {
    rest: &'a [u8],
    short: bool,
}

impl<'a> Reader<'a> {
    /// None where the bytes are not what [`Writer`] gave.
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let (kept, check) = bytes.split_last_chunk()?;
        let whole = CHECK.checksum(kept) == u32::from_le_bytes(*check);
        let rest = kept.strip_prefix(MARK).filter(|_| whole)?;
        Some(Self { rest, short: false })
    }

    fn take<const BYTES: usize>(&mut self) -> [u8; BYTES] {
        match self.rest.split_first_chunk() {
            Some((first, rest)) => {
                self.rest = rest;
                *first
            }
            None => {
                self.short = true;
                [0; BYTES]
            }
        }
    }

    pub fn whole(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    /// Whether all of it was read and nothing was missing.
    pub fn is_used_up(&self) -> bool {
        self.rest.is_empty() && !self.short
    }
}

impl StateVisitor<f64> for Reader<'_> {
    fn number(&mut self, x: &mut f64) {
        *x = f64::from_le_bytes(self.take());
    }

    fn count(&mut self, n: &mut u32) {
        *n = u32::from_le_bytes(self.take());
    }
}
