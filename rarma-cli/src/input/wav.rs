//! WAV: a RIFF reader for recordings as they are found, not as they should be.
//!
//! `hound` reads neither 64 bit floats nor a file that ends before its data
//! chunk does, and a data logger that lost power leaves just that. It also
//! refuses the sizes 0 and 0xFFFFFFFF that streaming writers leave in the
//! header. So the few chunks that matter are walked here, every read is bounded
//! by the bytes there are, and what the header promised beyond them becomes a
//! notice. RF64 (the form for more than 4 GB) is read as well.

use super::{Decoded, InputError, Problem, ReadOptions, no_channel};

const PCM: u16 = 1;
const FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;

/// Sizes from here on are what streaming writers put where they do not know.
const UNKNOWN_SIZE: u32 = 0x7FFF_0000;

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

/// Reads the chosen channel of a WAV file.
pub(super) fn decode(bytes: &[u8], opts: &ReadOptions) -> Result<Decoded, InputError> {
    let size64 = magic(bytes)?;
    let riff_end = u64::from(u32_at(bytes, 4).unwrap_or(0)) + 8;
    let mut layout: Option<Layout> = None;
    let mut data64 = None;
    let mut at = 12;
    while let Some(size) = u32_at(bytes, at + 4) {
        let id = &bytes[at..at + 4];
        let start = at + 8;
        let rest = bytes.len() - start;
        let body = &bytes[start..start + rest.min(size as usize)];
        match id {
            b"ds64" if size64 => data64 = u64_at(body, 8),
            b"fmt " => layout = Some(parse_fmt(body, at)?),
            b"data" => {
                let Some(layout) = layout else {
                    return Err(header(at, "the data come before the fmt chunk"));
                };
                let told = match size {
                    u32::MAX => data64,
                    0 if riff_end <= start as u64 || riff_end > u64::from(u32::MAX) => None,
                    size if size >= UNKNOWN_SIZE && size as usize > rest => None,
                    size => Some(u64::from(size)),
                };
                return samples(&bytes[start..], told, layout, at, opts);
            }
            _ => {}
        }
        if rest < size as usize {
            break;
        }
        at = next_chunk(bytes, start + size as usize, size);
    }
    let missing = if layout.is_some() { "data" } else { "fmt" };
    Err(InputError::new(
        Problem::Truncated,
        format!("byte {}", bytes.len()),
        format!("the file ends before its {missing} chunk"),
        "copy it again; nothing can be saved from it",
    ))
}

/// Checks the first twelve bytes; true for RF64.
fn magic(bytes: &[u8]) -> Result<bool, InputError> {
    let not = |what: &str| {
        Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            what,
            "convert it to WAV, or correct the extension",
        ))
    };
    let size64 = match bytes {
        b if b.len() < 4 && (b"RIFF".starts_with(b) || b"RF64".starts_with(b)) => false,
        [b'R', b'I', b'F', b'F', ..] => false,
        [b'R', b'F', b'6', b'4', ..] => true,
        [0x89, b'P', b'N', b'G', ..] => return not("not a WAV file but a PNG picture"),
        [b'f', b'L', b'a', b'C', ..] => return not("not a WAV file but FLAC"),
        [b'O', b'g', b'g', b'S', ..] => return not("not a WAV file but Ogg"),
        [b'I', b'D', b'3', ..] => return not("not a WAV file but MP3"),
        [b'R', b'I', b'F', b'X', ..] => return not("a big-endian WAV file (RIFX)"),
        _ => return not("not a WAV file: it does not begin with RIFF"),
    };
    match bytes.get(8..12) {
        Some(b"WAVE") => Ok(size64),
        Some(_) => not("a RIFF file, but not a WAVE"),
        None => Err(InputError::new(
            Problem::Truncated,
            format!("byte {}", bytes.len()),
            "the file ends inside its first header",
            "copy it again; nothing can be saved from it",
        )),
    }
}

/// Start of the chunk after one that ends at `end`. Odd chunks are padded to
/// even length; some writers forget, which shows in a chunk name right there.
fn next_chunk(bytes: &[u8], end: usize, size: u32) -> usize {
    if size.is_multiple_of(2) {
        return end;
    }
    let name = |at: usize| {
        bytes
            .get(at..at + 4)
            .is_some_and(|n| n.iter().all(|c| (b' '..=b'~').contains(c)))
    };
    if name(end) && !name(end + 1) {
        end
    } else {
        end + 1
    }
}

fn parse_fmt(body: &[u8], at: usize) -> Result<Layout, InputError> {
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
    body: &[u8],
    told: Option<u64>,
    layout: Layout,
    at: usize,
    opts: &ReadOptions,
) -> Result<Decoded, InputError> {
    let place = format!("data chunk (byte {at})");
    let mut notices = Vec::new();
    let fs = rate(layout, opts, &mut notices)?;
    if opts.channel >= layout.channels {
        return Err(no_channel("fmt chunk", opts.channel, layout.channels));
    }

    let here = body.len() as u64;
    let used = told.map_or(here, |told| told.min(here)) as usize;
    let frames = used / layout.frame;
    if frames == 0 {
        let (problem, what) = match told {
            Some(told) if told > here => (
                Problem::Truncated,
                format!("it says {told} bytes, but the file ends before one whole frame"),
            ),
            _ => (Problem::NoSamples, "it holds no samples".into()),
        };
        return Err(InputError::new(problem, place, what, "record again"));
    }
    let seconds = frames as f64 / fs;
    match told {
        None => notices.push(format!(
            "the header does not say how long the data are (streamed): \
             analysed {frames} frames ({seconds:.2} s), up to the end of the file"
        )),
        Some(told) if told > here => notices.push(format!(
            "data chunk says {} frames, file holds {frames}: \
             analysed {frames} ({seconds:.2} s), the rest is cut off",
            told / layout.frame as u64
        )),
        Some(_) if !used.is_multiple_of(layout.frame) => notices.push(format!(
            "the data end inside a frame: analysed {frames} whole frames ({seconds:.2} s)"
        )),
        Some(_) => {}
    }

    let first = opts.channel * layout.width;
    let one = |frame: &[u8]| value(&frame[first..first + layout.width], layout.float);
    let kind = if layout.float { "float" } else { "PCM" };
    Ok(Decoded {
        format: format!("WAV, {kind} {} bit", layout.bits),
        fs,
        samples: body[..used].chunks_exact(layout.frame).map(one).collect(),
        step: (!layout.float).then(|| 2_f64.powi(1 - layout.bits as i32)),
        channels: layout.channels,
        gaps: Vec::new(),
        notices,
    })
}

fn rate(layout: Layout, opts: &ReadOptions, notices: &mut Vec<String>) -> Result<f64, InputError> {
    match opts.fs {
        Some(fs) => {
            if fs != f64::from(layout.rate) {
                notices.push(format!(
                    "header says {} Hz: --fs {fs} Hz used instead",
                    layout.rate
                ));
            }
            Ok(fs)
        }
        None if layout.rate == 0 => Err(InputError::new(
            Problem::Rate,
            "fmt chunk",
            "the header says a sampling rate of 0 Hz",
            "give --fs in hertz",
        )),
        None => Ok(f64::from(layout.rate)),
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

fn header(at: usize, what: &str) -> InputError {
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
