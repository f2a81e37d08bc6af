//! Records of a box (`.frames`): the raw samples in them, as a recording.

use super::{Decoded, InputError, Problem, ReadOptions, no_channel};
use crate::frames::{FrameReader, RawSamples};

pub(super) fn decode(bytes: &[u8], opts: &ReadOptions) -> Result<Decoded, InputError> {
    if opts.channel != 0 {
        return Err(no_channel("record", opts.channel, 1));
    }
    let mut reader = FrameReader::default();
    let mut raw = RawSamples::default();
    reader.take(bytes, |_, message| raw.take(&message));
    let mut notices = Vec::new();
    if let Some(losses) = reader.losses() {
        notices.push(losses);
    }
    if reader.whole == 0 {
        return Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "there is no whole frame in it",
            "make a record with `rarma connect --record`",
        ));
    }
    let (samples, missing) = raw.joined();
    if missing > 0 {
        notices.push(format!(
            "{missing} samples are missing; zeros stand in their place"
        ));
    }
    if samples.is_empty() {
        return Err(InputError::new(
            Problem::NoSamples,
            "end of file",
            "the record holds no raw samples",
            "send `stream SECONDS` while it is made",
        ));
    }
    let Some(fs) = opts.fs.or(raw.fs_hz) else {
        return Err(InputError::new(
            Problem::Rate,
            "end of file",
            "the record does not say the sampling rate",
            "give --fs in hertz",
        ));
    };
    Ok(Decoded {
        format: "frames of a box".to_owned(),
        fs,
        samples: samples.into_iter().map(f64::from).collect(),
        step: Some(1.0 / 32767.0),
        channels: 1,
        notices,
    })
}
