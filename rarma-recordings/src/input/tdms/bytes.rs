//! What describes a file's channels, number by number.

use super::kind::Kind;
use super::object::Property;

/// Bytes in order.
pub(super) struct Bytes<'a> {
    bytes: &'a [u8],
    pub(super) at: usize,
    pub(super) big: bool,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8], big: bool) -> Self {
        Self { bytes, at: 0, big }
    }

    pub(super) fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(n)?)?;
        self.at += n;
        Some(taken)
    }

    fn whole<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = self.take(N)?.try_into().ok()?;
        if self.big {
            bytes.reverse();
        }
        Some(bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.whole().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.whole().map(u64::from_le_bytes)
    }

    pub(super) fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// A property's value; the code of its type where it is not known how long it is.
    pub(super) fn property(&mut self) -> Option<Result<Property, u32>> {
        let code = self.u32()?;
        Some(Ok(match Kind::of(code) {
            _ if code == 0 => Property::Other,
            Some(Kind::Text) => Property::Text(self.text()?),
            Some(Kind::Other(size)) => {
                self.take(size as usize)?;
                Property::Other
            }
            Some(kind) => {
                let bytes = self.take(kind.size()? as usize)?;
                Property::Number(kind.value(bytes, self.big))
            }
            None => return Some(Err(code)),
        }))
    }
}
