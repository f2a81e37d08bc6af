//! Lines that fit.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

/// A text in lines of at most so many columns, broken between words; a longer word is cut.
pub(super) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let long = Span::raw(word).width();
        let Some(line) = lines.last_mut() else { break };
        let before = Span::raw(line.as_str()).width();
        if before == 0 {
            line.push_str(word);
        } else if before + 1 + long <= width {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

/// [`wrapped`], one text after the other.
pub(super) fn wrapped_all(texts: &[String], width: usize) -> Vec<String> {
    texts.iter().flat_map(|text| wrapped(text, width)).collect()
}

/// A line from the left; what does not fit is cut.
pub(super) fn put(line: impl Into<Line<'static>>, area: Rect, row: u16, buffer: &mut Buffer) {
    if row < area.height {
        buffer.set_line(area.x, area.y + row, &line.into(), area.width);
    }
}

/// A line that ends at the right.
pub(super) fn put_right(text: &str, style: Style, area: Rect, row: u16, buffer: &mut Buffer) {
    let width = (Span::raw(text).width() as u16).min(area.width);
    let place = Rect {
        x: area.right() - width,
        width,
        ..area
    };
    put(Span::styled(text.to_owned(), style), place, row, buffer);
}

/// A heading over the width of a part: `── modes ──────`.
pub(super) fn heading(text: &str, style: Style, area: Rect, buffer: &mut Buffer) {
    let rule = "─".repeat(area.width as usize);
    put(Span::styled(rule, style), area, 0, buffer);
    if area.width > 4 {
        let inner = Rect {
            x: area.x + 2,
            width: area.width - 2,
            ..area
        };
        put(Span::styled(format!(" {text} "), style), inner, 0, buffer);
    }
}
