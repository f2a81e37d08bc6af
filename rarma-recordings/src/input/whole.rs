//! Files that are read at once: those that people write, and tables of readings.

use super::{InputError, Problem};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// No table of readings is larger than this, bytes.
pub(super) const MOST_TABLE: u64 = 1 << 28;

/// The bytes of a file of at most `most` bytes.
///
/// # Errors
/// It cannot be read, or is larger.
pub fn bytes(path: &Path, most: u64) -> Result<Vec<u8>, InputError> {
    let load = || {
        let failed = |why| InputError::from_io(&why);
        let mut file = File::open(path).map_err(failed)?;
        let mut bytes = Vec::new();
        // One more than is allowed tells; a device has no size to be asked for.
        let end = file.by_ref().take(most + 1).read_to_end(&mut bytes);
        end.map_err(failed)?;
        if bytes.len() as u64 > most {
            return Err(InputError::new(
                Problem::Size,
                format!("byte {most}"),
                format!("the file goes on, and none of its kind has more than {most} bytes"),
                "check that it is the right file",
            ));
        }
        Ok(bytes)
    };
    load().map_err(|why| why.in_file(path))
}

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// As [`bytes`], or it is not text in UTF-8: which line.
pub fn text(path: &Path, most: u64) -> Result<String, InputError> {
    utf8(bytes(path, most)?).map_err(|why| why.in_file(path))
}

/// Bytes as text.
///
/// # Errors
/// They are not UTF-8: from where on.
pub(super) fn utf8(bytes: Vec<u8>) -> Result<String, InputError> {
    String::from_utf8(bytes).map_err(|why| {
        let at = why.utf8_error().valid_up_to();
        let line = 1 + why.as_bytes()[..at].iter().filter(|b| **b == b'\n').count();
        not_text(format!("line {line} (byte {at})"))
    })
}

/// What stands there is not UTF-8.
pub(super) fn not_text(place: String) -> InputError {
    InputError::new(
        Problem::NotThisFormat,
        place,
        "this is not plain text",
        "save it as UTF-8",
    )
}
