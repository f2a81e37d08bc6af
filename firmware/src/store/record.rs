//! A record of the store: self-contained, in whole words of eight bytes.
//!
//! ```text
//! byte  0..4   order << 6 | length of the value     the newest save has the greatest order
//!       4..6   number                               of the setting; PAGE heads a page
//!       6..    value, 1 to 40 bytes, then zeros
//!       last 4 CRC-32 of all before it
//! ```
//!
//! A value of six bytes, one setting's, takes sixteen. An erased word is no record, and
//! neither is one of zeros.

use crc::{CRC_32_ISO_HDLC, Crc};

/// Most bytes of a value.
pub const VALUE_BYTES: usize = 40;
/// Bytes of a word: what every known flash writes at once, or a multiple of it.
pub(super) const WORD: usize = 8;
/// Number of the record at the beginning of a page in use; its order counts pages.
pub(super) const PAGE: u16 = 0xFFFF;
/// The greatest order: six times what the flash lasts.
pub(super) const MOST_ORDER: u32 = (1 << (32 - LENGTH_BITS)) - 1;

const LENGTH_BITS: u32 = 6;
const HEAD: usize = 6;
const CHECK: usize = 4;
/// Most bytes of a record.
pub(super) const RECORD_MOST: usize = size(VALUE_BYTES);
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of a record with a value of so many.
pub(super) const fn size(length: usize) -> usize {
    (HEAD + length + CHECK).next_multiple_of(WORD)
}

/// What the first word of a record says; true only if the whole record is sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Claim {
    pub order: u32,
    pub number: u16,
    length: usize,
}

impl Claim {
    /// Of nothing: older than every record.
    pub const NONE: Self = Self {
        order: 0,
        number: PAGE,
        length: 1,
    };

    /// None if no record begins like this.
    pub fn of(word: [u8; WORD]) -> Option<Self> {
        let [a, b, c, d, e, f, _, _] = word;
        let tag = u32::from_le_bytes([a, b, c, d]);
        let length = (tag & ((1 << LENGTH_BITS) - 1)) as usize;
        (1..=VALUE_BYTES).contains(&length).then_some(Self {
            order: tag >> LENGTH_BITS,
            number: u16::from_le_bytes([e, f]),
            length,
        })
    }

    /// Bytes of the record.
    pub fn size(self) -> usize {
        size(self.length)
    }

    /// Whether the bytes that begin like this are a sound record.
    pub fn is_sound(self, bytes: &[u8]) -> bool {
        let record = bytes.get(..self.size());
        let parts = record.and_then(<[u8]>::split_last_chunk::<CHECK>);
        parts.is_some_and(|(body, check)| CRC.checksum(body) == u32::from_le_bytes(*check))
    }
}

/// A sound record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record {
    pub claim: Claim,
    bytes: [u8; RECORD_MOST],
}

impl Record {
    /// None if the value is empty or too long, or the orders have come to their end.
    pub fn new(number: u16, order: u32, value: &[u8]) -> Option<Self> {
        let length = value.len();
        if length > VALUE_BYTES || order > MOST_ORDER {
            return None;
        }
        let mut bytes = [0; RECORD_MOST];
        let tag = order << LENGTH_BITS | length as u32;
        bytes.get_mut(..4)?.copy_from_slice(&tag.to_le_bytes());
        bytes
            .get_mut(4..HEAD)?
            .copy_from_slice(&number.to_le_bytes());
        bytes.get_mut(HEAD..HEAD + length)?.copy_from_slice(value);
        let end = size(length);
        let check = CRC.checksum(bytes.get(..end - CHECK)?);
        bytes
            .get_mut(end - CHECK..end)?
            .copy_from_slice(&check.to_le_bytes());
        Self::checked(bytes)
    }

    /// The record that these bytes begin with, if it is sound.
    pub fn checked(mut bytes: [u8; RECORD_MOST]) -> Option<Self> {
        let claim = Claim::of(*bytes.first_chunk()?)?;
        bytes.get_mut(claim.size()..)?.fill(0);
        claim.is_sound(&bytes).then_some(Self { claim, bytes })
    }

    /// The bytes, a whole number of words.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.claim.size()).unwrap_or_default()
    }

    /// The value.
    pub fn value(&self) -> &[u8] {
        let value = HEAD..HEAD + self.claim.length;
        self.bytes.get(value).unwrap_or_default()
    }
}
