//! A message stays one line, whatever it quotes.

use std::fmt::{self, Write as _};

/// A text in which every control character is spelled out: names and fields come from
/// outside, and a line break in one of them must not turn a line into two, nor an escape code
/// reach the terminal.
#[derive(Debug, Clone, Copy)]
pub struct OneLine<'a>(pub &'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            if c.is_control() {
                write!(f, "{}", c.escape_default())?;
            } else {
                f.write_char(c)?;
            }
        }
        Ok(())
    }
}

/// JSON with every control character spelled out: it may stand as it is from 127 on, and
/// what a terminal makes of it is another matter.
pub fn json(json: String) -> String {
    if !json.contains(char::is_control) {
        return json;
    }
    let each = json.chars().map(|c| match c {
        c if c.is_control() => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_keeps_control_characters_from_the_terminal() {
        let out = json("{\"board\":\"a\u{7f}b\u{9b}2Jc\"}".to_owned());
        assert_eq!(out, "{\"board\":\"a\\u007fb\\u009b2Jc\"}");
        let read: serde_json::Value = serde_json::from_str(&out).unwrap();
        assert_eq!(read["board"], "a\u{7f}b\u{9b}2Jc");
    }
}
