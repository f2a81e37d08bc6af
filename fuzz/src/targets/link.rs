//! Frames: any bytes on the wire, and any body in a sound frame.

use crate::{Target, check};
use rarma_box::wire::{Command, Deframer, Head, MAX_FRAME, Telemetry, decode, encode, head};
use rarma_cli::frames::Teller;
use rarma_recordings::FrameReader;
use rarma_recordings::raw_streams::{Piece as RawPiece, RawStreams};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde::ser::SerializeTuple;
use std::convert::Infallible;

pub(super) const FRAMES: Target = Target {
    name: "frames",
    reads: "frames, and bodies of telemetry and commands",
    run: |bytes| {
        let _ = head(bytes);
        let _ = decode::<Command>(bytes);
        let _ = decode::<Telemetry>(bytes);
        stream(bytes);
        if let Some(frame) = framed(bytes, SESSION, 0) {
            let stuffed = &frame[..frame.len() - 1];
            if let Ok((head, message)) = decode::<Telemetry>(stuffed) {
                told(&mut Told::default(), head, &message);
                there_and_back(&message);
            }
            if let Ok((_, command)) = decode::<Command>(stuffed) {
                there_and_back(&command);
            }
        }
    },
    words: head_words,
};

/// The session of frames made here.
pub(super) const SESSION: u32 = 0x0102_0304;

/// What every frame begins with, and its end.
pub(super) fn head_words() -> Vec<String> {
    let versions = (4..8).map(|version| format!("RA{}", char::from(version)));
    versions.chain(["\0".to_owned()]).collect()
}

/// A piece of what goes over a link.
pub(super) enum Piece<'a> {
    /// As it is.
    Bytes(&'a [u8]),
    /// The body of a sound frame.
    Body(&'a [u8]),
    /// Nothing for so many milliseconds.
    Pause(u8),
}

/// A case as pieces: how (0 bytes, 1 a body, 2 a pause), how many bytes, the bytes.
pub(super) fn pieces(mut case: &[u8]) -> Vec<Piece<'_>> {
    let mut out = Vec::new();
    while let [how, length, after @ ..] = case {
        let (piece, left) = after.split_at(usize::from(*length).min(after.len()));
        case = left;
        out.push(match how % 3 {
            0 => Piece::Bytes(piece),
            1 => Piece::Body(piece),
            _ => Piece::Pause(length % 4),
        });
    }
    out
}

/// The frame of a body of any bytes; none if it is too long.
pub(super) fn framed(body: &[u8], session: u32, sequence: u32) -> Option<Vec<u8>> {
    struct Body<'a>(&'a [u8]);
    impl Serialize for Body<'_> {
        fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            let mut bytes = to.serialize_tuple(self.0.len())?;
            for byte in self.0 {
                bytes.serialize_element(byte)?;
            }
            bytes.end()
        }
    }
    let mut buffer = [0; MAX_FRAME];
    let frame = encode(&Body(body), session, sequence, &mut buffer);
    frame.ok().map(<[u8]>::to_vec)
}

/// Encoded and decoded, a message has the same bytes again: not the same values, because NaN
/// is not equal to itself.
pub(super) fn there_and_back<M: Serialize + DeserializeOwned>(message: &M) {
    let (mut once, mut twice) = ([0; MAX_FRAME], [0; MAX_FRAME]);
    let frame = encode(message, SESSION, 7, &mut once).expect("what was framed has room");
    let (head, read) = decode::<M>(&frame[..frame.len() - 1]).expect("a sound frame");
    assert_eq!((head.session, head.sequence), (SESSION, 7));
    assert_eq!(encode(&read, SESSION, 7, &mut twice), Ok(frame));
}

/// Any bytes, in pieces of any size, and a sound frame after them: that one is read.
fn stream(bytes: &[u8]) {
    let mut raw = RawStreams::default();
    let mut reader = FrameReader::default();
    let mut tellers = Told::default();
    reader.take(bytes, |head, message| {
        let taken: Result<(), Infallible> = raw.take(head.session, &message, |piece| {
            if let RawPiece::End(stream) = piece {
                check::one_line(&stream.words());
            }
            Ok(())
        });
        let Ok(()) = taken;
        told(&mut tellers, head, &message);
    });
    if let Some(losses) = reader.losses() {
        check::one_line(&losses);
    }
    if let Some(stream) = raw.now() {
        check::one_line(&stream.words());
    }
    let mut deframer = Deframer::default();
    let mut last = None;
    let good = framed_command();
    for &byte in bytes.iter().chain(&[0]).chain(&good) {
        if let Some(result) = deframer.push::<Command>(byte) {
            last = Some(result);
        }
    }
    assert!(matches!(last, Some(Ok((_, Command::Identify)))), "{last:?}");
}

fn framed_command() -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let frame = encode(&Command::Identify, SESSION, 77, &mut buffer);
    frame.expect("a small command").to_vec()
}

/// One that tells in words, and one in JSON.
#[derive(Default)]
struct Told([Teller; 2]);

fn told(Told([in_words, in_json]): &mut Told, head: Head, message: &Telemetry) {
    if let Some(text) = in_words.words(message) {
        check::one_line(&text);
    }
    check::one_line(&in_json.json(head, message));
}
