//! The seal of a command: what only a host with the box's key can write.
//!
//! HMAC-SHA-256 over the whole frame before it (head, speaker, command), its first 16 bytes.
//! It says who made the frame, not that it is new: the numbers in the head and the turn of
//! control, which the box draws, say that.

use core::fmt;
use hmac::{Hmac, KeyInit, Mac};
use serde::{Deserialize, Serialize};
use sha2::Sha256;

/// Bytes of a key.
pub const KEY_BYTES: usize = 32;
/// Bytes of a seal.
pub const SEAL_BYTES: usize = 16;

/// A key that box and host share. It is never shown.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkKey(pub [u8; KEY_BYTES]);

impl fmt::Debug for LinkKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LinkKey")
    }
}

impl LinkKey {
    fn mac(&self, bytes: &[u8]) -> Option<Hmac<Sha256>> {
        // Any length of key will do for an HMAC; this cannot fail.
        let mut mac = Hmac::<Sha256>::new_from_slice(&self.0).ok()?;
        mac.update(bytes);
        Some(mac)
    }

    /// The seal of so many bytes.
    pub(crate) fn seal(&self, bytes: &[u8]) -> Option<[u8; SEAL_BYTES]> {
        let whole = self.mac(bytes)?.finalize().into_bytes();
        whole.first_chunk().copied()
    }

    /// Whether a seal is this key's, in a time that does not depend on where it differs.
    fn made(&self, bytes: &[u8], seal: &[u8]) -> bool {
        seal.len() == SEAL_BYTES
            && self
                .mac(bytes)
                .is_some_and(|mac| mac.verify_truncated_left(seal).is_ok())
    }
}

/// What stands at the end of a frame, and what it is to vouch for.
#[derive(Debug, Clone, Copy)]
pub struct Seal<'a> {
    pub(crate) signed: &'a [u8],
    pub(crate) seal: &'a [u8],
}

impl Seal<'_> {
    /// Whether it is there and made with this key.
    pub fn is_of(&self, key: &LinkKey) -> bool {
        key.made(self.signed, self.seal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4231, test case 2, whose key is shorter: filled with zeros, an HMAC's key is the
    /// same.
    #[test]
    fn the_published_example() {
        let mut key = LinkKey([0; KEY_BYTES]);
        key.0[..4].copy_from_slice(b"Jefe");
        let text = b"what do ya want for nothing?";
        let expected = [
            0x5b, 0xdc, 0xc1, 0x46, 0xbf, 0x60, 0x75, 0x4e, 0x6a, 0x04, 0x24, 0x26, 0x08, 0x95,
            0x75, 0xc7,
        ];
        assert_eq!(key.seal(text), Some(expected));
        assert!(key.made(text, &expected));
        assert!(!key.made(text, &expected[..15]));
        assert!(!key.made(text, &[]));
        assert!(!key.made(&text[1..], &expected));
        assert!(!LinkKey([1; KEY_BYTES]).made(text, &expected));
        assert_eq!(format!("{key:?}"), "LinkKey");
    }
}
