//! Frames: how a message travels over a byte link.
//!
//! ```text
//! COBS( magic "RA" | version u8 | session u32 LE | sequence u32 LE | postcard body | seal | CRC-16 LE ) 0x00
//! ```
//!
//! The zero byte ends a frame and occurs nowhere else, so a receiver that starts
//! in the middle, or loses bytes, is back in step at the next frame. The CRC is
//! CRC-16/IBM-SDLC over everything before it. The session is the number of one run of the
//! box, drawn at its start: frames of two runs are never taken for one stream, and a command
//! is for the run it names. A sequence number that jumps tells of lost frames. The seal, of
//! 16 bytes or none, is the host's only.

use super::command::Order;
use crate::key::{LinkKey, SEAL_BYTES, Seal};
use crc::{CRC_16_IBM_SDLC, Crc};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// First two bytes of every frame.
pub const MAGIC: [u8; 2] = *b"RA";
/// Version of the messages; a receiver refuses any other by name.
pub const VERSION: u8 = 5;
/// Longest frame on the wire, bytes, the closing zero included.
pub const MAX_FRAME: usize = 320;
/// Longest frame before it is stuffed.
const MAX_PLAIN: usize = MAX_FRAME - 4;
const HEAD: usize = 11;
/// The part of the head that every version has: magic and version.
const VERSIONED: usize = 3;
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_SDLC);

/// No session: what a host says that does not know the box's yet. No box draws it.
pub const NO_SESSION: u32 = 0;

/// Why bytes are not a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// The message does not fit into [`MAX_FRAME`].
    TooLong,
    /// Shorter than the head and the CRC.
    TooShort,
    /// The byte stuffing is broken: bytes were lost or garbled.
    Stuffing,
    /// Does not start with [`MAGIC`].
    Magic,
    /// Made by another version of the protocol.
    Version {
        /// Version in the frame.
        found: u8,
    },
    /// The CRC does not match.
    Crc,
    /// The body is not a message of this kind.
    Body,
}

/// Writes one frame of a session into `out` and returns its bytes, the closing zero included.
///
/// # Errors
/// [`FrameError::TooLong`] if the message does not fit.
pub fn encode<'a, M: Serialize>(
    message: &M,
    session: u32,
    sequence: u32,
    out: &'a mut [u8; MAX_FRAME],
) -> Result<&'a [u8], FrameError> {
    write(message, session, sequence, None, out)
}

/// The same for a command, sealed if there is a key.
///
/// # Errors
/// [`FrameError::TooLong`] if the command does not fit.
pub fn encode_order<'a>(
    order: &Order,
    session: u32,
    sequence: u32,
    key: Option<&LinkKey>,
    out: &'a mut [u8; MAX_FRAME],
) -> Result<&'a [u8], FrameError> {
    write(order, session, sequence, key, out)
}

fn write<'a, M: Serialize>(
    message: &M,
    session: u32,
    sequence: u32,
    key: Option<&LinkKey>,
    out: &'a mut [u8; MAX_FRAME],
) -> Result<&'a [u8], FrameError> {
    // Checked access throughout: this runs where a panic would stop the samples.
    let long = FrameError::TooLong;
    let mut plain = [0u8; MAX_PLAIN];
    let ([r0, r1, r2, r3], [s0, s1, s2, s3]) = (session.to_le_bytes(), sequence.to_le_bytes());
    let (head, body) = plain.split_first_chunk_mut::<HEAD>().ok_or(long)?;
    let [m0, m1] = MAGIC;
    *head = [m0, m1, VERSION, r0, r1, r2, r3, s0, s1, s2, s3];
    let tail = if key.is_some() { SEAL_BYTES + 2 } else { 2 };
    let room = body.get_mut(..MAX_PLAIN - HEAD - tail).ok_or(long)?;
    let mut used = HEAD + postcard::to_slice(message, room).map_err(|_| long)?.len();
    if let Some(key) = key {
        let seal = plain
            .get(..used)
            .and_then(|signed| key.seal(signed))
            .ok_or(long)?;
        let place = plain.get_mut(used..used + SEAL_BYTES).ok_or(long)?;
        place.copy_from_slice(&seal);
        used += SEAL_BYTES;
    }
    let crc = CRC.checksum(plain.get(..used).ok_or(long)?);
    let place = plain.get_mut(used..used + 2).ok_or(long)?;
    for (place, byte) in place.iter_mut().zip(crc.to_le_bytes()) {
        *place = byte;
    }
    let content = plain.get(..used + 2).ok_or(long)?;
    let room = out.get_mut(..MAX_FRAME - 1).ok_or(long)?;
    let stuffed = cobs::try_encode(content, room).map_err(|_| long)?;
    *out.get_mut(stuffed).ok_or(long)? = 0;
    out.get(..=stuffed).ok_or(long)
}

/// Reads one frame without its closing zero; returns its head and the message.
///
/// # Errors
/// See [`FrameError`]; the bytes are garbled, of another version or another kind.
pub fn decode<M: DeserializeOwned>(stuffed: &[u8]) -> Result<(Head, M), FrameError> {
    let mut plain = [0u8; MAX_FRAME];
    let content = unwrapped(stuffed, &mut plain)?;
    let head = Head::of(content)?;
    if head.version != VERSION {
        return Err(FrameError::Version {
            found: head.version,
        });
    }
    let body = content.get(HEAD..).ok_or(FrameError::TooShort)?;
    let message = postcard::from_bytes(body).map_err(|_| FrameError::Body)?;
    Ok((head, message))
}

/// What can be told of a frame that is whole (its CRC matches), whatever its body is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Head {
    /// Version of the messages.
    pub version: u8,
    /// The run of the box it belongs to; 0 in a frame of another version.
    pub session: u32,
    /// Sequence number; 0 in a frame of another version.
    pub sequence: u32,
    /// CRC of everything before it: tells a doubled frame from a new one.
    pub crc: u16,
}

impl Head {
    fn of(content: &[u8]) -> Result<Self, FrameError> {
        match *content {
            [_, _, version, ..] if version != VERSION => Ok(Self {
                version,
                session: NO_SESSION,
                sequence: 0,
                crc: CRC.checksum(content),
            }),
            [_, _, version, r0, r1, r2, r3, s0, s1, s2, s3, ..] => Ok(Self {
                version,
                session: u32::from_le_bytes([r0, r1, r2, r3]),
                sequence: u32::from_le_bytes([s0, s1, s2, s3]),
                crc: CRC.checksum(content),
            }),
            _ => Err(FrameError::TooShort),
        }
    }
}

/// Reads the head of a frame without its closing zero.
///
/// # Errors
/// The bytes are no whole frame of any version.
pub fn head(stuffed: &[u8]) -> Result<Head, FrameError> {
    let mut plain = [0u8; MAX_FRAME];
    Head::of(unwrapped(stuffed, &mut plain)?)
}

/// A whole frame of the host, not stuffed any more.
#[derive(Debug)]
pub struct Opened<'a> {
    /// Its head.
    pub head: Head,
    content: &'a [u8],
}

/// Reads a frame of the host without its closing zero, into `plain`.
///
/// # Errors
/// The bytes are no whole frame of any version.
pub fn open<'a>(stuffed: &[u8], plain: &'a mut [u8; MAX_FRAME]) -> Result<Opened<'a>, FrameError> {
    let content = unwrapped(stuffed, plain)?;
    let head = Head::of(content)?;
    Ok(Opened { head, content })
}

impl<'a> Opened<'a> {
    /// Its command, and what stands behind it.
    ///
    /// # Errors
    /// It is of another version, or no command.
    pub fn order(&self) -> Result<(Order, Seal<'a>), FrameError> {
        if self.head.version != VERSION {
            return Err(FrameError::Version {
                found: self.head.version,
            });
        }
        let body = self.content.get(HEAD..).ok_or(FrameError::TooShort)?;
        let (order, seal) = postcard::take_from_bytes(body).map_err(|_| FrameError::Body)?;
        if !(seal.is_empty() || seal.len() == SEAL_BYTES) {
            return Err(FrameError::Body);
        }
        let end = self.content.len() - seal.len();
        let signed = self.content.get(..end).ok_or(FrameError::TooShort)?;
        Ok((order, Seal { signed, seal }))
    }
}

/// Head and body of a whole frame, without its CRC.
fn unwrapped<'a>(stuffed: &[u8], plain: &'a mut [u8; MAX_FRAME]) -> Result<&'a [u8], FrameError> {
    if stuffed.len() > MAX_FRAME {
        return Err(FrameError::TooLong);
    }
    let n = cobs::decode(stuffed, plain)
        .map_err(|_| FrameError::Stuffing)?
        .frame_size();
    let plain = plain.get(..n).ok_or(FrameError::Stuffing)?;
    if plain.len() < VERSIONED + 2 {
        return Err(FrameError::TooShort);
    }
    let (content, crc) = plain.split_at(plain.len() - 2);
    if content[..2] != MAGIC {
        return Err(FrameError::Magic);
    }
    if CRC.checksum(content).to_le_bytes() != crc {
        return Err(FrameError::Crc);
    }
    Ok(content)
}

/// Collects bytes from a link until a frame is complete.
#[derive(Debug, Clone)]
pub struct Deframer {
    buffer: [u8; MAX_FRAME],
    used: usize,
    overrun: bool,
}

impl Default for Deframer {
    fn default() -> Self {
        Self {
            buffer: [0; MAX_FRAME],
            used: 0,
            overrun: false,
        }
    }
}

impl Deframer {
    /// Takes one byte; at the end of a frame, gives what it held. A frame longer
    /// than [`MAX_FRAME`] is dropped as a whole and reported as too long.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<(Head, M), FrameError>> {
        self.collect(byte).map(|stuffed| decode(stuffed?))
    }

    /// Takes one byte; at the end of a frame, gives its bytes as they came, without the
    /// closing zero.
    ///
    /// # Errors
    /// Inside: the frame was longer than [`MAX_FRAME`].
    pub fn collect(&mut self, byte: u8) -> Option<Result<&[u8], FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.used) {
                Some(place) => {
                    *place = byte;
                    self.used += 1;
                }
                None => self.overrun = true,
            }
            return None;
        }
        let (used, overrun) = (self.used, self.overrun);
        self.used = 0;
        self.overrun = false;
        if overrun {
            return Some(Err(FrameError::TooLong));
        }
        if used == 0 {
            return None;
        }
        self.buffer.get(..used).map(Ok)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{AlarmMessage, Telemetry};
    use proptest::prelude::*;

    fn message(sample: u64) -> Telemetry {
        Telemetry::Alarm(AlarmMessage {
            sample,
            on: true,
            frequency: 898.6,
            damping: 0.003,
        })
    }

    #[test]
    fn round_trip_and_refusals() {
        let mut out = [0; MAX_FRAME];
        let frame = encode(&message(7), 0xAB00_CDEF, 0x1_002A, &mut out)
            .unwrap()
            .to_vec();
        assert_eq!(frame.iter().filter(|&&b| b == 0).count(), 1);
        let stuffed = &frame[..frame.len() - 1];
        let (head, back) = decode::<Telemetry>(stuffed).unwrap();
        assert_eq!(back, message(7));
        assert_eq!((head.version, head.session), (VERSION, 0xAB00_CDEF));
        assert_eq!(head.sequence, 0x1_002A);
        assert_eq!(super::head(stuffed), Ok(head));

        let mut plain = vec![0; 400];
        let n = cobs::decode(stuffed, &mut plain).unwrap().frame_size();
        plain.truncate(n);
        let restuff = |plain: &[u8]| {
            let mut out = vec![0; 500];
            let n = cobs::encode(plain, &mut out);
            out.truncate(n);
            out
        };
        let mut other = plain.clone();
        other[2] = 9;
        let end = other.len() - 2;
        let crc = CRC.checksum(&other[..end]).to_le_bytes();
        other[end..].copy_from_slice(&crc);
        let refused = decode::<Telemetry>(&restuff(&other));
        assert_eq!(refused, Err(FrameError::Version { found: 9 }));
        let mut flipped = plain.clone();
        flipped[8] ^= 1;
        assert_eq!(
            decode::<Telemetry>(&restuff(&flipped)),
            Err(FrameError::Crc)
        );
        assert_eq!(decode::<Telemetry>(&[1]), Err(FrameError::TooShort));

        // A frame of version 4 is shorter than a head of this one, and is refused by name.
        let mut old = b"RA\x04\x07\x00\x00".to_vec();
        let crc = CRC.checksum(&old).to_le_bytes();
        old.extend(crc);
        let old = restuff(&old);
        assert_eq!(super::head(&old).unwrap().version, 4);
        let refused = decode::<Telemetry>(&old);
        assert_eq!(refused, Err(FrameError::Version { found: 4 }));
    }

    proptest! {
        #[test]
        fn any_bytes_are_survived_and_the_next_frame_is_read(
            garbage in proptest::collection::vec(any::<u8>(), 0..900)
        ) {
            let mut out = [0; MAX_FRAME];
            let frame = encode(&message(1), 77, 2, &mut out).unwrap();
            let mut deframer = Deframer::default();
            let mut last = None;
            for &b in garbage.iter().chain(&[0]).chain(frame) {
                if let Some(result) = deframer.push::<Telemetry>(b) {
                    last = Some(result);
                }
            }
            let (head, back) = last.unwrap().unwrap();
            prop_assert_eq!(((head.session, head.sequence), back), ((77, 2), message(1)));
        }

        #[test]
        fn a_cut_frame_is_never_taken_for_a_message(cut in 1usize..30) {
            let mut out = [0; MAX_FRAME];
            let frame = encode(&message(3), 77, 5, &mut out).unwrap();
            let keep = frame.len().saturating_sub(1 + cut);
            prop_assert!(decode::<Telemetry>(&frame[..keep]).is_err());
        }
    }
}
