//! Raw little-endian samples: no header, so the rate comes from the caller.

use super::blocks::{Begin, Blocks, End};
use super::bytes::Bytes;
use super::{InputError, Problem, no_channel};

/// Kind of one number.
#[derive(Clone, Copy)]
pub(super) enum Width {
    S16,
    F32,
    F64,
}

impl Width {
    fn bytes(self) -> usize {
        match self {
            Self::S16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::S16 => "16 bit integers",
            Self::F32 => "32 bit floats",
            Self::F64 => "64 bit floats",
        }
    }
}

/// Samples handed on at once.
const BLOCK: usize = 1 << 13;

/// All of `bytes` as one channel.
pub(super) fn begin(bytes: Bytes, fs: Option<f64>, width: Width) -> Result<Begin, InputError> {
    let Some(fs) = fs else {
        return Err(InputError::new(
            Problem::Rate,
            "header",
            "a raw file has none, so its sampling rate is unknown",
            "give --fs in hertz",
        ));
    };
    Ok(Begin {
        format: match width {
            Width::S16 => "raw, PCM 16 bit little endian".to_owned(),
            _ => format!("raw, float {} bit little endian", 8 * width.bytes()),
        },
        fs: Some(fs),
        step: matches!(width, Width::S16).then(|| 2_f64.powi(-15)),
        channels: 1,
        blocks: Box::new(Numbers { bytes, fs, width }),
    })
}

struct Numbers {
    bytes: Bytes,
    fs: f64,
    width: Width,
}

impl Blocks for Numbers {
    fn want(&mut self, _channels: &[usize]) {}

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        let size = self.width.bytes();
        while self.bytes.waiting().len() < size {
            if !self.bytes.more()? {
                return Ok(false);
            }
        }
        let whole = (self.bytes.waiting().len() / size).min(BLOCK) * size;
        let data = &self.bytes.waiting()[..whole];
        for row in rows {
            match self.width {
                Width::S16 => row.extend(
                    (data.as_chunks().0.iter())
                        .map(|&w| f64::from(i16::from_le_bytes(w)) / 32768.0),
                ),
                Width::F32 => {
                    row.extend(
                        (data.as_chunks().0.iter()).map(|&w| f64::from(f32::from_le_bytes(w))),
                    );
                }
                Width::F64 => {
                    row.extend((data.as_chunks().0.iter()).map(|&w| f64::from_le_bytes(w)));
                }
            }
        }
        self.bytes.take(whole);
        Ok(true)
    }

    fn end(&mut self) -> Result<End, InputError> {
        let rest = self.bytes.waiting().len();
        if rest != 0 {
            return Err(InputError::new(
                Problem::Truncated,
                format!("byte {}", self.bytes.at()),
                format!(
                    "{} bytes are no whole number of {}, {rest} left over",
                    self.bytes.at() + rest as u64,
                    self.width.name()
                ),
                "copy it again, or check that the extension tells the right width",
            ));
        }
        Ok(End {
            fs: self.fs,
            notices: Vec::new(),
        })
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        no_channel("raw file", asked, channels)
    }
}
