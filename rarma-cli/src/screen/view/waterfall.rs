//! The spectrum over time: frequency along, time downwards, the newest on top.

use super::palette::Palette;
use super::text::{heading, put_right};
use crate::screen::model::Model;
use crate::screen::spectrum::{ROW_S, Row};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use std::sync::Arc;

/// Levels from the loudest down to here are told apart, dB.
const RANGE_DB: f32 = 50.0;
/// A small picture shows the time of so many rows all the same: the loudest of several in each.
const LEAST_ROWS: usize = 40;
/// Columns between two numbers of the axis at least.
const APART: u16 = 10;

/// Draws a heading, the rows, and the axis below them.
pub(super) fn draw(model: &Model, area: Rect, palette: Palette, buffer: &mut Buffer) {
    if area.height < 3 {
        return;
    }
    let rows = Rect {
        y: area.y + 1,
        height: area.height - 2,
        ..area
    };
    let most = loudest(model);
    let title = match (model.waterfall.rows.front(), most) {
        (Some(Row::Modes(_)), _) => "modes over time (`stream SECONDS`: the spectrum)".to_owned(),
        _ => format!("spectrum, {RANGE_DB:.0} dB, newest on top"),
    };
    heading(&title, palette.dim(), area, buffer);
    let per_row = if palette == Palette::Many { 2 } else { 1 };
    let lines = (rows.height * per_row) as usize;
    let group = LEAST_ROWS.div_ceil(lines);
    let seconds = (lines * group) as f64 * ROW_S;
    put_right(
        &format!(" {seconds:.1} s ─"),
        palette.dim(),
        area,
        0,
        buffer,
    );
    let lines = grouped(model, group);
    for row in 0..rows.height {
        let line = |k: u16| lines.get((row * per_row + k) as usize).map(Vec::as_slice);
        for column in 0..rows.width {
            let at = |k| {
                let each = line(k)?.iter();
                let levels = each.map(|row| level(row, column, rows.width, model.band_hz, most));
                levels.reduce(f32::max)
            };
            let cell = buffer.cell_mut((rows.x + column, rows.y + row));
            let (Some(cell), Some(upper)) = (cell, at(0)) else {
                continue;
            };
            match (palette.heat(upper), at(1)) {
                (Some(above), lower) if per_row == 2 => {
                    let style = Style::new().fg(above);
                    let below = lower.and_then(|lower| palette.heat(lower));
                    cell.set_symbol("▀");
                    cell.set_style(below.map_or(style, |below| style.bg(below)));
                }
                _ => drop(cell.set_char(Palette::shade(upper))),
            }
        }
    }
    axis(model, area, palette, buffer);
}

/// Rows that go into one line of the picture, the newest first. A row stays with its neighbours as
/// it goes down.
fn grouped(model: &Model, group: usize) -> Vec<Vec<&Row>> {
    let waterfall = &model.waterfall;
    let mut lines: Vec<Vec<&Row>> = Vec::new();
    let mut last = None;
    for (row, back) in waterfall.rows.iter().zip(1..) {
        let number = (waterfall.count - back) / group as u64;
        if last != Some(number) {
            last = Some(number);
            lines.push(Vec::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push(row);
        }
    }
    lines
}

/// The highest level there is, dB.
fn loudest(model: &Model) -> f32 {
    let levels = model.waterfall.rows.iter().filter_map(|row| match row {
        Row::Levels(levels) => Some(levels),
        Row::Modes(_) => None,
    });
    let all = levels.flat_map(|levels: &Arc<[f32]>| levels.iter().copied());
    all.fold(f32::MIN, f32::max)
}

/// The level in a column, 0 to 1.
fn level(row: &Row, column: u16, columns: u16, band_hz: (f64, f64), most: f32) -> f32 {
    match row {
        Row::Levels(levels) => {
            let place = |column: u16| column as usize * levels.len() / columns as usize;
            let (from, to) = (place(column), place(column + 1));
            let here = &levels[from..to.max(from + 1).min(levels.len())];
            let db = here.iter().copied().fold(f32::MIN, f32::max);
            ((db - most) / RANGE_DB + 1.0).clamp(0.0, 1.0)
        }
        Row::Modes(modes) => {
            let here = |f: &f64| self::column(*f, columns, band_hz) == Some(column);
            if modes.iter().any(here) { 0.8 } else { 0.0 }
        }
    }
}

/// The column of a frequency.
fn column(f: f64, columns: u16, (low, high): (f64, f64)) -> Option<u16> {
    let x = (f - low) / (high - low);
    (0.0..1.0)
        .contains(&x)
        .then(|| (x * f64::from(columns)) as u16)
}

/// Round frequencies, and marks of the modes above them.
fn axis(model: &Model, area: Rect, palette: Palette, buffer: &mut Buffer) {
    let y = area.bottom() - 1;
    let (low, high) = model.band_hz;
    let steps = [1.0, 2.0, 5.0].into_iter();
    let steps = (0..6).flat_map(|e| steps.clone().map(move |m| m * 10_f64.powi(e)));
    let room = f64::from(area.width / APART).max(1.0);
    let step = steps.clone().find(|step| (high - low) / step <= room);
    let Some(step) = step else { return };
    let mut f = (low / step).ceil() * step;
    while f < high {
        if let Some(x) = column(f, area.width, model.band_hz) {
            let text = format!("╵{f:.0}");
            let text = if f + step >= high { text + " Hz" } else { text };
            let room = (area.width - x) as usize;
            if text.chars().count() <= room {
                buffer.set_string(area.x + x, y, text, palette.dim());
            }
        }
        f += step;
    }
    for mode in model.line.iter().flat_map(|line| &line.modes) {
        if let Some(x) = column(mode.f, area.width, model.band_hz)
            && let Some(cell) = buffer.cell_mut((area.x + x, y))
        {
            // A digit stays.
            let digit = ![" ", "▲"].contains(&cell.symbol());
            if digit {
                cell.set_style(palette.accent().add_modifier(Modifier::REVERSED));
            } else {
                cell.set_symbol("▲").set_style(palette.accent());
            }
        }
    }
}
