//! A message stays one line, whatever it quotes.

use std::fmt::{self, Write as _};

/// A text in which every control character is spelled out: names and fields come from
/// outside, and a line break in one of them must not turn a line into two, nor an escape code
/// reach the terminal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OneLine<'a>(pub(crate) &'a str);

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
