//! Where everything lies: a file is segments in a row, each a lead-in of 28 bytes, what is new of its
//! objects, and raw data in chunks that repeat until the segment ends.
//!
//! Only the lead-ins and what they announce is read; a length is never believed beyond the file.

use super::bytes::Bytes;
use super::kind::Kind;
use super::layout::{BIG_END, CARD, Part, Segment, place};
use super::object::Object;
use super::{InputError, Problem, Source};
use crate::input::content::Content;
use crate::input::whole::MOST_TABLE;
use std::collections::HashMap;
use std::io::SeekFrom;

/// Bytes of a lead-in.
const LEAD_IN: u64 = 28;
/// Bits of a lead-in: it says something of objects; the list of objects is a new one; it has raw data.
const SAYS: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
/// Instead of the length of what is said of an object's raw data: none; as before; of a card.
const NO_RAW: u32 = u32::MAX;
const AS_BEFORE: u32 = 0;
const OF_A_CARD: [u32; 2] = [0x1269, 0x126a];

/// All that is said of a file.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Everything that has a path, in order of appearance.
    pub(super) objects: Vec<Object>,
    /// Where it is not whole, a sentence each.
    pub(super) notices: Vec<String>,
    /// The end is missing.
    pub(super) is_cut: bool,
}

/// What goes on from one segment to the next.
#[derive(Default)]
struct Reader {
    index: Index,
    places: HashMap<String, usize>,
    /// Raw data of each object as it was said last.
    raw: HashMap<usize, Part>,
    /// Objects of the list, whether they have raw data now, and where each stands.
    list: Vec<(usize, bool)>,
    listed: HashMap<usize, usize>,
    /// Those of the list whose chunks are not empty.
    parts: Vec<Part>,
}

/// Reads all of it but the samples.
///
/// # Errors
/// It is none, or holds what is not read here.
pub(super) fn read(source: &mut dyn Source, length: u64) -> Result<Index, InputError> {
    let mut reader = Reader::default();
    let (mut from, mut number) = (0, 1);
    while from < length {
        let Some(segment) = reader.lead_in(source, from, number, length)? else {
            break;
        };
        if segment.bits & SAYS != 0 && !reader.says(source, &segment, length)? {
            break;
        }
        if segment.bits & RAW_DATA != 0 {
            let Reader { index, parts, .. } = &mut reader;
            place(&segment, parts, &mut index.objects)?;
        }
        from = segment.end;
        number += 1;
    }
    Ok(reader.index)
}

fn exactly(source: &mut dyn Source, from: u64, bytes: usize) -> Result<Vec<u8>, InputError> {
    let mut read = vec![0; bytes];
    let done = source.seek(SeekFrom::Start(from));
    let done = done.and_then(|_| source.read_exact(&mut read));
    done.map_err(|why| InputError::from_io(&why))?;
    Ok(read)
}

impl Reader {
    /// The lead-in at `from`; none where the file is cut there.
    fn lead_in(
        &mut self,
        source: &mut dyn Source,
        from: u64,
        number: usize,
        length: u64,
    ) -> Result<Option<Segment>, InputError> {
        let here = (length - from).min(LEAD_IN) as usize;
        let head = exactly(source, from, here)?;
        let tag = head.get(..4).unwrap_or(&head);
        if !b"TDSm".starts_with(tag) {
            return Err(no_segment(&head, from, number));
        }
        let mut all = Bytes::new(&head, false);
        let read = (|| {
            all.take(4)?;
            let bits = all.u32()?;
            all.big = bits & BIG_END != 0;
            let _version = all.u32()?;
            Some((bits, all.u64()?, all.u64()?))
        })();
        let Some((bits, next, raw)) = read else {
            self.cut(number, from, "lead-in")?;
            return Ok(None);
        };
        let begin = from + LEAD_IN;
        // Who writes does not know yet where the segment ends.
        let end = match next {
            u64::MAX => length,
            _ => begin.saturating_add(next),
        };
        let raw = begin.saturating_add(raw);
        if raw > end && next != u64::MAX {
            return Err(InputError::new(
                Problem::Header,
                format!("segment {number}, byte {from}"),
                "its samples begin behind its end",
                "copy or export the file again",
            ));
        }
        if raw > length {
            self.cut(number, from, "description of its channels")?;
            return Ok(None);
        }
        if next == u64::MAX {
            self.index.is_cut = true;
            let what = format!(
                "segment {number} was never closed by who wrote it: read as far as it goes"
            );
            self.index.notices.push(what);
        } else if end > length {
            self.index.is_cut = true;
            let what = format!(
                "the file ends {} bytes before segment {number} does: read as far as it goes",
                end - length
            );
            self.index.notices.push(what);
        }
        Ok(Some(Segment {
            number,
            from,
            raw,
            end: end.min(length),
            bits,
        }))
    }

    /// The file ends in the middle of what describes samples: they are left out, unless there are
    /// no others.
    fn cut(&mut self, number: usize, from: u64, what: &str) -> Result<(), InputError> {
        if number == 1 {
            return Err(InputError::new(
                Problem::Truncated,
                format!("segment 1, byte {from}"),
                format!("the file ends inside the {what}"),
                "copy it again",
            ));
        }
        self.index.is_cut = true;
        self.index.notices.push(format!(
            "the file ends inside the {what} of segment {number}: what is before it was read"
        ));
        Ok(())
    }

    /// What a segment says of its objects; false where the file ends in it.
    fn says(
        &mut self,
        source: &mut dyn Source,
        segment: &Segment,
        length: u64,
    ) -> Result<bool, InputError> {
        let begin = segment.from + LEAD_IN;
        let bytes = segment.raw.min(length) - begin;
        if bytes > MOST_TABLE {
            return Err(InputError::new(
                Problem::Size,
                format!("segment {}", segment.number),
                format!("{bytes} bytes that describe channels"),
                "check that it is the right file",
            ));
        }
        let said = exactly(source, begin, bytes as usize)?;
        let mut bytes = Bytes::new(&said, segment.bits & BIG_END != 0);
        if segment.bits & NEW_LIST != 0 {
            self.list.clear();
            self.listed.clear();
        }
        let count = bytes.u32();
        let broken = |bytes: &Bytes<'_>| {
            InputError::new(
                Problem::Header,
                format!(
                    "segment {}, byte {}",
                    segment.number,
                    begin + bytes.at as u64
                ),
                "what describes the channels breaks off",
                "copy or export the file again",
            )
        };
        for _ in 0..count.ok_or_else(|| broken(&bytes))? {
            match self.object(&mut bytes, segment.number) {
                Some(done) => done?,
                None => return Err(broken(&bytes)),
            }
        }
        self.parts.clear();
        for (object, has_raw) in &self.list {
            let part = self
                .raw
                .get(object)
                .filter(|part| *has_raw && part.bytes > 0);
            self.parts.extend(part);
        }
        Ok(true)
    }

    /// The next object; none where the bytes end.
    fn object(&mut self, bytes: &mut Bytes<'_>, segment: usize) -> Option<Result<(), InputError>> {
        let path = bytes.text()?;
        let object = match self.places.get(&path) {
            Some(object) => *object,
            None => {
                self.index.objects.push(Object::of(&path));
                let object = self.index.objects.len() - 1;
                self.places.insert(path.clone(), object);
                object
            }
        };
        let place = format!("segment {segment}, {path}");
        let refused = |what: String, remedy: &str| {
            Some(Err(InputError::new(
                Problem::Unsupported,
                place.as_str(),
                what,
                remedy,
            )))
        };
        let has_raw = match bytes.u32()? {
            NO_RAW => false,
            AS_BEFORE if self.raw.contains_key(&object) => true,
            AS_BEFORE => {
                return Some(Err(InputError::new(
                    Problem::Header,
                    place,
                    "its samples are as before, and there were none",
                    "copy or export the file again",
                )));
            }
            length if OF_A_CARD.contains(&length) => return refused(CARD.0.to_owned(), CARD.1),
            _ => {
                let code = bytes.u32()?;
                let Some(kind) = Kind::of(code) else {
                    return refused(
                        format!("samples of the type {code:#x} are not read"),
                        "export it as double precision",
                    );
                };
                let _dimension = bytes.u32()?;
                let count = bytes.u64()?;
                let size = match kind.size() {
                    Some(size) => count.checked_mul(size),
                    None => Some(bytes.u64()?),
                };
                let known = self.index.objects.get_mut(object)?;
                if known.count > 0 && known.kind.is_some_and(|before| before != kind) {
                    return refused(
                        "its samples change their type".to_owned(),
                        "export it again, in one type",
                    );
                }
                known.kind = Some(kind);
                let bytes = size?;
                let part = Part {
                    object,
                    kind,
                    count,
                    bytes,
                };
                self.raw.insert(object, part);
                true
            }
        };
        let place_of = *self.listed.entry(object).or_insert(self.list.len());
        match self.list.get_mut(place_of) {
            Some((_, has)) => *has = has_raw,
            None => self.list.push((object, has_raw)),
        }
        for _ in 0..bytes.u32()? {
            let name = bytes.text()?;
            match bytes.property()? {
                Ok(value) => self.index.objects.get_mut(object)?.set(&name, value),
                Err(code) => {
                    return refused(
                        format!(
                            "the property '{name}' is of the type {code:#x}, which is not read"
                        ),
                        "export it without that property",
                    );
                }
            }
        }
        Some(Ok(()))
    }
}

fn no_segment(head: &[u8], from: u64, number: usize) -> InputError {
    if head.starts_with(b"TDSh") {
        return InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "the index beside a TDMS file, which holds no samples",
            "name the file that ends in .tdms",
        );
    }
    if number == 1 {
        let content = Content::of(head);
        return InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            match content {
                Some(content) => format!("not a TDMS file but {}", content.name()),
                None => "not a TDMS file, which begins with TDSm".to_owned(),
            },
            content.map_or("name a recording".to_owned(), Content::remedy),
        );
    }
    InputError::new(
        Problem::Header,
        format!("segment {number}, byte {from}"),
        "no segment begins here",
        "copy or export the file again",
    )
}
