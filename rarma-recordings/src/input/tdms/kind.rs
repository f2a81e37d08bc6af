//! What a value is: numbers of every kind, and what is stepped over.

/// Type of a channel's values. Numbers with a unit are numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
    /// No real number, of so many bytes: truth values, times, complex numbers.
    Other(u64),
    /// Each has a length of its own.
    Text,
}

impl Kind {
    /// By its code in the file; none where it is not known how long one is.
    pub(super) fn of(code: u32) -> Option<Self> {
        Some(match code {
            0x01 => Self::I8,
            0x02 => Self::I16,
            0x03 => Self::I32,
            0x04 => Self::I64,
            0x05 => Self::U8,
            0x06 => Self::U16,
            0x07 => Self::U32,
            0x08 => Self::U64,
            0x09 | 0x19 => Self::F32,
            0x0a | 0x1a => Self::F64,
            0x20 => Self::Text,
            0x21 => Self::Other(1),
            0x44 | 0x10_000d => Self::Other(16),
            0x08_000c => Self::Other(8),
            _ => return None,
        })
    }

    /// Bytes of a value; none where each has its own.
    pub(super) fn size(self) -> Option<u64> {
        Some(match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
            Self::Other(bytes) => bytes,
            Self::Text => return None,
        })
    }

    /// It is a real number.
    pub(super) fn is_number(self) -> bool {
        !matches!(self, Self::Other(_) | Self::Text)
    }

    /// The value at the beginning of `bytes`, whose most significant byte comes first if `big`; NaN
    /// where it is no number, or bytes are missing.
    pub(super) fn value(self, bytes: &[u8], big: bool) -> f64 {
        let size = self.size().unwrap_or(0) as usize;
        let mut eight = [0; 8];
        let Some((to, from)) = eight.get_mut(..size).zip(bytes.get(..size)) else {
            return f64::NAN;
        };
        to.copy_from_slice(from);
        if big {
            to.reverse();
        }
        let whole = u64::from_le_bytes(eight);
        match self {
            Self::I8 => f64::from(whole as i8),
            Self::I16 => f64::from(whole as i16),
            Self::I32 => f64::from(whole as i32),
            Self::I64 => whole as i64 as f64,
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => whole as f64,
            Self::F32 => f64::from(f32::from_bits(whole as u32)),
            Self::F64 => f64::from_bits(whole),
            Self::Other(_) | Self::Text => f64::NAN,
        }
    }
}
