//! The plugin's arguments: `begin=ADDRESS`, `end=ADDRESS`, `out=FILE`.

use std::path::PathBuf;

/// What to count and where to write it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arguments {
    /// Counting starts with the instruction here.
    pub begin: u64,
    /// Counting ends before the instruction here.
    pub end: u64,
    /// The report's file.
    pub out: PathBuf,
}

impl Arguments {
    /// Reads `name=value` words.
    ///
    /// # Errors
    /// Names the word that is wrong or missing.
    pub fn parse<'a>(words: impl Iterator<Item = &'a str>) -> Result<Self, String> {
        let (mut begin, mut end, mut out) = (None, None, None);
        for word in words {
            match word.split_once('=') {
                Some(("begin", value)) => begin = Some(address(value)?),
                Some(("end", value)) => end = Some(address(value)?),
                Some(("out", value)) => out = Some(PathBuf::from(value)),
                _ => {
                    return Err(format!(
                        "unknown argument `{word}`; known are begin=, end=, out="
                    ));
                }
            }
        }
        Ok(Self {
            begin: begin.ok_or("begin=ADDRESS is missing")?,
            end: end.ok_or("end=ADDRESS is missing")?,
            out: out.ok_or("out=FILE is missing")?,
        })
    }
}

/// A hexadecimal address of Thumb code, whose bit 0 is no part of the place.
fn address(text: &str) -> Result<u64, String> {
    u64::from_str_radix(text.trim_start_matches("0x"), 16)
        .map(|address| address & !1)
        .map_err(|why| format!("`{text}` is no hexadecimal address: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_addresses_without_the_thumb_bit() {
        let read = Arguments::parse(["begin=0x101", "end=200", "out=a.txt"].into_iter());
        assert_eq!(
            read,
            Ok(Arguments {
                begin: 0x100,
                end: 0x200,
                out: "a.txt".into()
            })
        );
    }

    #[test]
    fn names_what_is_wrong() {
        assert!(
            Arguments::parse(["begin=1", "end=2"].into_iter())
                .is_err_and(|why| why.contains("out="))
        );
        assert!(Arguments::parse(["begin=x"].into_iter()).is_err_and(|why| why.contains("`x`")));
        assert!(Arguments::parse(["color=1"].into_iter()).is_err_and(|why| why.contains("color")));
    }
}
