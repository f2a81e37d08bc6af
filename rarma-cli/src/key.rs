//! A key of the link in a file: 64 hexadecimal digits.

use crate::failure::Failure;
use rarma_box::wire::{KEY_BYTES, LinkKey};
use std::path::Path;

/// Reads a key.
///
/// # Errors
/// No such file, or no key in it; in one line, without a digit of it.
pub fn read(path: &Path) -> Result<LinkKey, Failure> {
    let bytes = std::fs::read(path).map_err(|why| {
        let why = why.to_string().to_lowercase();
        Failure::Input(format!("{}: open: {why}", path.display()))
    })?;
    parse(&bytes).map_err(|why| {
        Failure::Input(format!(
            "{}: line 1: {why} (make a key with `openssl rand -hex {KEY_BYTES}`)",
            path.display()
        ))
    })
}

fn parse(bytes: &[u8]) -> Result<LinkKey, String> {
    let digits = bytes.trim_ascii();
    if digits.len() != 2 * KEY_BYTES {
        let n = digits.len();
        return Err(format!(
            "{n} characters where a key has {} hexadecimal digits",
            2 * KEY_BYTES
        ));
    }
    let mut key = [0; KEY_BYTES];
    for (k, (byte, pair)) in key.iter_mut().zip(digits.as_chunks::<2>().0).enumerate() {
        let text = std::str::from_utf8(pair).ok();
        *byte = text
            .filter(|text| text.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|text| u8::from_str_radix(text, 16).ok())
            .ok_or_else(|| {
                format!(
                    "characters {} and {} are no hexadecimal digits",
                    2 * k + 1,
                    2 * k + 2
                )
            })?;
    }
    if key.iter().all(|byte| *byte == key[0]) {
        return Err("the same byte all through is no key".to_owned());
    }
    Ok(LinkKey(key))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_become_a_key_and_the_rest_is_refused_without_showing_it() {
        let text = "00112233445566778899aabbccddeeff00112233445566778899AABBCCDDEEFF\n";
        let LinkKey(key) = parse(text.as_bytes()).unwrap();
        assert_eq!((key[0], key[1], key[31]), (0x00, 0x11, 0xFF));
        for (bad, says) in [
            ("", "0 characters"),
            (&text[1..], "63 characters"),
            (&text.replace("33", "3g"), "characters 7 and 8"),
            (&text.replace("33", "+3"), "characters 7 and 8"),
            (&"a5".repeat(32), "the same byte"),
        ] {
            let why = parse(bad.as_bytes()).unwrap_err();
            assert!(why.contains(says), "{why}");
            assert!(!why.contains("4455"), "{why}");
        }
    }
}
