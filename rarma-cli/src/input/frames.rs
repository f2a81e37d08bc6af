//! Records of a box (`.frames`): the raw samples in them, as a recording.

use super::bytes::Bytes;
use super::stream::{Begin, Whole};
use super::{InputError, Problem};
use crate::frames::{FrameReader, RawSamples};

pub(super) fn begin(mut bytes: Bytes, fs: Option<f64>) -> Result<Begin, InputError> {
    let mut reader = FrameReader::default();
    let mut raw = RawSamples::default();
    while !bytes.waiting().is_empty() || bytes.more()? {
        let here = bytes.waiting();
        reader.take(here, |_, message| raw.take(&message));
        let taken = here.len();
        bytes.take(taken);
    }
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
    let Some(fs) = fs.or(raw.fs_hz) else {
        return Err(InputError::new(
            Problem::Rate,
            "end of file",
            "the record does not say the sampling rate",
            "give --fs in hertz",
        ));
    };
    Ok(Begin {
        format: "frames of a box".to_owned(),
        fs: Some(fs),
        step: Some(1.0 / 32767.0),
        channels: 1,
        blocks: Box::new(Whole {
            fs,
            notices,
            samples: samples.into_iter().map(f64::from).collect(),
            given: 0,
            place: "record",
        }),
    })
}
