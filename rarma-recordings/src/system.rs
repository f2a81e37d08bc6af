//! Words for what the system refuses.

use std::io;

/// What the system says, without its number: `input/output error`.
pub fn system_words(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::ConnectionReset {
        return "the other end closed the connection".to_owned();
    }
    let words = error.to_string();
    let plain = words.split(" (os error ").next().unwrap_or(&words);
    plain.to_lowercase()
}
