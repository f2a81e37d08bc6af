//! Where the samples of a segment lie: channel after channel in chunks that repeat, or one of each in
//! turn.

use super::kind::Kind;
use super::object::{Object, Piece};
use super::{InputError, Problem};

/// Bits of a lead-in: one value of each channel in turn; big end first; as the card gave it.
const IN_TURN: u32 = 1 << 5;
pub(super) const BIG_END: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

/// Raw data of an object in the chunks of a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) object: usize,
    pub(super) kind: Kind,
    pub(super) count: u64,
    pub(super) bytes: u64,
}

/// Where a segment begins and ends.
pub(super) struct Segment {
    /// Counted from 1.
    pub(super) number: usize,
    pub(super) from: u64,
    pub(super) raw: u64,
    pub(super) end: u64,
    pub(super) bits: u32,
}

/// Where the samples of a segment lie.
pub(super) fn place(
    segment: &Segment,
    parts: &[Part],
    objects: &mut [Object],
) -> Result<(), InputError> {
    let refused = |what: &str, remedy: &str| {
        let place = format!("segment {}", segment.number);
        Err(InputError::new(Problem::Unsupported, place, what, remedy))
    };
    if segment.bits & DAQMX != 0 {
        return refused(CARD.0, CARD.1);
    }
    let raw = segment.end.saturating_sub(segment.raw);
    let sum = |all: u64, part: &Part| all.checked_add(part.bytes);
    let Some(chunk) = parts.iter().try_fold(0, sum).filter(|bytes| *bytes > 0) else {
        return Ok(());
    };
    let big = segment.bits & BIG_END != 0;
    if segment.bits & IN_TURN != 0 {
        let Some(sizes) = parts
            .iter()
            .map(|part| part.kind.size())
            .collect::<Option<Vec<_>>>()
        else {
            return refused(
                "text among interleaved samples is not read",
                "export it without",
            );
        };
        if parts.iter().any(|part| part.count != parts[0].count) {
            return refused(
                "interleaved channels of different lengths are not read",
                "export it again",
            );
        }
        let row: u64 = sizes.iter().sum();
        let count = raw / row;
        let mut at = segment.raw;
        for (part, size) in parts.iter().zip(sizes) {
            let piece = Piece {
                at,
                each: count,
                stride: row,
                chunk: raw,
                count,
                big,
            };
            keep(objects, part, piece);
            at += size;
        }
        return Ok(());
    }
    let (whole, mut left) = (raw / chunk, raw % chunk);
    let mut at = segment.raw;
    for part in parts {
        // Of a chunk that is cut short what is there, channel by channel.
        let here = left.min(part.bytes);
        left -= here;
        if whole == 0 && here == 0 {
            break;
        }
        if let Some(size) = part.kind.size() {
            let count = whole * part.count + here / size;
            let piece = Piece {
                at,
                each: part.count,
                stride: size,
                chunk,
                count,
                big,
            };
            keep(objects, part, piece);
        }
        // Of the last channels of a chunk that is cut short nothing is there, wherever they say they are.
        at = at.saturating_add(part.bytes);
    }
    Ok(())
}

/// Samples as a card's driver gave them.
pub(super) const CARD: (&str, &str) = (
    "raw data of a DAQmx card, which are not read",
    "save it again with scaled samples, in LabVIEW, DIAdem or FlexLogger",
);

fn keep(objects: &mut [Object], part: &Part, piece: Piece) {
    if let Some(object) = objects.get_mut(part.object).filter(|_| piece.count > 0) {
        object.count += piece.count;
        object.pieces.push(piece);
    }
}
