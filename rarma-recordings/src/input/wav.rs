//! WAV: a RIFF reader for recordings as they are found, not as they should be.
//!
//! `hound` reads neither 64 bit floats nor a file that ends before its data
//! chunk does, and a data logger that lost power leaves just that. It also
//! refuses the sizes 0 and 0xFFFFFFFF that streaming writers leave in the
//! header. So the few chunks that matter are walked here, every read is bounded
//! by the bytes there are, and what the header promised beyond them becomes a
//! notice. RF64 (the form for more than 4 GB) is read as well. A pipe has no length: a
//! size that a streaming writer may have left there is not believed.

use super::blocks::{Begin, Blocks, End};
use super::bytes::Bytes;
use super::content::Content;
use super::{InputError, Problem, no_channel, rate_of};

const PCM: u16 = 1;
const FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;

/// Sizes from here on are what streaming writers put where they do not know.
const UNKNOWN_SIZE: u32 = 0x7FFF_0000;

/// Bytes of a header chunk that are looked at.
const LONGEST: usize = 64;

/// How one channel's samples lie in the data.
#[derive(Debug, Clone, Copy)]
struct Layout {
    float: bool,
    channels: usize,
    rate: u32,
    /// Bytes of one sample of one channel.
    width: usize,
    /// Bits that carry signal, from the top.
    bits: u32,
    /// Bytes from frame to frame.
    frame: usize,
}

/// Frames handed on at once.
const BLOCK: usize = 1 << 12;

/// Reads up to the samples of a WAV file; `length` is that of the file, none for a pipe.
pub(super) fn begin(
    mut bytes: Bytes,
    length: Option<u64>,
    fs: Option<f64>,
) -> Result<Begin, InputError> {
    let size64 = magic(bytes.look(12)?)?;
    let riff_end = u64::from(u32_at(bytes.look(12)?, 4).unwrap_or(0)) + 8;
    bytes.take(12);
    let mut layout: Option<Layout> = None;
    let mut data64 = None;
    loop {
        let at = bytes.at();
        let head = bytes.look(8)?;
        let (Some(size), Some(id)) = (u32_at(head, 4), head.first_chunk::<4>().copied()) else {
            bytes.skip(u64::MAX)?;
            break;
        };
        bytes.take(8);
        let start = at + 8;
        let rest = length.map(|length| length.saturating_sub(start));
        match &id {
            b"ds64" if size64 => data64 = u64_at(bytes.look((size as usize).min(LONGEST))?, 8),
            b"fmt " => {
                layout = Some(parse_fmt(bytes.look((size as usize).min(LONGEST))?, at)?);
            }
            b"data" => {
                let Some(layout) = layout else {
                    return Err(header(at, "the data come before the fmt chunk"));
                };
                let told = match size {
                    // Zero and all ones: a writer that did not come back to fill it in.
                    u32::MAX => data64.filter(|n| (1..u64::MAX >> 1).contains(n)),
                    0 if riff_end <= start || riff_end > u64::from(u32::MAX) => None,
                    size if size >= UNKNOWN_SIZE
                        && rest.is_none_or(|rest| u64::from(size) > rest) =>
                    {
                        None
                    }
                    size => Some(u64::from(size)),
                };
                return samples(bytes, told, layout, at, fs);
            }
            _ => {}
        }
        if !bytes.skip(u64::from(size))? {
            break;
        }
        skip_padding(&mut bytes, size)?;
    }
    let missing = if layout.is_some() { "data" } else { "fmt" };
    Err(InputError::new(
        Problem::Truncated,
        format!("byte {}", bytes.at()),
        format!("the file ends before its {missing} chunk"),
        "copy it again; nothing can be saved from it",
    ))
}

/// Checks the first twelve bytes; true for RF64.
fn magic(bytes: &[u8]) -> Result<bool, InputError> {
    let not = |what: &str, remedy: &str| {
        Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            what,
            remedy,
        ))
    };
    let convert = "convert it to WAV, or correct the extension";
    let size64 = match bytes {
        b if b.len() < 4 && (b"RIFF".starts_with(b) || b"RF64".starts_with(b)) => false,
        [b'R', b'I', b'F', b'F', ..] => false,
        [b'R', b'F', b'6', b'4', ..] => true,
        _ => {
            return match Content::of(bytes) {
                Some(other) => not(
                    &format!("not a WAV file but {}", other.name()),
                    &other.remedy(),
                ),
                None => not("not a WAV file: it does not begin with RIFF", convert),
            };
        }
    };
    match bytes.get(8..12) {
        Some(b"WAVE") => Ok(size64),
        Some(_) => not("a RIFF file, but not a WAVE", convert),
        None => Err(InputError::new(
            Problem::Truncated,
            format!("byte {}", bytes.len()),
            "the file ends inside its first header",
            "copy it again; nothing can be saved from it",
        )),
    }
}

/// Odd chunks are padded to even length; some writers forget, which shows in a chunk
/// name right there.
fn skip_padding(bytes: &mut Bytes, size: u32) -> Result<(), InputError> {
    if size.is_multiple_of(2) {
        return Ok(());
    }
    let next = bytes.look(5)?;
    let name = |at: usize| {
        next.get(at..at + 4)
            .is_some_and(|n| n.iter().all(|c| (b' '..=b'~').contains(c)))
    };
    if !name(0) || name(1) {
        bytes.take(1);
    }
    Ok(())
}

fn parse_fmt(body: &[u8], at: u64) -> Result<Layout, InputError> {
    let word = |i| u16_at(body, i);
    let (Some(mut tag), Some(channels), Some(rate), Some(block), Some(bits)) =
        (word(0), word(2), u32_at(body, 4), word(12), word(14))
    else {
        return Err(InputError::new(
            Problem::Truncated,
            format!("fmt chunk (byte {at})"),
            format!("{} bytes, at least 16 are needed", body.len()),
            "copy it again; nothing can be saved from it",
        ));
    };
    let mut valid = bits;
    if tag == EXTENSIBLE {
        let (Some(v), Some(sub)) = (word(18), word(24)) else {
            return Err(header(at, "an extensible format without its extension"));
        };
        tag = sub;
        // Zero and nonsense both mean: all of them.
        valid = if v == 0 || v > bits { bits } else { v };
    }
    if channels == 0 {
        return Err(InputError::new(
            Problem::Channel,
            format!("fmt chunk (byte {at})"),
            "the header says 0 channels",
            "record again, or repair the header",
        ));
    }
    let channels = usize::from(channels);
    let width = usize::from(bits).div_ceil(8);
    let supported = match tag {
        PCM => (1..=4).contains(&width),
        FLOAT => bits == 32 || bits == 64,
        _ => false,
    };
    if !supported {
        return Err(InputError::new(
            Problem::Unsupported,
            format!("fmt chunk (byte {at})"),
            format!("{} with {bits} bits per sample", tag_name(tag)),
            "convert to PCM of 16, 24 or 32 bit, or to float",
        ));
    }
    // Some writers leave the frame size out. PCM may lie in wider containers.
    let frame = match usize::from(block) {
        0 => channels * width,
        block => block,
    };
    let container = frame / channels;
    let fits = frame % channels == 0
        && container >= width
        && container <= if tag == PCM { 4 } else { width };
    if !fits {
        return Err(header(
            at,
            &format!("frames of {frame} bytes do not fit {channels} channels of {bits} bits"),
        ));
    }
    Ok(Layout {
        float: tag == FLOAT,
        channels,
        rate,
        width: container,
        bits: u32::from(valid),
        frame,
    })
}

fn samples(
    bytes: Bytes,
    told: Option<u64>,
    layout: Layout,
    at: u64,
    fs: Option<f64>,
) -> Result<Begin, InputError> {
    let mut notices = Vec::new();
    let fs = rate_of("fmt chunk", layout.rate, fs, &mut notices)?;
    let kind = if layout.float { "float" } else { "PCM" };
    Ok(Begin {
        format: format!("WAV, {kind} {} bit", layout.bits),
        fs: Some(fs),
        step: (!layout.float).then(|| 2_f64.powi(1 - layout.bits as i32)),
        channels: layout.channels,
        blocks: Box::new(Data {
            bytes,
            told,
            layout,
            place: format!("data chunk (byte {at})"),
            fs,
            notices,
            channels: vec![0],
            used: 0,
        }),
    })
}

/// The data chunk.
struct Data {
    bytes: Bytes,
    /// Its length, if the header says it.
    told: Option<u64>,
    layout: Layout,
    place: String,
    fs: f64,
    notices: Vec<String>,
    channels: Vec<usize>,
    /// Bytes read.
    used: u64,
}

impl Blocks for Data {
    fn want(&mut self, channels: &[usize]) {
        self.channels = channels.to_vec();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        let frame = self.layout.frame;
        loop {
            let left = self.told.map_or(u64::MAX, |told| told - self.used);
            let here = (self.bytes.waiting().len() as u64).min(left) as usize;
            let whole = (here / frame).min(BLOCK) * frame;
            if whole > 0 {
                let data = &self.bytes.waiting()[..whole];
                for (row, channel) in rows.iter_mut().zip(&self.channels) {
                    let first = channel * self.layout.width;
                    let one =
                        |f: &[u8]| value(&f[first..first + self.layout.width], self.layout.float);
                    row.extend(data.chunks_exact(frame).map(one));
                }
                self.bytes.take(whole);
                self.used += whole as u64;
                return Ok(true);
            }
            // What is left of the chunk is less than a frame, or the source has ended.
            if left < frame as u64 || !self.bytes.more()? {
                self.used += (self.bytes.waiting().len() as u64).min(left);
                return Ok(false);
            }
        }
    }

    fn end(&mut self) -> Result<End, InputError> {
        let (used, frame) = (self.used, self.layout.frame as u64);
        let frames = used / frame;
        if frames == 0 {
            let (problem, what) = match self.told {
                Some(told) if told > used => (
                    Problem::Truncated,
                    format!("it says {told} bytes, but the file ends before one whole frame"),
                ),
                _ => (Problem::NoSamples, "it holds no samples".into()),
            };
            let place = self.place.as_str();
            return Err(InputError::new(problem, place, what, "record again"));
        }
        let seconds = frames as f64 / self.fs;
        let mut notices = std::mem::take(&mut self.notices);
        match self.told {
            None => notices.push(format!(
                "the header does not say how long the data are (streamed): \
                 analysed {frames} frames ({seconds:.2} s), up to the end of the file"
            )),
            Some(told) if told > used => notices.push(format!(
                "data chunk says {} frames, file holds {frames}: \
                 analysed {frames} ({seconds:.2} s), the rest is cut off",
                told / frame
            )),
            Some(_) if !used.is_multiple_of(frame) => notices.push(format!(
                "the data end inside a frame: analysed {frames} whole frames ({seconds:.2} s)"
            )),
            Some(_) => {}
        }
        Ok(End {
            fs: self.fs,
            notices,
        })
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        no_channel("fmt chunk", asked, channels)
    }
}

/// One sample; integers are left-aligned to 32 bits first, so that every width
/// and every number of valid bits shares one scale.
fn value(b: &[u8], float: bool) -> f64 {
    match *b {
        // 8 bit WAV is the one unsigned width, with 128 for zero.
        [a] => (f64::from(a) - 128.0) / 128.0,
        [a, b] => scaled([0, 0, a, b]),
        [a, b, c] => scaled([0, a, b, c]),
        [a, b, c, d] if float => f32::from_le_bytes([a, b, c, d]).into(),
        [a, b, c, d] => scaled([a, b, c, d]),
        [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        // Layout allows no other width.
        _ => 0.0,
    }
}

fn scaled(b: [u8; 4]) -> f64 {
    f64::from(i32::from_le_bytes(b)) / 2_f64.powi(31)
}

fn header(at: u64, what: &str) -> InputError {
    InputError::new(
        Problem::Header,
        format!("chunk at byte {at}"),
        what,
        "the header is damaged: record or convert again",
    )
}

fn tag_name(tag: u16) -> String {
    match tag {
        PCM => "integer PCM".into(),
        FLOAT => "float".into(),
        2 | 0x11 => "ADPCM compression".into(),
        6 => "A-law".into(),
        7 => "µ-law".into(),
        0x50 | 0x55 => "MPEG audio".into(),
        other => format!("format tag 0x{other:04X}"),
    }
}

fn u16_at(b: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(b.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(b: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(b.get(at..at + 4)?.try_into().ok()?))
}

fn u64_at(b: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(b.get(at..at + 8)?.try_into().ok()?))
}
