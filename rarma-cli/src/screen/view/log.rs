//! Advice, and the log of alarms, notices and answers.

use super::palette::Palette;
use super::text::{heading, put, wrapped};
use crate::report::words::Tone;
use crate::screen::keys::Ui;
use crate::screen::model::{Entry, Kind, Model};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Span;

/// Columns of the time before a line.
const TIME: usize = 11;

/// What to do, in lines that fit already.
pub(super) fn advice(lines: &[String], area: Rect, palette: Palette, buffer: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    heading("what to do", palette.dim(), area, buffer);
    let below = Rect {
        y: area.y + 1,
        height: area.height - 1,
        ..area
    };
    let room = below.height as usize;
    let mut shown = lines.iter().take(room).cloned().collect::<Vec<_>>();
    if let Some(last) = shown.last_mut().filter(|_| lines.len() > room) {
        last.push('…');
    }
    self::lines(&shown, below, buffer);
}

/// Lines one below the other.
pub(super) fn lines(lines: &[String], area: Rect, buffer: &mut Buffer) {
    for (line, row) in lines.iter().zip(0..) {
        put(Span::raw(format!(" {line}")), area, row, buffer);
    }
}

/// The newest lines of the log that there is room for, the newest at the bottom.
pub(super) fn draw(model: &Model, ui: &Ui, area: Rect, palette: Palette, buffer: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let older = if ui.scroll > 0 {
        " (older; PgDn goes on)"
    } else {
        ""
    };
    let title = match model.alarms {
        0 => format!("log: no alarm{older}"),
        1 => format!("log: 1 alarm{older}"),
        n => format!("log: {n} alarms{older}"),
    };
    heading(&title, palette.dim(), area, buffer);
    let room = (area.height - 1) as usize;
    let mut lines: Vec<(String, Style)> = Vec::new();
    // From the newest back, as many as are needed.
    for entry in model
        .log
        .iter()
        .rev()
        .skip(ui.scroll.min(model.log.len().saturating_sub(1)))
    {
        let style = style(entry.kind, palette);
        let these = entry_lines(entry, area.width as usize);
        lines.extend(these.into_iter().rev().map(|line| (line, style)));
        if lines.len() >= room {
            break;
        }
    }
    lines.truncate(room);
    for ((line, style), row) in lines.into_iter().rev().zip(1..) {
        put(Span::styled(line, style), area, row, buffer);
    }
}

fn entry_lines(entry: &Entry, width: usize) -> Vec<String> {
    let time = match entry.t_s {
        Some(t_s) => format!("{t_s:8.2} s "),
        None => " ".repeat(TIME),
    };
    let sign = match entry.kind {
        Kind::Alarm => Tone::Bad.sign(),
        Kind::Released => Tone::Good.sign(),
        Kind::Notice => Tone::Careful.sign(),
        Kind::Said => ">",
        Kind::Answer => " ",
    };
    let wide = width.saturating_sub(TIME + 3);
    let lines = wrapped(&entry.text, wide).into_iter().enumerate();
    lines
        .map(|(k, line)| match k {
            0 => format!("{time} {sign} {line}"),
            _ => format!("{}   {line}", " ".repeat(TIME)),
        })
        .collect()
}

fn style(kind: Kind, palette: Palette) -> Style {
    match kind {
        Kind::Alarm => palette.words(Tone::Bad),
        Kind::Released => palette.words(Tone::Good),
        Kind::Notice => palette.words(Tone::Careful),
        Kind::Said => palette.accent(),
        Kind::Answer => Style::new(),
    }
}
