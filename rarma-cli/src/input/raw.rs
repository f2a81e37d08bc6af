//! Raw little-endian floats: no header, so the rate comes from the caller.

use super::{Decoded, InputError, Problem, ReadOptions, no_channel};

/// Size of one number.
#[derive(Clone, Copy)]
pub(super) enum Width {
    F32,
    F64,
}

/// Reads all of `bytes` as one channel of floats.
pub(super) fn decode(
    bytes: &[u8],
    opts: &ReadOptions,
    width: Width,
) -> Result<Decoded, InputError> {
    let (size, bits) = match width {
        Width::F32 => (4, 32),
        Width::F64 => (8, 64),
    };
    let Some(fs) = opts.fs else {
        return Err(InputError::new(
            Problem::Rate,
            "header",
            "a raw file has none, so its sampling rate is unknown",
            "give --fs in hertz",
        ));
    };
    if opts.channel != 0 {
        return Err(no_channel("raw file", opts.channel, 1));
    }
    let rest = bytes.len() % size;
    if rest != 0 {
        return Err(InputError::new(
            Problem::Truncated,
            format!("byte {}", bytes.len() - rest),
            format!(
                "{} bytes are no whole number of {bits} bit floats, {rest} left over",
                bytes.len()
            ),
            "copy it again, or check that the extension tells the right width",
        ));
    }
    let samples = match width {
        Width::F32 => floats32(bytes),
        Width::F64 => floats64(bytes),
    };
    Ok(Decoded {
        format: format!("raw, float {bits} bit little endian"),
        fs,
        samples,
        step: None,
        channels: 1,
        gaps: Vec::new(),
        notices: Vec::new(),
    })
}

fn floats32(bytes: &[u8]) -> Vec<f64> {
    let (words, _) = bytes.as_chunks::<4>();
    words
        .iter()
        .map(|&w| f32::from_le_bytes(w).into())
        .collect()
}

fn floats64(bytes: &[u8]) -> Vec<f64> {
    let (words, _) = bytes.as_chunks::<8>();
    words.iter().map(|&w| f64::from_le_bytes(w)).collect()
}
