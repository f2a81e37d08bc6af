//! Letters that are read from two metres away, of eight by eight pixels each.

use font8x8::legacy::BASIC_LEGACY;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Pixels of a letter along and up.
const PIXELS: u16 = 8;
/// The longest word of a state, `NO VERDICT`, has so many letters.
const LETTERS: u16 = 10;

/// How large a pixel is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Size {
    /// A word as any other.
    #[default]
    Small,
    /// A column wide and half a row high.
    Half,
    /// Two columns wide and a row high.
    Double,
}

impl Size {
    /// The largest that there is room for.
    pub(super) fn within(width: u16, height: u16, roomy: bool) -> Self {
        // The last column of a letter is blank.
        if roomy && width >= 2 * PIXELS * LETTERS {
            Self::Double
        } else if height >= 22 && width >= PIXELS * LETTERS {
            Self::Half
        } else {
            Self::Small
        }
    }

    /// Rows of a letter.
    pub(super) fn rows(self) -> u16 {
        match self {
            Self::Small => 1,
            Self::Half => PIXELS / 2,
            Self::Double => PIXELS,
        }
    }
}

/// Draws a word in capitals; what does not fit is cut.
pub(super) fn draw(word: &str, size: Size, style: Style, area: Rect, buffer: &mut Buffer) {
    if size == Size::Small {
        let word = word.chars().flat_map(|c| [c, ' ']).collect::<String>();
        buffer.set_stringn(area.x, area.y, word, area.width as usize, style);
        return;
    }
    let wide = if size == Size::Double { 2 } else { 1 };
    for (letter, place) in word.chars().zip(0..) {
        let glyph = BASIC_LEGACY.get(letter as usize).copied();
        let glyph = glyph.unwrap_or_default();
        let set = |x: u16, y: u16| glyph[y as usize] >> x & 1 == 1;
        for row in 0..size.rows() {
            for column in 0..PIXELS * wide {
                let x = column / wide;
                let (upper, lower) = match size {
                    Size::Double => (set(x, row), set(x, row)),
                    _ => (set(x, 2 * row), set(x, 2 * row + 1)),
                };
                let symbol = match (upper, lower) {
                    (true, true) => "█",
                    (true, false) => "▀",
                    (false, true) => "▄",
                    (false, false) => continue,
                };
                let at = (area.x + place * PIXELS * wide + column, area.y + row);
                if area.contains(at.into())
                    && let Some(cell) = buffer.cell_mut(at)
                {
                    cell.set_symbol(symbol).set_style(style);
                }
            }
        }
    }
}
